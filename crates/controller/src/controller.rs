//! The state that all consoles share, and what changes it at once.

use core::cell::{Cell, RefCell};

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::signal::Signal;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::parameters::{STARTUP_LINES, StoredLine};
use isostep_console::{
    AXES, Coolant, DoorPhase, Interpreter, Overrides, Parameters, Realtime, ReportedState, Settings, StatusReport,
};
use isostep_motion::{Axis, Machine, SpeedOverrides, Spindle, State};

use crate::config::Geometry;
#[cfg(feature = "trinamic")]
use crate::drivers::Drivers;
use crate::news::NewsWatch;
use crate::prove::Prove;
use crate::resets::Resets;
use crate::status::{self, position_pm};
use crate::store::{Item, Kept, Loss, Store, Value};
use crate::tool_change::Changing;
use crate::vfd::Vfd;

/// Settings, modal state and the machine they move.
///
/// It stays on one executor, so what its consoles share needs no critical section. In a critical section, reading a
/// line would hold up every interrupt.
pub struct Controller<'a, F: NorFlash> {
    pub(crate) machine: &'a Machine,
    program: RefCell<Program>,
    /// Consoles take turns, a line each, so that a move starts where the one before it ends.
    pub(crate) turn: Mutex<NoopRawMutex, ()>,
    pub(crate) resets: Resets,
    /// The number of times that M0 or M6 has held the machine.
    pub(crate) pauses: Cell<u32>,
    pub(crate) store: Mutex<NoopRawMutex, Store<F>>,
    /// The board's name; empty if it has none.
    pub(crate) board: &'static str,
    /// The name of its boot loader's USB drive; empty if it has none.
    pub(crate) boot_drive: &'static str,
    pub(crate) has_second_motor: bool,
    /// The axes whose drives' alarms have inputs; X alone if one is for all.
    pub(crate) drive_alarm_inputs: u16,
    pub(crate) boot: Signal<NoopRawMutex, ()>,
    pub(crate) prove: Option<Prove>,
    pub(crate) news: NewsWatch,
    pub(crate) vfd: Vfd,
    #[cfg(feature = "trinamic")]
    pub(crate) drivers: Option<Drivers>,
}

pub(crate) struct Program {
    pub interpreter: Interpreter,
    pub settings: Settings,
    /// The settings work together. Otherwise nothing moves, and the machine has the configuration of the last ones that did.
    pub fits: bool,
    /// The geometry of the machine's configuration.
    pub geometry: Geometry,
    pub startup: [StoredLine; STARTUP_LINES],
    pub build_text: StoredLine,
    pub overrides: Overrides,
    /// The work offset of the motion under way. The interpreter's may already be that of a later motion.
    pub work_offset_pm: [i64; AXES],
    pub mode: Mode,
    /// The state of spindle or laser for the moves that are asked for. The interpreter is ahead: when a line
    /// contains M2 it has switched them off before the line's moves are asked for.
    pub spindle: Spindle,
    /// The change of the tool that is under way.
    pub changing: Option<Changing>,
    /// The tool for which the line under way asks has just been put in.
    pub has_changed: bool,
    /// The height of Z, in machine coordinates, at which the end of a tool of length 0 touches where tools are measured.
    pub reference_pm: Option<i64>,
    /// The tool in the spindle before G-code was checked.
    pub tool_before_check: u32,
    /// The last motion was a jog, which may have ended short of its target.
    pub jogged: bool,
    /// The start-up lines have not run since power-up or the last reset.
    pub startup_due: bool,
    /// A reset has come. The program restarts when nothing moves any more, and nothing moves before it has restarted.
    pub restarting: bool,
    /// The number of lines of all consoles that have begun, and that of the line that is carried out; 0 without one.
    pub lines: u32,
    pub source: u32,
    /// A line is being carried out, or was dropped with its console. After a dropped line the program does not know yet
    /// what the machine made of it.
    pub in_line: bool,
    /// The items that may have changed since they were stored.
    pub unsaved: Unsaved,
    /// Why the stored data is not in force, until it has been replaced.
    pub loss: Option<Loss>,
}

/// The items that have to be stored.
#[derive(Clone, Copy, Default)]
pub(crate) struct Unsaved {
    pub settings: bool,
    /// Work offsets, places, tools, start-up lines, the user's text.
    pub parameters: bool,
}

/// The task of the machine while it is at rest.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Takes lines that move it.
    Normal,
    /// Checks G-code.
    Check,
    /// Sleeps until it is reset.
    Sleep,
    /// Waits to be unlocked or homed, because the motors were free while it slept.
    Slept,
    /// Waits to be restarted, into the boot loader.
    Left,
}

impl<'a, F: NorFlash> Controller<'a, F> {
    /// A controller of `machine`, which should have been made with the [`config`](crate::config()) of the same
    /// settings. These settings are in force until [`load`](Self::load).
    #[must_use]
    pub fn new(machine: &'a Machine, settings: Settings, store: Store<F>) -> Self {
        let program = Program {
            interpreter: Interpreter::new(),
            settings,
            fits: true,
            geometry: Geometry::of(&machine.config()),
            startup: [const { StoredLine::new() }; STARTUP_LINES],
            build_text: StoredLine::new(),
            overrides: Overrides::DEFAULT,
            work_offset_pm: [0; AXES],
            mode: Mode::Normal,
            spindle: Spindle::Off,
            changing: None,
            has_changed: false,
            reference_pm: None,
            tool_before_check: 0,
            jogged: false,
            startup_due: true,
            restarting: false,
            lines: 0,
            source: 0,
            in_line: false,
            unsaved: Unsaved::default(),
            loss: None,
        };
        Self {
            machine,
            program: RefCell::new(program),
            turn: Mutex::new(()),
            resets: Resets::new(),
            pauses: Cell::new(0),
            store: Mutex::new(store),
            board: "",
            boot_drive: "",
            has_second_motor: true,
            drive_alarm_inputs: 0,
            boot: Signal::new(),
            prove: None,
            news: NewsWatch::new(),
            vfd: Vfd::new(),
            #[cfg(feature = "trinamic")]
            drivers: None,
        }
    }

    /// Puts the stored data in force. Call it once, before anything else is served, and after the axes' tasks have run,
    /// because they publish what the step outputs carry. If something is wrong, a message after the welcome says so,
    /// and the defaults stay in force.
    pub async fn load(&self) {
        let mut store = self.store.lock().await;
        let loss = store.load().await.err();
        let Kept { settings, parameters } = store.kept();
        let loss = loss.or_else(|| self.put_back(*settings).err());
        self.with(|program| {
            program.loss = loss;
            program.interpreter.set_coordinates(parameters.coordinates);
            program.interpreter.set_tools(&parameters.tools);
            program.startup.clone_from(&parameters.startup);
            program.build_text.clone_from(&parameters.build_text);
            program.work_offset_pm = program.interpreter.work_offset_pm();
        });
    }

    /// The settings in force.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.with(|program| program.settings)
    }

    /// Work offsets, places, tools, start-up lines and the user's text, as they are now.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        self.with(|program| Parameters {
            coordinates: *program.interpreter.coordinates(),
            tools: *program.interpreter.tools(),
            startup: program.startup.clone(),
            build_text: program.build_text.clone(),
        })
    }

    /// The state of the machine, in the console's terms.
    pub(crate) fn state(&self) -> ReportedState {
        let (mode, fits) = self.with(|program| (program.mode, program.fits));
        match (self.machine.state(), mode) {
            (_, Mode::Left) => ReportedState::Sleep,
            // Neither an alarm nor a hold without a motion wakes it; only a reset does.
            (State::Idle | State::Hold { .. } | State::Alarm(_), Mode::Sleep) => ReportedState::Sleep,
            _ if !fits => ReportedState::Alarm,
            (State::Alarm(_), _) | (State::Idle | State::Hold { .. }, Mode::Slept) => ReportedState::Alarm,
            (State::Home, _) => ReportedState::Home,
            (State::Jog, _) => ReportedState::Jog,
            (State::Hold { .. } | State::Run, _) if self.machine.door().is_about() => ReportedState::Door(self.door()),
            (State::Run, _) => ReportedState::Run,
            (State::Hold { still }, _) => ReportedState::Hold { stopping: !still },
            (State::Idle, Mode::Normal) if self.changes_tool() => ReportedState::Tool,
            (State::Idle, Mode::Normal) => ReportedState::Idle,
            (State::Idle, Mode::Check) => ReportedState::Check,
        }
    }

    /// True from when M6 waits until the tool has been changed, with `$341`.
    pub(crate) fn changes_tool(&self) -> bool {
        self.with(|program| program.changing.is_some())
    }

    /// The state of the safety door, in the console's terms.
    fn door(&self) -> DoorPhase {
        match (self.machine.state(), self.machine.door().is_open) {
            (State::Hold { still: false }, _) => DoorPhase::Stopping,
            (State::Hold { still: true }, true) => DoorPhase::Open,
            (State::Hold { still: true }, false) => DoorPhase::Closed,
            _ => DoorPhase::Resuming,
        }
    }

    /// The contents of a status report, for a console whose input has room for `free_bytes` bytes.
    #[cold]
    pub(crate) fn report(&self, free_bytes: usize) -> StatusReport {
        let machine = self.machine.status();
        let (overrides, work_offset_pm, max_rpm) =
            self.with(|program| (program.overrides, program.work_offset_pm, program.settings.spindle_max_rpm));
        let state = match self.state() {
            state @ (ReportedState::Run | ReportedState::Tool) => self.state_in_change(state),
            state => state,
        };
        let (tool, system, has_tool_reference) = self.with(|program| {
            let interpreter = &program.interpreter;
            (interpreter.tool_in_spindle(), interpreter.modal().system, program.reference_pm.is_some())
        });
        StatusReport {
            state,
            tool,
            system,
            has_tool_reference,
            position_pm: position_pm(machine.position_steps, &self.machine.config()),
            work_offset_pm,
            line_number: machine.line,
            feed_mm_min: (machine.speed_mm_s * 60.0) as f32,
            spindle_rpm: machine.level.ratio() * max_rpm,
            actual_rpm: self.vfd.actual_rpm(),
            spindle: status::spindle(machine.outputs.spindle),
            coolant: Coolant::of(machine.outputs.flood, machine.outputs.mist),
            probe_touched: machine.probe_touches,
            door_open: machine.door.is_open,
            hold_pressed: machine.buttons[0],
            start_pressed: machine.buttons[1],
            limits_pressed: Axis::ALL
                .map(|axis| machine.pressed[axis as usize] || machine.second_pressed == Some(axis)),
            second_limit_pressed: machine.second_pressed.is_some(),
            drive_alarm: machine.drive_alarm,
            emergency_stop: machine.emergency_stop,
            free_blocks: machine.queue_free as u8,
            free_bytes: free_bytes.min(status::ADVERTISED_BYTES) as u16,
            overrides,
            homed: self.machine.homed(),
        }
    }

    /// Obeys a real-time byte that is for the machine, not for a console, and no reset.
    #[cold]
    pub(crate) fn real_time(&self, realtime: Realtime) {
        match realtime {
            Realtime::Override(byte) => {
                self.with(|program| program.overrides.apply(byte));
                self.override_machine();
            }
            Realtime::Hold => self.machine.hold(),
            Realtime::Resume if self.machine.state() == State::Idle && self.changes_tool() => self.resume_change(),
            Realtime::Resume => self.machine.resume(),
            Realtime::JogCancel => self.machine.cancel_jog(),
            Realtime::Door => self.machine.open_door(),
            Realtime::SpindleStop | Realtime::Flood | Realtime::Mist => self.override_tool(realtime),
            Realtime::Status | Realtime::FullStatus | Realtime::Modal => {}
            Realtime::ToolChange | Realtime::Reset | Realtime::Ignored => {}
        }
    }

    /// Passes the overrides in force on to the machine.
    #[cold]
    pub(crate) fn override_machine(&self) {
        let overrides = self.with(|program| program.overrides);
        self.machine.set_overrides(SpeedOverrides {
            feed_percent: overrides.feed_percent,
            rapid_percent: overrides.rapid_percent,
        });
        self.machine.set_spindle_percent(overrides.spindle_percent);
    }

    /// True if the machine is held, or brakes for that, and not for a reset.
    pub(crate) fn is_held(&self) -> bool {
        matches!(self.machine.state(), State::Hold { .. }) && !self.is_restarting()
    }

    /// Notes that a reset has come. From now on no console goes on with a line from before it.
    #[cold]
    pub(crate) fn begin_restart(&self) {
        self.with(|program| program.restarting = true);
        self.resets.come();
    }

    /// True if a reset has come and the program has not restarted yet.
    pub(crate) fn is_restarting(&self) -> bool {
        self.with(|program| program.restarting)
    }

    /// Restarts the program: sets the modal state and the overrides as at power-up, at the place where the machine
    /// stands.
    #[cold]
    pub(crate) fn restart_program(&self) {
        self.with(|program| {
            (program.restarting, program.in_line, program.source) = (false, false, 0);
            program.interpreter.reset();
            if program.mode == Mode::Check {
                program.interpreter.set_tool_in_spindle(program.tool_before_check);
            }
            (program.changing, program.has_changed) = (None, false);
            program.overrides = Overrides::DEFAULT;
            program.startup_due = true;
            program.mode = match program.mode {
                Mode::Sleep | Mode::Slept => Mode::Slept,
                Mode::Left => Mode::Left,
                Mode::Normal | Mode::Check => Mode::Normal,
            };
        });
        self.stop_tool();
        self.override_machine();
        self.follow_machine();
    }

    /// Has the program go on from where the machine stands. This is needed after everything except a finished move.
    #[cold]
    pub(crate) fn follow_machine(&self) {
        let position_pm = position_pm(self.machine.position_steps(), &self.machine.config());
        self.with(|program| {
            program.interpreter.set_position_pm(position_pm);
            program.jogged = false;
            program.work_offset_pm = program.interpreter.work_offset_pm();
        });
    }

    /// The same, unless the machine stands where the program expects it, within half a step: then the program keeps its
    /// exact place. Otherwise jogs of less than a step would never add up to one.
    #[cold]
    pub(crate) fn follow_if_elsewhere(&self) {
        let steps = self.machine.position_steps();
        let is_elsewhere = self.with(|program| {
            program.jogged = false;
            program.geometry.steps(program.interpreter.position_pm()) != steps
        });
        if is_elsewhere {
            self.follow_machine();
        }
    }

    pub(crate) fn with<R>(&self, f: impl FnOnce(&mut Program) -> R) -> R {
        f(&mut self.program.borrow_mut())
    }
}

impl Unsaved {
    pub fn any(self) -> bool {
        self.settings || self.parameters
    }
}

impl Program {
    /// The value of an item, as it is now.
    pub fn value(&self, item: Item) -> Value {
        let (coordinates, tools) = (self.interpreter.coordinates(), self.interpreter.tools());
        item.value((&self.settings, coordinates, tools, &self.startup, &self.build_text))
    }
}
