//! Reacts to limit switches and the emergency stop before any other code runs.
//!
//! # Design
//! Through the HAL's GPIO interrupt, an executor and a task, an edge takes 9 us to stop the steps, and longer while the
//! core is busy. So a state machine of PIO1 watches all inputs (`program`). At every change it raises an interrupt that
//! has the highest priority. The handler reports the change to the machine, which engages the brake immediately. Only a
//! critical section delays it. The tasks that watch the same inputs do the rest: debouncing, and what takes time.
//!
//! A press counts however short it is: the handler is told the levels that came with each change, not those that there
//! are by then. The fourth motor's switch is on a pin apart from the others, so it has a state machine of its own with
//! the same program, and its levels come through its own FIFO.

mod edges;
mod program;

use core::cell::Cell;
use core::sync::atomic::AtomicU32;

use embassy_rp::interrupt;
use embassy_rp::pac::PIO1;
use embassy_rp::{Peri, peripherals};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use isostep_motion::{Axis, Contact, LimitInput, Machine};

use self::edges::Changes;
use crate::{pins, priority};

/// The limit switches of X, Y and Z, then the emergency stop.
static SWITCHES: Watcher = Watcher::new(0, 0, pins::LIMIT_X, EMERGENCY_STOP as u8 + 1, SWITCHES_AT_REST);
const EMERGENCY_STOP: usize = 3;
/// Limit switches that are open, and an emergency stop that is not pressed.
const SWITCHES_AT_REST: u32 = match pins::EMERGENCY_CONTACT {
    Contact::NormallyOpen => (1 << (EMERGENCY_STOP + 1)) - 1,
    Contact::NormallyClosed => (1 << EMERGENCY_STOP) - 1,
};

/// The fourth motor's limit switch. Its program stands behind that of the others.
static FOURTH_SWITCH: Watcher = Watcher::new(2, 6, pins::FOURTH_LIMIT, 1, 1);
/// A proving image has no fourth motor, and other work for the state machine.
const WATCHERS: usize = if cfg!(feature = "prove") { 1 } else { 2 };
/// Whose it is.
#[cfg(not(feature = "four-axes"))]
pub const FOURTH: LimitInput = LimitInput::Second;
#[cfg(feature = "four-axes")]
pub const FOURTH: LimitInput = LimitInput::Of(Axis::A);

static GUARDED: Mutex<CriticalSectionRawMutex, Cell<Option<&Machine>>> = Mutex::new(Cell::new(None));

/// A state machine that watches consecutive pins.
struct Watcher {
    state_machine: usize,
    /// The address of its program.
    origin: u8,
    first_pin: u8,
    pins: u8,
    /// The levels that were reported last; at first those at rest.
    told: AtomicU32,
}

/// Guards `machine` from now on.
pub fn start(machine: &'static Machine, pio: Peri<'static, peripherals::PIO1>) {
    GUARDED.lock(|guarded| guarded.set(Some(machine)));
    // One call, so that it is inlined into code that runs once.
    [&SWITCHES, &FOURTH_SWITCH].into_iter().take(WATCHERS).for_each(Watcher::start);
    priority::enable_guard();
    // The guard keeps the PIO for ever.
    let _ = pio;
}

/// A reset byte has arrived. The console will report it to the machine later.
pub fn reset_heard() {
    #[cfg(feature = "prove")]
    crate::prove::reset_seen();
    if let Some(machine) = GUARDED.lock(Cell::get) {
        machine.reset_heard();
    }
}

impl Watcher {
    const fn new(state_machine: usize, origin: u8, first_pin: u8, pins: u8, at_rest: u32) -> Self {
        Self { state_machine, origin, first_pin, pins, told: AtomicU32::new(at_rest) }
    }

    fn start(&self) {
        let (origin, watch) = (self.origin, program::watch(self.pins));
        for (address, &instruction) in (usize::from(origin)..).zip(watch.code.iter()) {
            PIO1.instr_mem(address).write(|slot| slot.set_instr_mem(program::moved(instruction, origin)));
        }
        let watcher = PIO1.sm(self.state_machine);
        watcher.execctrl().write(|exec| {
            exec.set_wrap_bottom(origin + watch.wrap.target);
            exec.set_wrap_top(origin + watch.wrap.source);
        });
        watcher.shiftctrl().write(|shift| {
            shift.set_in_shiftdir(false);
            shift.set_fjoin_rx(true);
        });
        watcher.pinctrl().write(|pins| pins.set_in_base(self.first_pin));
        for instruction in [program::KNOW_NOTHING, program::go_to(origin + watch.wrap.target)] {
            watcher.instr().write(|slot| slot.set_instr(instruction));
        }
        PIO1.irqs(1).inte().modify(|sources| sources.0 |= 1 << self.state_machine);
        PIO1.ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() | 1 << self.state_machine));
    }

    /// The inputs that have changed, and the levels that came with the change.
    #[inline(always)]
    fn take(&self) -> Option<(u32, u32)> {
        edges::take(&mut Seen(self.state_machine), &self.told)
    }
}

/// What a state machine has seen.
struct Seen(usize);

impl Changes for Seen {
    fn are_there(&mut self) -> bool {
        PIO1.fstat().read().rxempty() & 1 << self.0 == 0
    }

    fn take(&mut self) -> u32 {
        PIO1.rxf(self.0).read()
    }
}

/// Handles a change of each state machine. If there are more, it is called again.
#[interrupt]
fn PIO1_IRQ_1() {
    let Some(machine) = GUARDED.lock(Cell::get) else { return };
    if let Some((changed, levels)) = SWITCHES.take() {
        let has_changed = |input: usize| changed & 1 << input != 0;
        let is_low = |input: usize| levels & 1 << input == 0;
        if has_changed(EMERGENCY_STOP) {
            machine.emergency_stop_edge(is_low(EMERGENCY_STOP));
        }
        for axis in [Axis::X, Axis::Y, Axis::Z].into_iter().filter(|&axis| has_changed(axis as usize)) {
            machine.limit_edge(LimitInput::Of(axis), is_low(axis as usize));
        }
    }
    if WATCHERS > 1
        && let Some((_, levels)) = FOURTH_SWITCH.take()
    {
        machine.limit_edge(FOURTH, levels == 0);
    }
}
