//! The outputs of the tool as they are to be, and what switches them off.

use core::cell::Cell;
use core::sync::atomic::{AtomicU16, Ordering};

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;

use super::{Busy, Inner, Machine, Reaction, Trigger};
use crate::event::{SpindleFault, State};
use crate::port::Inhibit;
use crate::tool::power::{Asked, Level};
use crate::tool::spindle::{Outputs, Spindle, SpindleWanted, ToolConfig, ToolWanted};
use crate::tool::stroke::StrokeQueue;

/// The state that the machine and its tool's task share.
pub(super) struct ToolLink {
    strokes: StrokeQueue,
    asked: Signal<CriticalSectionRawMutex, ()>,
    /// The same for who turns a spindle otherwise than by the outputs.
    spindle_asked: Signal<CriticalSectionRawMutex, ()>,
    level: AtomicU16,
    inhibit: Mutex<CriticalSectionRawMutex, Cell<Inhibit>>,
}

impl ToolLink {
    pub const fn new() -> Self {
        Self {
            strokes: StrokeQueue::new(),
            asked: Signal::new(),
            spindle_asked: Signal::new(),
            level: AtomicU16::new(0),
            inhibit: Mutex::new(Cell::new(|_engaged| {})),
        }
    }

    /// Has the task look at what is asked of the outputs. Not inlined: see [`Machine::with`].
    #[inline(never)]
    pub fn ask(&self) {
        self.asked.signal(());
        self.spindle_asked.signal(());
    }

    /// The level that the PWM output has now, with the override applied.
    pub fn level(&self) -> Level {
        Level::from_65535ths(self.level.load(Ordering::Relaxed))
    }

    fn inhibit(&self, engaged: bool) {
        self.inhibit.lock(Cell::get)(engaged);
    }
}

/// Why the spindle stands while the machine is held. The resume has it turn again.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SpindleStop {
    /// It was stopped by hand, and may be started by hand.
    ByHand,
    /// Somebody changes the tool: nothing starts it before the resume.
    ToolChange,
}

/// The outputs that are asked for, and what keeps them off.
#[derive(Clone, Copy)]
pub(super) struct OutputsAsked {
    pub asked: Outputs,
    /// The override of the spindle's level, percent.
    pub percent: u8,
    /// Why the spindle stands in a hold.
    pub stopped: Option<SpindleStop>,
    /// The instant at which the spindle has its speed: nothing moves before. [`Instant::MAX`] until it is reported.
    pub ready_at: Instant,
    /// The number of times that the spindle was to turn otherwise, or to stand.
    pub turns: u32,
    /// The spindle, or the laser, is to be off once no motion is pending.
    pub stops_at_rest: bool,
    /// The number of times that all outputs have been switched off at once.
    pub stops: u32,
}

impl OutputsAsked {
    pub const fn new() -> Self {
        Self {
            asked: Outputs::OFF,
            percent: 100,
            stopped: None,
            ready_at: Instant::MIN,
            turns: 0,
            stops_at_rest: false,
            stops: 0,
        }
    }
}

impl Machine {
    /// Changes the outputs. If the spindle begins to turn, or turns in the other direction, the motions that follow
    /// wait until it has its speed; if it reports its speed, after any other change of it, too. A spindle turns if it has a
    /// direction and a level above zero.
    ///
    /// # Errors
    /// In an alarm, and while a stop or a reset is under way, the outputs stay off.
    pub fn set_outputs(&self, outputs: Outputs) -> Result<(), Busy> {
        self.change_outputs(outputs, |asked, outputs| (asked.asked, asked.stops_at_rest) = (outputs, false))
    }

    /// Changes the coolant alone.
    ///
    /// # Errors
    /// The same as for [`set_outputs`](Self::set_outputs).
    pub fn set_coolant(&self, flood: bool, mist: bool) -> Result<(), Busy> {
        let coolant = Outputs { flood, mist, ..Outputs::OFF };
        self.change_outputs(coolant, |asked, coolant| {
            (asked.asked.flood, asked.asked.mist) = (coolant.flood, coolant.mist);
        })
    }

    fn change_outputs(&self, to: Outputs, change: fn(&mut OutputsAsked, Outputs)) -> Result<(), Busy> {
        self.with(|inner| {
            let (before, mut outputs) = (inner.effective(), inner.outputs);
            change(&mut outputs, to);
            if outputs.asked != Outputs::OFF && self.apply(inner, Trigger::OutputAsked) == Reaction::Refuse {
                return Err(Busy(inner.life.state));
            }
            inner.outputs = outputs;
            inner.spin_up(before);
            self.tool.ask();
            Ok(())
        })
    }

    /// Switches the spindle or the laser off once no motion is pending.
    pub fn stop_spindle_at_rest(&self) {
        self.with(|inner| {
            let before = inner.effective();
            inner.outputs.stops_at_rest = true;
            inner.rest_outputs();
            inner.spin_up(before);
        });
        self.tool.ask();
    }

    /// The outputs that were asked for last, unless all have been switched off since.
    #[must_use]
    pub fn outputs(&self) -> Outputs {
        self.with(|inner| inner.outputs.asked)
    }

    /// Sets the spindle's speed, or the laser's level, to `percent` of what it is without an override, at once.
    pub fn set_spindle_percent(&self, percent: u8) {
        self.with(|inner| inner.outputs.percent = percent);
        self.tool.ask();
    }

    /// While the machine is held, stops the spindle, or has it turn again. It turns again with the resume, too. During a
    /// change of the tool nothing happens.
    pub fn toggle_spindle(&self) {
        self.stop_spindle_in_hold(|stopped| match stopped {
            None => Some(SpindleStop::ByHand),
            Some(SpindleStop::ByHand) => None,
            Some(SpindleStop::ToolChange) => Some(SpindleStop::ToolChange),
        });
    }

    /// Holds the machine, which is at rest, for a change of the tool: somebody reaches for it, so the spindle stands
    /// until the resume.
    pub fn hold_for_tool_change(&self) {
        self.hold();
        self.stop_spindle_in_hold(|_| Some(SpindleStop::ToolChange));
    }

    fn stop_spindle_in_hold(&self, stopped: fn(Option<SpindleStop>) -> Option<SpindleStop>) {
        self.with(|inner| {
            if matches!(inner.life.state, State::Hold { still: true }) {
                let before = inner.effective();
                inner.outputs.stopped = stopped(inner.outputs.stopped);
                inner.spin_up(before);
            }
        });
        self.tool.ask();
    }
}

/// For who turns a spindle otherwise than by the outputs, and knows its speed: [`ToolConfig::reports_speed`].
impl Machine {
    /// How the spindle is to turn now.
    #[must_use]
    #[cold]
    pub fn spindle_wanted(&self) -> SpindleWanted {
        let wanted = self.tool_wanted();
        let ToolConfig { laser, duties, .. } = wanted.config;
        let asked = if laser { Asked::NOTHING } else { Asked::even(wanted.outputs.level) };
        let level = duties.made(wanted.level(asked));
        let spindle = if level == Level::ZERO { Spindle::Off } else { wanted.outputs.spindle };
        SpindleWanted { spindle, level, turns: wanted.turns }
    }

    /// Waits until the spindle may have to turn otherwise. Only one task may wait.
    ///
    /// # Cancellation
    /// Safe: what has changed meanwhile ends the next wait at once.
    pub async fn wait_spindle(&self) {
        self.tool.spindle_asked.wait().await;
    }

    /// The spindle turns as is wanted: what waits for that goes on, unless something else is wanted by now.
    #[cold]
    pub fn spindle_at_speed(&self, wanted: SpindleWanted) {
        self.with(|inner| {
            if inner.outputs.turns == wanted.turns {
                inner.outputs.ready_at = Instant::MIN;
            }
        });
        self.wake();
    }

    /// The spindle does not turn as it is to, or nobody knows whether it does. Everything stops at once, and an alarm says which;
    /// the position is trusted only if nothing moved. Safe from any context.
    #[cold]
    pub fn spindle_failed(&self, fault: SpindleFault) {
        self.on(Trigger::SpindleFailed(fault));
    }
}

impl Inner {
    /// The outputs as they are now: what is asked of them, except for what a hold or the safety door keeps off. A spindle
    /// whose speed is 0 stands.
    pub(super) fn effective(&self) -> Outputs {
        let (outputs, laser) = (self.outputs.asked, self.config.tool.laser);
        let is_guarded = self.life.door.keeps_off() && (laser || !self.life.moving);
        if is_guarded {
            return Outputs::OFF;
        }
        let is_dark = laser && matches!(self.life.state, State::Hold { still: true });
        let stands = !laser && outputs.level == Level::ZERO;
        if is_dark || stands || self.outputs.stopped.is_some() { outputs.without_spindle() } else { outputs }
    }

    /// If the spindle turns otherwise than `before`, the motions that follow wait until it has its speed.
    pub(super) fn spin_up(&mut self, before: Outputs) {
        let (Outputs { spindle, level, .. }, tool) = (self.effective(), &self.config.tool);
        let is_other = spindle != before.spindle || tool.reports_speed && level != before.level;
        if is_other && !tool.laser {
            self.outputs.turns = self.outputs.turns.wrapping_add(1);
            self.outputs.ready_at = match spindle {
                Spindle::Off => Instant::MIN,
                _ if tool.reports_speed => Instant::MAX,
                _ => Instant::now() + tool.spin_up,
            };
        }
    }

    /// Switches the spindle or the laser off, if that is to be done once no motion is pending, and none is.
    pub(super) fn rest_outputs(&mut self) {
        if self.life.pending == 0 && core::mem::take(&mut self.outputs.stops_at_rest) {
            self.outputs.asked = self.outputs.asked.without_spindle();
        }
    }
}

/// For the tasks of this crate.
impl Machine {
    /// Switches all outputs off at once. It is called in one critical section with the change that is the reason.
    pub(super) fn cut_outputs(&self, inner: &mut Inner) {
        let OutputsAsked { percent, stops, turns, .. } = inner.outputs;
        let (stops, turns) = (stops.wrapping_add(1), turns.wrapping_add(1));
        inner.outputs = OutputsAsked { percent, stops, turns, ..OutputsAsked::new() };
        inner.life.on(Trigger::OutputsCut);
        self.tool.inhibit(true);
        self.tool.ask();
    }

    /// The same, in a critical section of its own.
    pub(crate) fn cut(&self) {
        self.with(|inner| self.cut_outputs(inner));
    }

    /// Takes over the inhibit of the tool's port, whose outputs are off.
    pub(crate) fn fit_tool(&self, inhibit: Inhibit) {
        self.tool.inhibit.lock(|fitted| fitted.set(inhibit));
    }

    pub(crate) fn tool_wanted(&self) -> ToolWanted {
        self.with(|inner| ToolWanted {
            config: inner.config.tool,
            outputs: inner.effective(),
            percent: inner.outputs.percent,
            stops: inner.outputs.stops,
            turns: inner.outputs.turns,
        })
    }

    /// Releases the inhibit of the outputs, which are now as they are to be. It does nothing if the inhibit has been
    /// engaged again since then: more than `stops` times in all.
    pub(crate) fn release_tool(&self, stops: u32) {
        self.with(|inner| {
            if inner.outputs.stops == stops {
                self.tool.inhibit(false);
            }
        });
    }

    /// Waits until something else is asked of the outputs.
    pub(crate) async fn wait_tool(&self) {
        self.tool.asked.wait().await;
    }

    pub(crate) fn strokes(&self) -> &StrokeQueue {
        &self.tool.strokes
    }

    pub(crate) fn note_level(&self, level: Level) {
        self.tool.level.store(level.of_65535(), Ordering::Relaxed);
    }
}
