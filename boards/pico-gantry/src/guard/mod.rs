//! Reacts to limit switches, the alarm of drives and the emergency stop before any other code runs.
//!
//! # Design
//! Through the HAL's GPIO interrupt, an executor and a task, an edge takes 9 us to stop the steps, and longer while the
//! core is busy. So state machines of PIO1 watch all inputs (`program`). At every change they raise an interrupt that
//! has the highest priority. The handler asks whether the change stops the machine, which takes no lock, and if so it
//! inhibits the axes and the tool. Then it reports the change to the machine, which stops it and decides on the alarm. Only a
//! critical section delays it (`stops_at_limit` in isostep-motion says why no lock is needed). The tasks that watch the same inputs do the rest: debouncing, and what takes time.
//!
//! A press counts however short it is: the handler is told the levels that came with each change, not those that there
//! are by then. Each group of pins next to each other has a state machine of its own with the same program, and its levels
//! come through its own FIFO.

mod edges;
mod program;

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_rp::interrupt;
use embassy_rp::pac::PIO1;
use embassy_rp::{Peri, peripherals};
use embassy_sync::once_lock::OnceLock;
use isostep_motion::{Axis, Contact, LimitInput, Machine};

use self::edges::Changes;
use crate::pins::{self, Group};
#[cfg(not(feature = "timer-port"))]
use crate::pio_port as port;
#[cfg(feature = "timer-port")]
use crate::timer_port as port;
use crate::{priority, tool};

/// The pins that are watched: a proving image has no fourth motor, and other work for its state machine.
const PINS: [usize; if cfg!(feature = "prove") { 4 } else { pins::LIMIT_INPUTS + 1 }] = pins::ascending([
    pins::LIMITS[0],
    pins::LIMITS[1],
    pins::LIMITS[2],
    pins::EMERGENCY_STOP,
    pins::LIMITS[3],
    #[cfg(any(five_motors, drive_alarm))]
    pins::LIMITS[4],
]);
const GROUPS: [Group; pins::count_groups(&PINS)] = pins::groups(&PINS);
/// One for each group. The output watchdog has the second.
const STATE_MACHINES: [usize; 3] = [0, 2, 3];
/// The instructions of a state machine's program.
const INSTRUCTIONS: u8 = 6;

/// What is on `pins::LIMITS`.
pub const LIMIT_INPUTS: [LimitInput; pins::LIMIT_INPUTS] = [
    LimitInput::Of(Axis::X),
    LimitInput::Of(Axis::Y),
    LimitInput::Of(Axis::Z),
    FOURTH,
    #[cfg(five_motors)]
    LimitInput::Second,
    #[cfg(drive_alarm)]
    LimitInput::Alarm(Axis::X),
];
#[cfg(not(feature = "four-axes"))]
const FOURTH: LimitInput = LimitInput::Second;
#[cfg(feature = "four-axes")]
const FOURTH: LimitInput = LimitInput::Of(Axis::A);
const LIMITS: [Place; PINS.len() - 1] = {
    let (mut places, mut limit) = ([Place { group: 0, bit: 0 }; PINS.len() - 1], 0);
    while limit < places.len() {
        places[limit] = Place::of(pins::LIMITS[limit]);
        limit += 1;
    }
    places
};
const EMERGENCY_STOP: Place = Place::of(pins::EMERGENCY_STOP);

static WATCHERS: [Watcher; GROUPS.len()] = {
    let (mut watchers, mut index) = ([const { Watcher::of(0) }; GROUPS.len()], 0);
    while index < GROUPS.len() {
        watchers[index] = Watcher::of(index);
        index += 1;
    }
    watchers
};

/// Set once, and read without a lock.
static GUARDED: OnceLock<&Machine> = OnceLock::new();

/// The place where the level of an input is reported.
#[derive(Clone, Copy)]
struct Place {
    group: usize,
    bit: usize,
}

impl Place {
    const fn of(pin: usize) -> Self {
        let mut group = 0;
        while pin >= GROUPS[group].first + GROUPS[group].pins {
            group += 1;
        }
        Self { group, bit: pin - GROUPS[group].first }
    }
}

/// A state machine that watches a group of pins.
struct Watcher {
    state_machine: usize,
    /// The levels that were reported last; at first those at rest.
    reported: AtomicU32,
}

/// Guards `machine` from now on.
pub fn start(machine: &'static Machine, pio: Peri<'static, peripherals::PIO1>) {
    // It is started once.
    let _ = GUARDED.init(machine);
    WATCHERS.iter().zip(0..).for_each(|(watcher, index)| watcher.start(index, machine.emergency_contact()));
    priority::enable_guard();
    // The guard keeps the PIO for ever.
    let _ = pio;
}

/// A reset byte has arrived. The console will report it to the machine later.
pub fn reset_heard() {
    #[cfg(feature = "prove")]
    crate::prove::reset_seen();
    if let Some(machine) = GUARDED.try_get() {
        let stops = machine.stops_at_reset();
        cortex_m::interrupt::free(|_| {
            if stops {
                port::inhibit_all();
            }
            // The first one switches the tool off, too.
            tool::inhibit(true);
        });
        machine.reset_heard();
    }
}

impl Watcher {
    const fn of(index: usize) -> Self {
        Self { state_machine: STATE_MACHINES[index], reported: AtomicU32::new(0) }
    }

    /// `index` is that of its group. Limit inputs are open at rest, and the emergency stop is not pressed.
    fn start(&self, index: usize, emergency_contact: Contact) {
        let Group { first, pins } = GROUPS[index];
        let open = (1 << pins) - 1;
        let at_rest = match emergency_contact {
            Contact::NormallyClosed if EMERGENCY_STOP.group == index => open & !(1 << EMERGENCY_STOP.bit),
            _ => open,
        };
        self.reported.store(at_rest, Ordering::Relaxed);
        let (origin, watch) = (INSTRUCTIONS * index as u8, program::watch(pins as u8));
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
        watcher.pinctrl().write(|pins| pins.set_in_base(first as u8));
        for instruction in [program::KNOW_NOTHING, program::go_to(origin + watch.wrap.target)] {
            watcher.instr().write(|slot| slot.set_instr(instruction));
        }
        PIO1.irqs(1).inte().modify(|sources| sources.0 |= 1 << self.state_machine);
        PIO1.ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() | 1 << self.state_machine));
    }

    /// The inputs that have changed, and the levels that came with the change.
    #[inline(always)]
    fn take(&self) -> Option<(u32, u32)> {
        edges::take(&mut Seen(self.state_machine), &self.reported)
    }
}

/// The changes that a state machine has seen.
struct Seen(usize);

impl Changes for Seen {
    fn are_there(&mut self) -> bool {
        PIO1.fstat().read().rxempty() & 1 << self.0 == 0
    }

    fn take(&mut self) -> u32 {
        PIO1.rxf(self.0).read()
    }
}

/// Handles a change of each group. If there are more, it is called again.
#[interrupt]
fn PIO1_IRQ_1() {
    let Some(machine) = GUARDED.try_get() else { return };
    // One by one: a loop would read its tables from flash.
    tell::<0>(machine);
    if GROUPS.len() > 1 {
        tell::<1>(machine);
    }
    if GROUPS.len() > 2 {
        tell::<2>(machine);
    }
}

/// Tells the machine which inputs of a group have changed. Which are in it is known to the compiler.
#[inline(always)]
fn tell<const GROUP: usize>(machine: &Machine) {
    let Some((changed, levels)) = WATCHERS.get(GROUP).and_then(Watcher::take) else { return };
    let has_changed = |Place { group, bit }: Place| group == GROUP && changed & 1 << bit != 0;
    let is_low = |Place { bit, .. }: Place| levels & 1 << bit == 0;
    let is_heeded =
        |which: LimitInput, place: Place| has_changed(place) && machine.stops_at_limit(which, is_low(place));
    let is_emergency =
        has_changed(EMERGENCY_STOP) && is_low(EMERGENCY_STOP) == machine.emergency_contact().pressed_is_low();
    let mut stops = is_emergency && machine.stops_at_emergency();
    stops |= is_heeded(const { LIMIT_INPUTS[0] }, const { LIMITS[0] });
    stops |= is_heeded(const { LIMIT_INPUTS[1] }, const { LIMITS[1] });
    stops |= is_heeded(const { LIMIT_INPUTS[2] }, const { LIMITS[2] });
    #[cfg(not(feature = "prove"))]
    {
        stops |= is_heeded(const { LIMIT_INPUTS[3] }, const { LIMITS[3] });
    }
    #[cfg(any(five_motors, drive_alarm))]
    {
        stops |= is_heeded(const { LIMIT_INPUTS[4] }, const { LIMITS[4] });
    }
    if stops {
        port::inhibit_all();
        tool::inhibit(true);
    }
    if has_changed(EMERGENCY_STOP) {
        machine.emergency_stop_edge(is_low(EMERGENCY_STOP));
    }
    let limit = |which: LimitInput, place: Place| {
        if has_changed(place) {
            machine.limit_edge(which, is_low(place));
        }
    };
    limit(const { LIMIT_INPUTS[0] }, const { LIMITS[0] });
    limit(const { LIMIT_INPUTS[1] }, const { LIMITS[1] });
    limit(const { LIMIT_INPUTS[2] }, const { LIMITS[2] });
    #[cfg(not(feature = "prove"))]
    limit(const { LIMIT_INPUTS[3] }, const { LIMITS[3] });
    #[cfg(any(five_motors, drive_alarm))]
    limit(const { LIMIT_INPUTS[4] }, const { LIMITS[4] });
}
