//! Reacts to limit switches and the emergency stop before any other code runs.
//!
//! # Design
//! Through the HAL's GPIO interrupt, an executor and a task, an edge takes 9 us to stop the steps, and longer while the
//! core is busy. So a state machine of PIO1 watches all inputs (`program`). At every change it raises an interrupt that
//! has the highest priority. The handler reports the change to the machine, which engages the brake immediately. Only a
//! critical section delays it. The tasks that watch the same inputs do the rest: debouncing, and what takes time.
//!
//! A press counts however short it is: the handler is told the levels that came with each change, not those that there
//! are by then. So an input on pins apart from the others, or any number of them, can have a state machine of its own
//! with the same program; its levels would come through its own FIFO.

mod edges;
mod program;

use core::cell::Cell;
use core::sync::atomic::AtomicU32;

use embassy_rp::interrupt;
use embassy_rp::pac::PIO1;
use embassy_rp::{Peri, peripherals};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use isostep_motion::{AXES, Axis, Contact, Machine};

use self::edges::Changes;
use crate::{pins, priority};

/// Number of inputs: the axes' limit switches, then the emergency stop. They are on consecutive pins.
const INPUTS: usize = AXES + 1;
const EMERGENCY_STOP: usize = AXES;

const STATE_MACHINE: usize = 0;

static GUARDED: Mutex<CriticalSectionRawMutex, Cell<Option<&Machine>>> = Mutex::new(Cell::new(None));

/// The levels that were reported last; at first those of limit switches that are open, and of an emergency stop that is
/// not pressed.
static TOLD: AtomicU32 = AtomicU32::new(match pins::EMERGENCY_CONTACT {
    Contact::NormallyOpen => (1 << INPUTS) - 1,
    Contact::NormallyClosed => (1 << EMERGENCY_STOP) - 1,
});

/// Guards `machine` from now on.
pub fn start(machine: &'static Machine, pio: Peri<'static, peripherals::PIO1>) {
    GUARDED.lock(|guarded| guarded.set(Some(machine)));
    let watch = program::watch(INPUTS as u8);
    for (address, &instruction) in watch.code.iter().enumerate() {
        PIO1.instr_mem(address).write(|slot| slot.set_instr_mem(instruction));
    }
    let watcher = PIO1.sm(STATE_MACHINE);
    watcher.execctrl().write(|exec| {
        exec.set_wrap_bottom(watch.wrap.target);
        exec.set_wrap_top(watch.wrap.source);
    });
    watcher.shiftctrl().write(|shift| {
        shift.set_in_shiftdir(false);
        shift.set_fjoin_rx(true);
    });
    watcher.pinctrl().write(|pins| pins.set_in_base(pins::LIMIT_X));
    for instruction in [program::KNOW_NOTHING, program::go_to(watch.wrap.target)] {
        watcher.instr().write(|slot| slot.set_instr(instruction));
    }
    PIO1.irqs(1).inte().write(|sources| sources.0 = 1 << STATE_MACHINE);
    PIO1.ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() | 1 << STATE_MACHINE));
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

/// What the state machine has seen.
struct Seen;

impl Changes for Seen {
    fn are_there(&mut self) -> bool {
        PIO1.fstat().read().rxempty() & 1 << STATE_MACHINE == 0
    }

    fn take(&mut self) -> u32 {
        PIO1.rxf(STATE_MACHINE).read()
    }
}

/// Handles a change. If there are more, it is called again.
#[interrupt]
fn PIO1_IRQ_1() {
    let Some((changed, levels)) = edges::take(&mut Seen, &TOLD) else { return };
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
