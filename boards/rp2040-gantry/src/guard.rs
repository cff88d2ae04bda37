//! Reacts to limit switches and the emergency stop before any other code runs.
//!
//! # Design
//! Through the HAL's GPIO interrupt, an executor and a task, an edge takes 9 us to stop the steps, and longer while the
//! core is busy. So a state machine of PIO1 watches each input. At every edge it raises an interrupt that has the
//! highest priority. The handler reports the edge to the machine, which engages the brake immediately. Only a critical
//! section delays it. The tasks that watch the same inputs do the rest: debouncing, and what takes time.

use core::cell::Cell;

use embassy_rp::interrupt;
use embassy_rp::pac::pio::regs;
use embassy_rp::pac::{PIO1, SIO};
use embassy_rp::pio::program::pio_asm;
use embassy_rp::{Peri, peripherals};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use isostep_motion::{AXES, Axis, Machine};

use crate::edges::{self, Inputs};
use crate::{pins, priority};

/// Number of inputs: the axes' limit switches, then the emergency stop. They are on consecutive pins, with a state
/// machine each.
const INPUTS: usize = AXES + 1;
const EMERGENCY_STOP: usize = AXES;

const _: () = assert!(INPUTS <= 4, "a PIO block has four state machines");

static GUARDED: Mutex<CriticalSectionRawMutex, Cell<Option<&Machine>>> = Mutex::new(Cell::new(None));

/// Guards `machine` from now on.
pub fn start(machine: &'static Machine, pio: Peri<'static, peripherals::PIO1>) {
    GUARDED.lock(|guarded| guarded.set(Some(machine)));
    let listen = pio_asm!(
        ".origin 0",
        ".wrap_target",
        "wait 1 pin 0",
        "irq nowait 0 rel",
        "wait 0 pin 0",
        "irq nowait 0 rel",
        ".wrap",
    );
    for (address, &instruction) in listen.program.code.iter().enumerate() {
        PIO1.instr_mem(address).write(|slot| slot.set_instr_mem(instruction));
    }
    for input in 0..INPUTS {
        let listener = PIO1.sm(input);
        listener.execctrl().write(|exec| {
            exec.set_wrap_bottom(listen.program.wrap.target);
            exec.set_wrap_top(listen.program.wrap.source);
        });
        listener.pinctrl().write(|pins| pins.set_in_base(pins::LIMIT_X + input as u8));
    }
    PIO1.irqs(1).inte().write_value(regs::Intr(flags_of_all() << 8));
    PIO1.ctrl().write(|ctrl| ctrl.set_sm_enable(flags_of_all() as u8));
    priority::enable_guard();
    // The guard keeps the PIO for ever.
    let _ = pio;
}

/// A reset byte has arrived. The console will report it to the machine later.
pub fn reset_heard() {
    if let Some(machine) = GUARDED.lock(Cell::get) {
        machine.reset_heard();
    }
}

const fn flags_of_all() -> u32 {
    (1 << INPUTS) - 1
}

/// The inputs that the state machines watch.
struct Guarded;

impl Inputs for Guarded {
    fn flags(&mut self) -> u8 {
        PIO1.irq().read().irq()
    }

    fn clear(&mut self, flags: u8) {
        PIO1.irq().write_value(regs::Irq(flags.into()));
    }

    fn levels(&mut self) -> u32 {
        SIO.gpio_in(0).read() >> pins::LIMIT_X
    }
}

/// Handles edges. An input that changes again in the meantime sets its flag again.
#[interrupt]
fn PIO1_IRQ_1() {
    let (changed, levels) = edges::take(&mut Guarded);
    let Some(machine) = GUARDED.lock(Cell::get) else { return };
    let has_changed = |input: usize| changed & 1 << input != 0;
    let is_low = |input: usize| levels & 1 << input == 0;
    if has_changed(EMERGENCY_STOP) {
        machine.emergency_stop_edge(is_low(EMERGENCY_STOP));
    }
    for axis in Axis::ALL.into_iter().filter(|&axis| has_changed(axis as usize)) {
        machine.limit_edge(axis, is_low(axis as usize));
    }
}
