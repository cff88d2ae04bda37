//! The whole machine in virtual time: the controller's own tasks, a console, and the world around them.

mod streamed;
mod tasks;

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use embassy_time::{Duration, Instant};
use isostep_controller::Store;
use isostep_motion::{AXES, Axis, LimitInput, Machine, Motor, State};

use self::tasks::{spawn_consoles, spawn_motion};
use crate::config::{Config, StartOutside};
use crate::drivers::{DriverFault, DriverSetup, DriverWire};
use crate::executor::{Executor, Preemption, Priority, Rest, RunError};
use crate::faults::Fault;
use crate::flash::{FLASH_BYTES, Flash};
use crate::link::{Lines, Pipe};
use crate::outcome::Outcome;
use crate::plant::SwitchFault;
use crate::plate::Plate;
use crate::program::{Program, ProgramError};
use crate::record::{Record, VfdFrame, Wire};
use crate::stream::Dialogue;
use crate::suffering;
use crate::vfd::{Vfd, VfdFault, VfdLine};
use crate::world::{self, Shared, World};

pub use self::streamed::{Silencer, Streamed};

const RESET: u8 = 0x18;

/// The interval at which a run reports its progress, in virtual time.
const WATCHED_EVERY: Duration = Duration::from_secs(1);

/// The reason why a run has no outcome.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimError {
    /// The file is not a program.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A carriage cannot start at the given position.
    #[error(transparent)]
    Start(#[from] StartOutside),
    /// The run did not end.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The controller did not answer.
    #[error("line {line} `{text}` was never answered; these tasks wait: {}", .waiting.join(", "))]
    Unanswered {
        /// Line number in the program, from 1.
        line: usize,
        /// Its text.
        text: String,
        /// The tasks that have not ended.
        waiting: Vec<&'static str>,
    },
    /// A tool that a line has asked for was put in and could not be measured, so that the program does not go on.
    #[error(
        "line {line} `{text}`: the tool cannot be measured at G59.3 ($341=3): {why}; --probe-plate Z,20,below puts a plate there"
    )]
    ToolNotMeasured {
        /// Line number in the program, from 1.
        line: usize,
        /// Its text.
        text: String,
        /// The machine's own words.
        why: String,
    },
    /// The controller did not answer because of an earlier line of the program.
    #[error("line {line} `{text}` was never answered, as line {} `{}` {}: take it out of the program", .by.line, .by.text, .by.effect)]
    Silenced {
        /// Number of the line without an answer, from 1.
        line: usize,
        /// Its text.
        text: String,
        /// The line that caused it.
        by: Silencer,
    },
}

/// Streams `program` to a machine just after power-up, and runs until everything is answered and at rest.
///
/// A refused line or an alarm is not an error here: see the outcome.
///
/// # Errors
/// [`SimError`].
pub fn run(program: &[u8], config: &Config) -> Result<Outcome, SimError> {
    run_with(program, config, Flash::blank())
}

/// As [`run`], with a flash. Settings in the flash are in force.
///
/// # Errors
/// [`SimError`].
pub fn run_with(program: &[u8], config: &Config, flash: Flash) -> Result<Outcome, SimError> {
    run_watched(Program::read(program)?, config, flash, &mut |_| {})
}

/// As [`run_with`], for the lines of a program. Calls `watch` every second of virtual time with the progress.
///
/// # Errors
/// [`SimError`].
pub fn run_watched(
    program: Program,
    config: &Config,
    flash: Flash,
    watch: &mut dyn FnMut(Progress),
) -> Result<Outcome, SimError> {
    config.check()?;
    Sim::with_flash(config, flash).stream(program, watch)
}

/// Progress of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Lines answered.
    pub answered: usize,
    /// Virtual time since power-up, ns.
    pub t_ns: u64,
}

/// A simulated machine for step-by-step use: call `send`, run, then check `replies`.
///
/// ```
/// use isostep_sim::{Config, Sim};
///
/// let mut sim = Sim::new(&Config::default());
/// sim.send(b"G0 X1\n");
/// sim.run_until_idle()?;
/// assert_eq!(sim.replies().last().unwrap(), "ok");
/// assert_eq!(sim.counted_steps(), [50, 0, 0]);
/// # Ok::<(), isostep_sim::RunError>(())
/// ```
pub struct Sim {
    executor: Executor,
    world: Shared,
    machine: Rc<Machine>,
    config: Config,
    consoles: Vec<Console>,
}

/// An event that can be made to come between two critical sections.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stimulus {
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The limit switch of an axis gets a fault; stuck closed is the same as pressed.
    Switch(Axis, SwitchFault),
    /// The drive of an axis is in alarm.
    Drive(Axis),
    /// Bytes arrive at the first console. A reset byte among them is detected at once.
    Bytes(Vec<u8>),
}

/// When a stimulus came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Came {
    /// Time, ns since power-up.
    pub at_ns: u64,
    /// The state of the machine then.
    pub state: State,
    /// True if an interrupt of a board would have inhibited for it, before anything was decided.
    pub inhibits: bool,
}

/// The host's end of a console's link.
#[derive(Default)]
struct Console {
    to_controller: Pipe,
    from_controller: Pipe,
    /// Gets one byte each time a host opens the console.
    opened: Pipe,
    heard: Lines,
}

impl Sim {
    /// A machine at its first power-up.
    ///
    /// # Panics
    /// If a carriage cannot start at the position in `config`: see [`Config::check`].
    pub fn new(config: &Config) -> Self {
        Self::with_flash(config, Flash::blank())
    }

    /// A machine at power-up with the flash of an earlier machine. What is not in the flash comes from `config`.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    pub fn with_flash(config: &Config, flash: Flash) -> Self {
        config.check().unwrap_or_else(|error| panic!("{error}"));
        let mut executor = Executor::new();
        let _current = executor.clock().clone().enter();
        let world = Rc::new(RefCell::new(World::new(executor.clock().clone(), config)));
        let machine = spawn_motion(&mut executor, &world, config);
        let consoles: Vec<_> = (0..=usize::from(config.second_console)).map(|_| Console::default()).collect();
        // Faults that exist from the start must be there before the controller runs.
        let hosts: Vec<_> = consoles.iter().map(|console| console.from_controller.clone()).collect();
        for &fault in &config.faults {
            suffering::spawn(&mut executor, fault, config.seed, &world, hosts.clone());
        }
        let store = Store::new(flash, 0..FLASH_BYTES as u32, config.settings);
        let drivers = config.board.uart_drivers().map(|hardware| (hardware, DriverWire::new(&world, executor.clock())));
        let vfd = VfdLine::new(&world, executor.clock());
        let parts = (store, drivers, config.one_alarm_wire, vfd);
        spawn_consoles(&mut executor, &machine, parts, &consoles, config.baud);
        executor.spawn_at(Priority::World, "bounce", world::bounce(world.clone()));
        if let Some(section_max_ns) = config.section_max_ns {
            let changed = world.clone();
            // While a task changes the simulated world, no code of the chip runs.
            let open = Box::new(move || changed.try_borrow_mut().is_ok());
            executor.preempt(Preemption { open, section_max_ns, seed: config.seed });
        }
        Self { executor, world, machine, config: config.clone(), consoles }
    }

    /// Sends bytes to the first console.
    pub fn send(&mut self, bytes: &[u8]) {
        self.send_to(0, bytes);
    }

    /// Sends bytes to the console with this index; the second console is 1.
    ///
    /// # Panics
    /// If there is no such console. The same applies to all functions with a console's index.
    pub fn send_to(&mut self, console: usize, bytes: &[u8]) {
        self.consoles[console].to_controller.push(bytes);
    }

    /// Number of sent bytes that the controller has not read yet.
    pub fn unread(&self) -> usize {
        self.unread_of(0)
    }

    /// As [`unread`](Self::unread), for the console with this index.
    pub(crate) fn unread_of(&self, console: usize) -> usize {
        self.consoles[console].to_controller.len()
    }

    /// Opens the console, as a host does when DTR rises. It starts again with the welcome, and bytes on the wires are
    /// lost.
    pub fn open_console(&mut self) {
        let console = &self.consoles[0];
        console.to_controller.take();
        console.from_controller.take();
        console.opened.push(&[0]);
    }

    /// The bytes that came from the controller since the last call.
    pub fn received(&mut self) -> Vec<u8> {
        self.consoles[0].from_controller.take()
    }

    /// The lines that the controller completed since the last call, without empty ones.
    pub fn replies(&mut self) -> Vec<String> {
        self.replies_of(0)
    }

    /// As [`replies`](Self::replies), for the console with this index.
    pub fn replies_of(&mut self, console: usize) -> Vec<String> {
        let Console { heard, from_controller, .. } = &mut self.consoles[console];
        heard.push(&from_controller.take())
    }

    /// Number of critical sections that have ended, if tasks are interrupted: see [`Config::section_max_ns`].
    pub fn sections(&self) -> u64 {
        self.executor.sections()
    }

    /// Applies `stimulus` after this many more critical sections. The returned cell is set when it has come.
    ///
    /// # Panics
    /// If tasks are not interrupted.
    pub fn after_sections(&mut self, sections: u64, stimulus: Stimulus) -> Rc<Cell<Option<Came>>> {
        let came = Rc::new(Cell::new(None));
        let (reported, machine, clock) = (came.clone(), self.machine.clone(), self.executor.clock().clone());
        let (world, pipe) = (self.world.clone(), self.consoles[0].to_controller.clone());
        self.executor.after_sections(sections, move || {
            let inhibits = match &stimulus {
                Stimulus::EmergencyStop => machine.stops_at_emergency(),
                Stimulus::Switch(axis, _) => machine.stops_at_limit(LimitInput::Of(*axis), true),
                Stimulus::Drive(axis) => {
                    let wire = Wire::DriveAlarm(*axis);
                    machine.stops_at_limit(LimitInput::Alarm(*axis), world.borrow().is_high(wire))
                }
                Stimulus::Bytes(bytes) => bytes.contains(&RESET) && machine.stops_at_reset(),
            };
            reported.set(Some(Came { at_ns: clock.now_ns(), state: machine.state(), inhibits }));
            match stimulus {
                Stimulus::EmergencyStop => world.borrow_mut().set_hand_input(Wire::EmergencyStop, true),
                Stimulus::Switch(axis, fault) => world.borrow_mut().set_switch(axis, fault),
                Stimulus::Drive(axis) => world.borrow_mut().set_drive(axis.into(), true),
                Stimulus::Bytes(bytes) => {
                    // A board does this in an interrupt.
                    if bytes.contains(&RESET) {
                        machine.reset_heard();
                    }
                    pipe.push(&bytes);
                }
            }
        });
        came
    }

    /// Discards the stimuli that have not come yet.
    pub(crate) fn forget_stimuli(&mut self) {
        self.executor.forget_stimuli();
    }

    /// Runs for exactly `duration`.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_for(&mut self, duration: Duration) -> Result<(), RunError> {
        self.executor.run_for(duration)
    }

    /// Runs to exactly `at_ns` since power-up. Does not run if that is in the past.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_to(&mut self, at_ns: u64) -> Result<(), RunError> {
        self.executor.run_to(at_ns)
    }

    /// Runs until nothing can happen unless something is sent or pressed.
    ///
    /// # Errors
    /// [`RunError::TimeLimit`] when that takes longer than the configuration allows; [`RunError::Livelock`].
    pub fn run_until_idle(&mut self) -> Result<(), RunError> {
        let limit = self.now() + self.config.time_limit;
        match self.executor.run_until_quiescent(limit)? {
            Rest::Quiescent => Ok(()),
            Rest::Horizon => Err(RunError::TimeLimit { limit, waiting: self.executor.waiting() }),
        }
    }

    /// Runs until the machine is in a state for which `wanted` is true.
    ///
    /// # Errors
    /// [`RunError`]; a deadlock if the machine never reaches such a state.
    pub fn run_until_state(&mut self, wanted: impl Fn(State) -> bool) -> Result<(), RunError> {
        let limit = self.now() + self.config.time_limit;
        let machine = self.machine.clone();
        self.executor.run_until(limit, || wanted(machine.state()))
    }

    /// Sets or mends what is wrong with a UART driver; of other boards nothing.
    pub fn set_driver(&mut self, motor: impl Into<Motor>, fault: Option<DriverFault>) {
        self.world.borrow_mut().set_driver(motor.into(), fault);
    }

    /// Sets or mends what is wrong with the VFD; without one nothing.
    pub fn set_vfd(&mut self, fault: Option<VfdFault>) {
        self.world.borrow_mut().set_vfd(fault);
    }

    /// Calls `f` with the VFD as it is now.
    ///
    /// # Panics
    /// If there is none.
    pub fn vfd<R>(&self, f: impl FnOnce(&mut Vfd) -> R) -> R {
        f(self.world.borrow_mut().vfd().expect("a VFD is connected"))
    }

    /// From now on `outside` replies to frames instead of the simulated VFD: with nothing, if it does not.
    pub fn connect_vfd(&mut self, outside: impl FnMut(&[u8]) -> Vec<u8> + 'static) {
        self.world.borrow_mut().connect_vfd(Box::new(outside));
    }

    /// Every frame that was on the wire to the VFD.
    pub fn vfd_frames(&self) -> Vec<VfdFrame> {
        self.world.borrow().record().vfd.clone()
    }

    /// True if a motor's driver has switched it off, or is switched off itself; never, if it has no UART.
    pub(crate) fn is_driver_off(&self, motor: Motor) -> bool {
        self.world.borrow().is_driver_off(motor)
    }

    /// The settings of a UART driver, in the order of the axes, then the fourth motor's; `None` on other boards.
    pub fn driver_setup(&self, driver: usize) -> Option<DriverSetup> {
        self.world.borrow().drivers().map(|wire| wire[driver].setup())
    }

    /// Presses or releases the emergency stop.
    pub fn set_emergency_stop(&mut self, pressed: bool) {
        self.set_hand_input(Wire::EmergencyStop, pressed);
    }

    /// Cuts the wire of the emergency stop, or mends it.
    pub fn cut_emergency_stop(&mut self, is_cut: bool) {
        self.world.borrow_mut().cut_emergency_stop(is_cut);
    }

    /// Presses or releases a button, opens or closes the safety door, or sets the probe's contact by hand.
    pub fn set_hand_input(&mut self, wire: Wire, pressed: bool) {
        self.world.borrow_mut().set_hand_input(wire, pressed);
    }

    /// Something begins to be wrong with a drive that closes its own loop, or is mended: it stays in alarm until it is reset.
    pub fn set_drive(&mut self, motor: impl Into<Motor>, is_wrong: bool) {
        self.world.borrow_mut().set_drive(motor.into(), is_wrong);
    }

    /// Cuts the wire of an axis's alarm, or mends it; that of X, where one is for all.
    pub fn cut_drive_alarm(&mut self, axis: Axis, is_cut: bool) {
        self.world.borrow_mut().cut_drive_alarm(axis, is_cut);
    }

    /// Sets or removes the plate that the probe can touch.
    pub fn set_plate(&mut self, plate: Option<Plate>) {
        self.world.borrow_mut().set_plate(plate);
    }

    /// The present duties of the tool's outputs, of 65,535, in the order of
    /// [`ToolOutput::ALL`](crate::tool::ToolOutput::ALL).
    pub fn tool(&self) -> [u16; 5] {
        self.world.borrow().tool()
    }

    /// Sets or clears a fault of the limit switch of an axis, or of a motor; stuck closed is the same as pressed.
    pub fn set_switch(&mut self, motor: impl Into<Motor>, fault: SwitchFault) {
        self.world.borrow_mut().set_switch(motor, fault);
    }

    /// Applies a fault, which also ends by itself if it has a duration.
    pub fn suffer(&mut self, fault: Fault) {
        let hosts = self.consoles.iter().map(|console| console.from_controller.clone()).collect();
        suffering::spawn(&mut self.executor, fault, self.config.seed, &self.world, hosts);
    }

    /// The present instant.
    pub fn now(&self) -> Instant {
        self.executor.clock().now()
    }

    /// The present time in nanoseconds since power-up.
    pub fn now_ns(&self) -> u64 {
        self.executor.clock().now_ns()
    }

    /// The state that the controller's tasks share.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The steps counted per axis, from power-up or since it was homed.
    pub fn counted_steps(&self) -> [i32; AXES] {
        self.world.borrow().counted_steps()
    }

    /// The steps made per axis in both directions, since power-up.
    pub fn steps(&self) -> [u64; AXES] {
        self.world.borrow().steps()
    }

    /// Number of recorded events, except those of moves and runs.
    pub fn events(&self) -> usize {
        self.world.borrow().record().events.len()
    }

    /// Number of runs that have begun.
    pub fn runs(&self) -> usize {
        self.world.borrow().record().moves.runs()
    }

    /// True position of each carriage, steps from where its limit switch closes.
    pub fn places_steps(&self) -> [i32; AXES] {
        self.world.borrow().places_steps()
    }

    /// The same of the second motor, if there is one.
    pub fn second_place_steps(&self) -> Option<i32> {
        self.world.borrow().second_place_steps()
    }

    /// The lead of the second motor on the first, mm away from their switches; 0 is square. `None` without a second
    /// motor.
    pub fn skew_mm(&self) -> Option<f64> {
        self.world.borrow().skew_mm()
    }

    /// Position of each carriage when its limit switch last closed, steps from the switch's nominal position.
    pub(crate) fn closed_at_steps(&self) -> [i32; AXES] {
        self.world.borrow().closed_at_steps()
    }

    /// Everything recorded so far, and the present state.
    pub fn outcome(&self) -> Outcome {
        self.world.borrow_mut().settle();
        let record = self.world.borrow().record().clone();
        self.outcome_of(record, Default::default())
    }

    /// The record since this was asked last, of moves those that nothing can change any more, so that the memory of a
    /// long run stays bounded: see [`verify::Gathered`](crate::verify::Gathered).
    pub fn take_piece(&mut self) -> Outcome {
        let record = self.world.borrow_mut().take_settled(self.config.only_time, self.config.port.tolerance_ns());
        self.outcome_of(record, Default::default())
    }

    /// Streams a program to its end, from the present state on. If it waits for the operator, it is resumed at once.
    ///
    /// # Errors
    /// [`SimError::Run`], [`SimError::Silenced`] and [`SimError::Unanswered`].
    fn stream(self, program: Program, watch: &mut dyn FnMut(Progress)) -> Result<Outcome, SimError> {
        let mut horizon = self.now();
        let mut streamed = Streamed::new(self, program);
        loop {
            // Not relative to the present time: while nothing is due, the clock stays at the last event.
            horizon += WATCHED_EVERY;
            if streamed.run_until(horizon)? {
                return streamed.end();
            }
            watch(streamed.progress());
        }
    }

    /// The reason why the line that waits for its answer has none.
    fn unanswered(&self, program: &Program, dialogue: &Dialogue) -> SimError {
        let line = program.number(dialogue.answered + 1);
        let text = String::from_utf8_lossy(&program[dialogue.answered]).into_owned();
        match streamed::silencer(program, dialogue) {
            Some(by) => SimError::Silenced { line, text, by },
            None => SimError::Unanswered { line, text, waiting: self.executor.waiting() },
        }
    }

    fn outcome_of(&self, record: Record, dialogue: (Program, Dialogue)) -> Outcome {
        let world = self.world.borrow();
        Outcome::new(&self.config, &world, record, &self.machine, dialogue, self.executor.clock().now_ns())
    }
}

#[cfg(test)]
mod tests;
