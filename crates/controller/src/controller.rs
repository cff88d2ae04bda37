//! What all consoles share, and what acts on it at once.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::signal::Signal;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::parameters::{STARTUP_LINES, StoredLine};
use isostep_console::{
    AXES, Coolant, Door, Interpreter, Overrides, Parameters, Realtime, ReportedState, Settings, Status as Report,
};
use isostep_motion::{Machine, Overrides as Overridden, Spindle, State};

use crate::config::Geometry;
use crate::status::{self, position_mm};
use crate::store::{Item, Kept, Loss, Store, Value};
use crate::tool;

/// Settings, modal state and the machine they move.
///
/// It stays on one executor, so what its consoles share needs no critical section, in which reading a line would hold
/// up every interrupt.
pub struct Controller<'a, F: NorFlash> {
    pub(crate) machine: &'a Machine,
    program: RefCell<Program>,
    /// Consoles take turns, a line each, so that a move starts where the one before it ends.
    pub(crate) turn: Mutex<NoopRawMutex, ()>,
    /// Ends a sleep, in which a line keeps its turn.
    pub(crate) woken: Signal<NoopRawMutex, ()>,
    pub(crate) store: Mutex<NoopRawMutex, Store<F>>,
    pub(crate) has_boot_loader: bool,
    pub(crate) boot: Signal<NoopRawMutex, ()>,
}

pub(crate) struct Program {
    pub interpreter: Interpreter,
    pub settings: Settings,
    /// That of the machine's configuration.
    pub geometry: Geometry,
    pub startup: [StoredLine; STARTUP_LINES],
    pub build_text: StoredLine,
    pub overrides: Overrides,
    /// The work offset of the motion under way: the interpreter's is ahead.
    pub work_offset_mm: [f32; AXES],
    pub mode: Mode,
    /// How spindle or laser are switched: the interpreter has that of M2 already when the moves of its line are asked for.
    pub spindle: Spindle,
    /// The last motion was a jog, which may have ended short of its target.
    pub jogged: bool,
    /// The start-up lines have not run since power-up or the last reset.
    pub startup_due: bool,
    /// A reset has come: the program does not begin anew before nothing moves, and nothing moves before it has.
    pub restarting: bool,
    /// A line is being carried out, or was dropped with its console: then nobody has followed what it has asked for.
    pub in_line: bool,
    /// What may have changed since it was stored.
    pub unsaved: Unsaved,
    /// What was stored is not in force, and has not been replaced yet.
    pub loss: Option<Loss>,
}

/// What there is to store.
#[derive(Clone, Copy, Default)]
pub(crate) struct Unsaved {
    pub settings: bool,
    /// Work offsets, places, start-up lines, the user's text.
    pub parameters: bool,
}

/// What a machine that stands still is for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// To be moved.
    Normal,
    /// To check G-code.
    Check,
    /// To be reset.
    Sleep,
    /// To be unlocked or homed: the motors were free while it slept.
    Slept,
    /// To be restarted.
    Left,
}

impl<'a, F: NorFlash> Controller<'a, F> {
    /// A controller of `machine`, which should have been made with the [`config`](crate::config()) of the same settings. They hold until
    /// [`load`](Self::load).
    #[must_use]
    pub fn new(machine: &'a Machine, settings: Settings, store: Store<F>) -> Self {
        let program = Program {
            interpreter: Interpreter::new(),
            settings,
            geometry: Geometry::of(&machine.config()),
            startup: [const { StoredLine::new() }; STARTUP_LINES],
            build_text: StoredLine::new(),
            overrides: Overrides::DEFAULT,
            work_offset_mm: [0.0; AXES],
            mode: Mode::Normal,
            spindle: Spindle::Off,
            jogged: false,
            startup_due: true,
            restarting: false,
            in_line: false,
            unsaved: Unsaved::default(),
            loss: None,
        };
        let (turn, woken, store) = (Mutex::new(()), Signal::new(), Mutex::new(store));
        let boot = Signal::new();
        Self { machine, program: RefCell::new(program), turn, woken, store, has_boot_loader: false, boot }
    }

    /// Puts in force what was stored. Call it once, after the axes' tasks have run, which tell what the step outputs carry,
    /// and before anything else is served. What is wrong shows after the welcome; then the defaults stay.
    pub async fn load(&self) {
        let mut store = self.store.lock().await;
        let loss = store.load().await.err();
        let Kept { settings, parameters } = store.kept();
        let loss = loss.or_else(|| self.put_back(*settings).err());
        self.with(|program| {
            program.loss = loss;
            program.interpreter.set_coordinates(parameters.coordinates);
            program.startup.clone_from(&parameters.startup);
            program.build_text.clone_from(&parameters.build_text);
            program.work_offset_mm = program.interpreter.work_offset_mm();
        });
    }

    /// The settings in force.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.with(|program| program.settings)
    }

    /// Work offsets, places, start-up lines and the user's text, as they are now.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        self.with(|program| Parameters {
            coordinates: *program.interpreter.coordinates(),
            startup: program.startup.clone(),
            build_text: program.build_text.clone(),
        })
    }

    /// What the machine does, as a console calls it.
    pub(crate) fn state(&self) -> ReportedState {
        match (self.machine.state(), self.with(|program| program.mode)) {
            (_, Mode::Left) => ReportedState::Sleep,
            // Neither an alarm nor a hold of nothing wakes it: that takes a reset.
            (State::Idle | State::Hold { .. } | State::Alarm(_), Mode::Sleep) => ReportedState::Sleep,
            (State::Alarm(_), _) | (State::Idle | State::Hold { .. }, Mode::Slept) => ReportedState::Alarm,
            (State::Home, _) => ReportedState::Home,
            (State::Jog, _) => ReportedState::Jog,
            (State::Hold { .. } | State::Run, _) if self.machine.door().is_about() => ReportedState::Door(self.door()),
            (State::Run, _) => ReportedState::Run,
            (State::Hold { still }, _) => ReportedState::Hold { stopping: !still },
            (State::Idle, Mode::Normal) => ReportedState::Idle,
            (State::Idle, Mode::Check) => ReportedState::Check,
        }
    }

    /// What the safety door does, as a console calls it.
    fn door(&self) -> Door {
        match (self.machine.state(), self.machine.door().is_open) {
            (State::Hold { still: false }, _) => Door::Stopping,
            (State::Hold { still: true }, true) => Door::Open,
            (State::Hold { still: true }, false) => Door::Closed,
            _ => Door::Resuming,
        }
    }

    /// What a status report tells, to a console with room for so many bytes.
    pub(crate) fn report(&self, free_bytes: usize) -> Report {
        let machine = self.machine.status();
        let (overrides, work_offset_mm, max_rpm) =
            self.with(|program| (program.overrides, program.work_offset_mm, program.settings.spindle_max_rpm));
        Report {
            state: self.state(),
            position_mm: position_mm(machine.position_steps, &self.machine.config()),
            work_offset_mm,
            line_number: machine.line,
            feed_mm_min: (machine.speed_mm_s * 60.0) as f32,
            spindle_rpm: machine.level.ratio() * max_rpm,
            spindle: tool::word(machine.outputs.spindle),
            coolant: Coolant::of(machine.outputs.flood, machine.outputs.mist),
            probe_touched: machine.probe_touches,
            door_open: machine.door.is_open,
            hold_pressed: machine.buttons[0],
            start_pressed: machine.buttons[1],
            limits_pressed: machine.pressed,
            emergency_stop: machine.emergency_stop,
            free_blocks: machine.queue_free as u8,
            free_bytes: free_bytes.min(status::ADVERTISED_BYTES) as u16,
            overrides,
        }
    }

    /// Obeys a real-time byte that is neither a report nor a reset.
    pub(crate) fn real_time(&self, realtime: Realtime) {
        match realtime {
            Realtime::Override(byte) => {
                self.with(|program| program.overrides.apply(byte));
                self.override_machine();
            }
            Realtime::Hold => self.machine.hold(),
            Realtime::Resume => self.machine.resume(),
            Realtime::JogCancel => self.machine.cancel_jog(),
            Realtime::Door => self.machine.open_door(),
            Realtime::SpindleStop | Realtime::Flood | Realtime::Mist => self.override_tool(realtime),
            Realtime::Status | Realtime::Reset | Realtime::Ignored => {}
        }
    }

    /// Tells the machine of the overrides in force.
    pub(crate) fn override_machine(&self) {
        let overrides = self.with(|program| program.overrides);
        self.machine
            .set_overrides(Overridden { feed_percent: overrides.feed_percent, rapid_percent: overrides.rapid_percent });
        self.machine.set_spindle_percent(overrides.spindle_percent);
    }

    /// A reset has come.
    pub(crate) fn begin_restart(&self) {
        self.with(|program| program.restarting = true);
    }

    /// A reset has come, and the program has not begun anew yet.
    pub(crate) fn is_restarting(&self) -> bool {
        self.with(|program| program.restarting)
    }

    /// The modal state and the overrides of power-up, at the place where the machine stands.
    pub(crate) fn restart_program(&self) {
        self.with(|program| {
            (program.restarting, program.in_line) = (false, false);
            program.interpreter.reset();
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
        self.woken.signal(());
    }

    /// After anything but a finished move the program goes on from where the machine stands.
    pub(crate) fn follow_machine(&self) {
        let position = position_mm(self.machine.position_steps(), &self.machine.config());
        self.with(|program| {
            program.interpreter.set_position_mm(position);
            program.jogged = false;
            program.work_offset_mm = program.interpreter.work_offset_mm();
        });
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
    /// The value of what is stored, as it is now.
    pub fn value(&self, item: Item) -> Value {
        item.value((&self.settings, self.interpreter.coordinates(), &self.startup, &self.build_text))
    }
}
