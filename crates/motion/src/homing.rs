//! Limit-switch homing, axis by axis: seek, back off, latch, pull off.
//!
//! The seek may stop abruptly, because only the slow latch measures. With room behind the switch it brakes there instead, within the
//! limits, as a probe does behind its contact, and backs off by as much more. Both searches are bounded (by Grbl's factors): a
//! switch that is missing, stuck or wired wrongly raises an alarm that names it.
//!
//! The first edge of a switch ends a search at once, so its place does not depend on how long the contacts bounce, nor on the
//! debounce time. Whether it was a press is judged at rest, by the debounced level. After a spike the search goes on.
//!
//! # Two motors
//! An axis with a second motor is squared meanwhile. Both motors seek together. Where one meets its switch both stop,
//! and the other goes on alone, no farther than the skew limit. The latch does the same, so each motor is measured by
//! its own switch, and the gantry is never skewed by more than it was. Both back off and pull off together. At the end
//! one motor goes on alone by the offset, away from its switch, so that both are off theirs.
//!
//! # By stall
//! An axis without a switch runs against its end, twice, until its driver says that the motor stalls. A slow motor cannot
//! be measured, so the latch is as fast as the seek, and it begins far enough away for its run-up. Where the field was a
//! part of a full step ahead of the rotor when the motor stopped, it comes back by as much: a zero is as exact as the
//! instants at which the driver notices. Before the seek the input must be silent: one that is high although the motor
//! stands is not that of a driver.

use core::cell::Cell;
use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::select::select;
use embassy_time::{Duration, Timer, with_timeout};
use embedded_hal::digital::OutputPin;

use crate::axes::{AXES, Axis};
use crate::config::{Config, HomingConfig};
use crate::coordinator::{Coordinator, Purpose, alongside};
use crate::event::{Alarm, Event, Finish, HomingPhase, State};
use crate::motor::{GangedMotor, Motor};
use crate::port::Direction;

/// The seek gives up after this many times the travel.
const SEEK_TRAVELS: f64 = 1.5;
/// The latch gives up after this many times the distance that the axis has backed off.
const LATCH_BACK_OFFS: f64 = 5.0;
/// A search gives up after so many spikes.
const SPIKES_MAX: usize = 100;
/// A switch that has not been steady for the debounce time by then is broken: longer than any debounce time and any bounce.
const SETTLES: Duration = Duration::from_secs(2);

/// A part of homing: a straight move of an axis, or of one of its motors.
#[derive(Clone, Copy)]
struct HomingMove {
    axis: Axis,
    mm: f64,
    to_switch: bool,
    speed_mm_s: f64,
    /// The ganged motor that stands still.
    held: Option<GangedMotor>,
    /// It brakes behind its switch, instead of stopping there at once.
    brakes: bool,
}

impl HomingMove {
    fn purpose(&self) -> Purpose {
        if self.brakes { Purpose::Seek } else { Purpose::Homing { held: self.held } }
    }
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Homes those of these axes that the configured order has. Each then stands at its zero, a pull-off away from its
    /// switch. It does nothing if it is stopped before it begins.
    pub(crate) async fn home(&mut self, axes: [bool; AXES]) -> Result<(), Alarm> {
        while !self.machine.begin_homing() {
            if !self.machine.outlast_hold().await {
                return Ok(());
            }
        }
        self.report_state(State::Home);
        let asked = |axis: &Axis| axes[*axis as usize];
        let order = self.machine.config().homing.order;
        for axis in order.into_iter().flatten().filter(asked) {
            self.machine.set_homed(axis, false);
        }
        for axis in order.into_iter().flatten().filter(asked) {
            self.home_axis(axis).await?;
        }
        Ok(())
    }

    async fn home_axis(&mut self, axis: Axis) -> Result<(), Alarm> {
        self.is_settled(axis).await;
        self.contact_steps = None;
        // A carriage that already stands on its switch has nothing to seek.
        if self.missing(axis).is_some() {
            let homing_move = self.begin(axis, HomingPhase::Seek);
            self.approach(homing_move).await?;
        } else if self.by_stall(axis) {
            return Err(Alarm::SwitchStuck { motor: Motor::first(axis) });
        }
        let sought_steps = self.machine.position_steps()[axis as usize];
        let homing_move = self.begin(axis, HomingPhase::BackOff);
        self.retreat(homing_move).await?;
        let homing_move = self.begin(axis, HomingPhase::Latch);
        self.approach(homing_move).await?;
        if self.by_stall(axis) {
            self.compare_stalls(axis, sought_steps)?;
        }
        let homing_move = self.begin(axis, HomingPhase::PullOff);
        self.retreat(homing_move).await?;
        if let Some(homing_move) = self.offset(homing_move) {
            self.retreat(homing_move).await?;
        }
        self.machine.set_zero(axis);
        self.machine.set_homed(axis, true);
        self.report(Event::Homed { axis });
        Ok(())
    }

    fn by_stall(&self, axis: Axis) -> bool {
        self.machine.config().homing.by_stall[axis as usize]
    }

    /// Reports the phase, and returns its move. Not inlined: a whole configuration is large, and would be kept meanwhile.
    #[inline(never)]
    fn begin(&mut self, axis: Axis, phase: HomingPhase) -> HomingMove {
        self.report(Event::Homing { axis, phase });
        let config = self.machine.config();
        let HomingConfig { seek_mm_s, pull_off_mm, by_stall, .. } = config.homing;
        let (run_up_mm, latch_mm_s) =
            if by_stall[axis as usize] { (config.run_up_mm(axis), seek_mm_s) } else { (0.0, config.homing.latch_mm_s) };
        let back_off_mm = pull_off_mm + run_up_mm;
        let (mm, to_switch, speed_mm_s) = match phase {
            HomingPhase::Seek => (SEEK_TRAVELS * config.travel_mm[axis as usize], true, seek_mm_s),
            HomingPhase::BackOff => (back_off_mm + self.beyond_mm(axis, &config), false, seek_mm_s),
            HomingPhase::Latch => (LATCH_BACK_OFFS * back_off_mm + room_mm(axis, &config), true, latch_mm_s),
            HomingPhase::PullOff => (pull_off_mm, false, latch_mm_s),
        };
        let brakes = phase == HomingPhase::Seek && config.brakes_behind(axis);
        HomingMove { axis, mm, to_switch, speed_mm_s, held: None, brakes }
    }

    /// How far the axis has gone on since the touch that a seek braked for, mm. If it has not been seen to pass its switch, because an
    /// earlier seek was stopped behind it, the axis may stand anywhere in the room.
    fn beyond_mm(&self, axis: Axis, config: &Config) -> f64 {
        let at_steps = self.machine.position_steps()[axis as usize];
        self.contact_steps.map_or(room_mm(axis, config), |contact_steps| {
            config.mm(axis, at_steps - contact_steps[axis as usize]).abs()
        })
    }

    /// Looks whether the switch of a seek that brakes has been touched, and if so notes where the axes are. Returns whether it has.
    #[cold]
    pub(crate) fn note_touch(&mut self) -> bool {
        if self.contact_steps.is_none() && self.machine.is_touched() {
            self.contact_steps = Some(self.machine.position_steps());
        }
        self.contact_steps.is_some()
    }

    /// Notes how far the latch has ended from where the seek did. Where a motor that speeds up seems stalled it does so
    /// twice, the second time long before it is back.
    fn compare_stalls(&self, axis: Axis, sought_steps: i32) -> Result<(), Alarm> {
        let apart_steps = self.machine.position_steps()[axis as usize] - sought_steps;
        self.machine.set_stalls_apart(axis, apart_steps);
        let config = self.machine.config();
        let is_one_place = config.mm(axis, apart_steps).abs() <= config.homing.pull_off_mm;
        if is_one_place { Ok(()) } else { Err(Alarm::StallsApart { axis }) }
    }

    /// The move by which one motor goes farther than the pull-off, if it is a step at least.
    fn offset(&self, homing_move: HomingMove) -> Option<HomingMove> {
        let config = self.machine.config();
        let offset_mm = config.squared_axis(homing_move.axis)?.offset_mm;
        let held = if offset_mm > 0.0 { GangedMotor::First } else { GangedMotor::Second };
        (config.steps(homing_move.axis, offset_mm) != 0).then_some(HomingMove {
            mm: offset_mm.abs(),
            held: Some(held),
            ..homing_move
        })
    }

    /// The motors of `axis`.
    fn motors(&self, axis: Axis) -> impl Iterator<Item = Motor> + use<E, F> {
        let second = self.machine.config().squared_axis(axis).map(|_| Motor::second(axis));
        core::iter::once(Motor::first(axis)).chain(second)
    }

    /// The first motor of `axis` that does not stand at its switch.
    fn missing(&self, axis: Axis) -> Option<Motor> {
        self.motors(axis).find(|motor| !self.machine.switch_of(*motor).is_pressed())
    }

    /// The first motor of `axis` that stands at its switch.
    fn arrived(&self, axis: Axis) -> Option<Motor> {
        self.motors(axis).find(|motor| self.machine.switch_of(*motor).is_pressed())
    }

    /// Moves towards the switches until each motor has met its own. The first that does waits for the other.
    async fn approach(&mut self, homing_move: HomingMove) -> Result<(), Alarm> {
        let axis = homing_move.axis;
        if self.arrived(axis).is_none() {
            self.search(homing_move, Alarm::SwitchNotFound { axis }).await?;
        }
        let Some(mm) = self.machine.config().squared_axis(axis).map(|squared| squared.skew_max_mm) else {
            return Ok(());
        };
        match self.missing(axis) {
            Some(motor) => {
                self.search(HomingMove { mm, held: Some(motor.ganged.other()), ..homing_move }, Alarm::Skewed { motor })
                    .await
            }
            None => Ok(()),
        }
    }

    /// Waits until the levels of the axis's switches are debounced. False if one never is.
    async fn is_settled(&self, axis: Axis) -> bool {
        let settled = async {
            for motor in self.motors(axis) {
                self.machine.switch_of(motor).wait_settled().await;
            }
        };
        with_timeout(SETTLES, settled).await.is_ok()
    }

    /// Moves towards the switches until that of a moving ganged motor is pressed. If none is, that is the alarm `missed`.
    async fn search(&mut self, mut homing_move: HomingMove, missed: Alarm) -> Result<(), Alarm> {
        for _ in 0..SPIKES_MAX {
            let from_steps = self.machine.position_steps()[homing_move.axis as usize];
            let was_touched = self.go_to_touch(homing_move).await?;
            let is_settled = self.is_settled(homing_move.axis).await;
            let is_found = match homing_move.held {
                // The input of a driver falls when the motor stops.
                _ if self.by_stall(homing_move.axis) => was_touched,
                Some(held) => {
                    self.machine.switch_of(Motor { axis: homing_move.axis, ganged: held.other() }).is_pressed()
                }
                None => self.arrived(homing_move.axis).is_some(),
            };
            match () {
                () if self.machine.cause().is_some() => return Err(self.stop_alarm()),
                () if is_found => return Ok(()),
                () if !was_touched || !is_settled => break,
                () => {}
            }
            // It was a spike. As much of the distance is left as has not been gone.
            let gone_steps = self.machine.position_steps()[homing_move.axis as usize] - from_steps;
            homing_move.mm -= self.machine.config().mm(homing_move.axis, gone_steps).abs();
        }
        Err(missed)
    }

    /// Moves towards the switches until that of a moving ganged motor changes, and stops there at once, or brakes from there on.
    /// Returns whether one did.
    async fn go_to_touch(&mut self, homing_move: HomingMove) -> Result<bool, Alarm> {
        let machine = self.machine;
        self.contact_steps = None;
        machine.set_touched(false);
        let [first, second] =
            [GangedMotor::First, GangedMotor::Second].map(|ganged| Motor { axis: homing_move.axis, ganged });
        let is_two = machine.config().squared_axis(homing_move.axis).is_some();
        let was_touched = Cell::new(false);
        let touched = async {
            let (first, second) = (machine.switch_of(first), machine.switch_of(second));
            match homing_move.held {
                Some(GangedMotor::First) => second.wait_touched().await,
                None if is_two => _ = select(first.wait_touched(), second.wait_touched()).await,
                _ => first.wait_touched().await,
            }
            was_touched.set(true);
            if homing_move.brakes { machine.set_touched(true) } else { machine.halt() }
        };
        // The move always answers, because the switch ends it: it is never dropped half-way.
        // The future is large. Pinned here it takes room in the task once, and not again in the future that it is handed to.
        let moving = pin!(self.along(homing_move));
        alongside(moving, touched).await?;
        Ok(was_touched.get())
    }

    /// Moves away from the switches; they must open.
    async fn retreat(&mut self, homing_move: HomingMove) -> Result<(), Alarm> {
        // Pinned, as below: what is awaited where it is made is on the stack, too.
        let finish = pin!(self.along(homing_move)).await?;
        match finish {
            Finish::Stopped | Finish::Fault { .. } => return Err(self.stop_alarm()),
            // Homing is never held.
            Finish::Done | Finish::Held => {}
        }
        // The carriage follows its last step, and may leave the switch only then.
        Timer::after(self.machine.config().homing.debounce).await;
        self.is_settled(homing_move.axis).await;
        self.arrived(homing_move.axis).map_or(Ok(()), |motor| Err(Alarm::SwitchStuck { motor }))
    }

    async fn along(&mut self, homing_move: HomingMove) -> Result<Finish, Alarm> {
        pin!(self.travel(self.steps(homing_move), homing_move.speed_mm_s, homing_move.purpose())).await
    }

    /// The steps of the motors. A way back ends at a whole step of all axes.
    fn steps(&self, homing_move: HomingMove) -> [i32; AXES] {
        let config = self.machine.config();
        let positive =
            (config.homing.towards[homing_move.axis as usize] == Direction::Positive) == homing_move.to_switch;
        let n = config.steps(homing_move.axis, homing_move.mm);
        let mut steps = [0; AXES];
        steps[homing_move.axis as usize] = if positive { n } else { -n };
        let mut motors = config.kinematics.motors(steps);
        if !homing_move.to_switch {
            config.kinematics.end_whole(&mut motors, self.machine.motor_steps());
        }
        motors
    }
}

/// The room in which an axis may stand behind its switch, mm; no more than it can come back.
#[cold]
fn room_mm(axis: Axis, config: &Config) -> f64 {
    if config.brakes_behind(axis) { config.homing.room_mm.min(config.travel_mm[axis as usize]) } else { 0.0 }
}
