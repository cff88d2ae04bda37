//! The task that turns the spindle by a VFD, and watches it.

use core::convert::Infallible;

use embassy_futures::select::select;
use embassy_time::{Duration, Instant, Timer};
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::Settings;
use isostep_motion::{Spindle, SpindleFault, SpindleWanted, State};

use super::exchange::{VfdOnWire, VfdRequest};
use super::report::VfdHealth;
use super::types::{Monitor, Type};
use super::{LineFormat, Parity, Vfd, VfdKnown, VfdWire};
use crate::controller::Controller;
use crate::news::News;

/// The time between two rounds. A round is one exchange, or a few when something else is wanted.
const PAUSE_MS: u64 = 50;
/// What stands beside is read in one round of so many.
const BESIDE_ROUNDS: u8 = 4;
/// A spindle that is off its speed in so many rounds in a row has left it.
const DEVIATES_ROUNDS: u8 = 2;
/// `$394=0`.
const REACHES_DEFAULT_S: f32 = 10.0;

impl<F: NorFlash> Controller<'_, F> {
    /// Says that the board has a wire to a VFD. If it is true, `$395` has chosen one, and [`watch_vfd`](Self::watch_vfd) has to be
    /// called. Call it after [`load`](Self::load) and before a console is served. Another `$395` is in force from the next start
    /// on; until then M3 is refused.
    pub fn takes_vfd(&self) -> bool {
        let number = self.with(|program| program.settings.spindle_type);
        self.vfd.served.set(number);
        number != 0
    }

    /// From then on turns the spindle by the VFD as the machine's state says, at first not at all, and asks it some ten times a
    /// second how it does. If it fails while the spindle turns, or is to turn, it stops the machine.
    ///
    /// # Cancellation
    /// The spindle goes on as it does, and nobody watches it any more.
    pub async fn watch_vfd<W: VfdWire>(&self, mut wire: W) -> Infallible {
        let mut follower = Follower::new();
        loop {
            self.vfd_round(&mut wire, &mut follower).await;
            if !follower.has_more {
                select(self.machine.wait_spindle(), Timer::after_millis(PAUSE_MS)).await;
            }
        }
    }

    /// True if the VFD is not known yet to do what is wanted.
    pub fn vfd_settles(&self) -> bool {
        let Vfd { known, settled, .. } = &self.vfd;
        let is_known = known.get().health != VfdHealth::Unknown && settled.get() == Some(self.machine.spindle_wanted());
        self.vfd.is_served() && !is_known
    }

    async fn vfd_round<W: VfdWire>(&self, wire: &mut W, follower: &mut Follower) {
        let wanted = self.machine.spindle_wanted();
        let order = self.with(|program| Order::of(self.vfd.served.get(), &program.settings, wanted));
        follower.take(&order);
        let mut vfd = VfdOnWire {
            wire,
            line: order.line,
            address: order.address,
            timeout: order.timeout,
            known_at: &mut follower.known_at,
            repeats: 0,
        };
        let mut asked = follower.asked;
        let mut read = Reading::default();
        let result = asked.follow(&order, self.vfd.known.get().rpm, follower.rounds, &mut vfd, &mut read).await;
        self.vfd.repeats.set(self.vfd.repeats.get().wrapping_add(vfd.repeats));
        self.vfd.exchanges.set(self.vfd.exchanges.get().wrapping_add(1));
        follower.rounds = (follower.rounds + 1) % BESIDE_ROUNDS;
        let was_running = follower.asked.runs() || asked.runs();
        follower.asked = asked;
        let was_reached = follower.is_reached;
        let result = result.and_then(|()| follower.judge(&order, &read));
        if follower.is_reached && !was_reached {
            self.machine.spindle_at_speed(order.wanted);
        }
        self.conclude(&order, follower, read, result, was_running);
    }

    /// Tells what a round has found, and stops the machine if that has to be.
    fn conclude(
        &self,
        order: &Order,
        follower: &mut Follower,
        read: Reading,
        result: Result<(), (VfdHealth, u16)>,
        was_running: bool,
    ) {
        let vfd = &self.vfd;
        let before = vfd.known.get();
        let (health, register) = result.err().unwrap_or((VfdHealth::Well, order.vfd.speed_register()));
        let known = VfdKnown {
            health,
            register,
            rpm: read.rpm.unwrap_or(before.rpm),
            wanted_rpm: order.rpm,
            amperes: read.amperes.or(before.amperes),
        };
        vfd.known.set(known);
        let mut locks = false;
        if health != VfdHealth::Well {
            // What it has taken is not known any more, so it is told again; first that it is to stop.
            follower.asked = VfdTaken { direction: follower.asked.direction, ..VfdTaken::NOTHING };
            follower.is_reached = false;
            locks = (order.turns() || was_running) && !matches!(self.machine.state(), State::Alarm(_));
        }
        if locks {
            vfd.failed.set(Some(known));
            let is_of_speed = health.is_of_speed();
            self.machine.spindle_failed(if is_of_speed { SpindleFault::Speed } else { SpindleFault::Drive });
        } else if health != before.health && !(health == VfdHealth::Well && before.health.is_quiet()) {
            self.publish(News::Vfd);
        }
        // What has failed is not waited for.
        let settles = health == VfdHealth::Well && !follower.is_settled(order);
        follower.has_more = settles && follower.asked.lacks(order);
        vfd.settled.set((!settles).then_some(order.wanted));
    }
}

/// What is wanted of the VFD in a round, by the settings of that time.
struct Order {
    vfd: Type,
    wanted: SpindleWanted,
    rpm: f32,
    /// How far from that the spindle may turn, rpm.
    within_rpm: f32,
    reaches_within: Duration,
    line: LineFormat,
    address: u8,
    timeout: Duration,
}

impl Order {
    fn of(number: u16, settings: &Settings, wanted: SpindleWanted) -> Self {
        let vfd = Type::of(number, settings);
        let rpm = wanted.level.ratio() * settings.spindle_max_rpm;
        let reaches_s = if settings.spin_up_s == 0.0 { REACHES_DEFAULT_S } else { settings.spin_up_s };
        Self {
            wanted,
            rpm,
            within_rpm: (rpm * settings.at_speed_percent / 100.0).max(vfd.rpm_per_word),
            reaches_within: Duration::from_millis((reaches_s * 1e3) as u64),
            line: LineFormat {
                baud: settings.modbus_baud(),
                parity: match settings.modbus_parity {
                    0 => Parity::None,
                    1 => Parity::Even,
                    _ => Parity::Odd,
                },
            },
            address: settings.vfd_address as u8,
            timeout: Duration::from_millis(settings.modbus_timeout_ms.into()),
            vfd,
        }
    }

    fn turns(&self) -> bool {
        self.wanted.spindle != Spindle::Off
    }

    /// A spindle that is slower than this may be told to turn in the other direction.
    fn is_slow(&self, rpm: f32) -> bool {
        rpm <= self.within_rpm.max(self.vfd.rpm_per_word)
    }

    /// The word of the speed. The cast saturates: a VFD that cannot be so fast is too late.
    fn speed_word(&self) -> u16 {
        (self.rpm * self.vfd.word_per_rpm + 0.5) as u16
    }
}

/// What the VFD has taken; `None` if nobody knows.
#[derive(Clone, Copy)]
struct VfdTaken {
    spindle: Option<Spindle>,
    speed: Option<u16>,
    /// The direction in which it was asked to turn last.
    direction: Spindle,
    /// The enable output may have been off since then: to turn it has to be told again.
    is_stale: bool,
}

impl VfdTaken {
    const NOTHING: Self = Self { spindle: None, speed: None, direction: Spindle::Off, is_stale: false };

    /// True if it can be told at once what is wanted next.
    fn lacks(&self, order: &Order) -> bool {
        let reverses = self.direction != Spindle::Off && self.direction != order.wanted.spindle;
        let is_told = self.has_taken(order.wanted.spindle) && self.speed == Some(order.speed_word());
        order.turns() && !reverses && !is_told
    }

    /// True if it has been told so, and heeds it.
    fn has_taken(&self, spindle: Spindle) -> bool {
        self.spindle == Some(spindle) && !self.is_stale
    }

    fn runs(&self) -> bool {
        self.spindle.is_some_and(|spindle| spindle != Spindle::Off)
    }

    /// Has the VFD do the next of what is wanted, and reads what it does: so it is never long unknown.
    async fn follow<W: VfdWire>(
        &mut self,
        order: &Order,
        rpm: f32,
        rounds: u8,
        vfd: &mut VfdOnWire<'_, W>,
        read: &mut Reading,
    ) -> Result<(), (VfdHealth, u16)> {
        let wanted = order.wanted.spindle;
        let reverses = order.turns() && !matches!(self.direction, Spindle::Off) && self.direction != wanted;
        // A spindle that turns in the other direction, or of which nothing is known, stops first.
        let stops = wanted == Spindle::Off || self.spindle.is_none() || reverses;
        let word = order.speed_word();
        if stops && self.spindle != Some(Spindle::Off) {
            self.run(order, Spindle::Off, vfd).await?;
        } else if order.turns() && (!reverses || order.is_slow(rpm)) {
            // First the speed, so that it never heads for the one before.
            if self.speed != Some(word) {
                let (how, register) = order.vfd.speed;
                ask(vfd, VfdRequest::write(how, register, word)).await?;
                self.speed = Some(word);
            } else if !self.has_taken(wanted) {
                self.run(order, wanted, vfd).await?;
                self.direction = wanted;
            }
        }
        read.take(order, &order.vfd.monitor, vfd).await?;
        match &order.vfd.beside {
            Some(beside) if rounds == 0 => read.take(order, beside, vfd).await,
            _ => Ok(()),
        }
    }

    async fn run<W: VfdWire>(
        &mut self,
        order: &Order,
        spindle: Spindle,
        vfd: &mut VfdOnWire<'_, W>,
    ) -> Result<(), (VfdHealth, u16)> {
        let (how, register, [clockwise, counter_clockwise, stop]) = order.vfd.run;
        let word = match spindle {
            Spindle::Off => stop,
            Spindle::Clockwise => clockwise,
            Spindle::CounterClockwise => counter_clockwise,
        };
        // If the reply is lost it may have been taken.
        if spindle != Spindle::Off {
            self.spindle = Some(spindle);
        }
        ask(vfd, VfdRequest::write(how, register, word)).await?;
        (self.spindle, self.is_stale) = (Some(spindle), false);
        Ok(())
    }
}

async fn ask<W: VfdWire>(vfd: &mut VfdOnWire<'_, W>, request: VfdRequest) -> Result<(), (VfdHealth, u16)> {
    vfd.exchange(&request).await.map(|_| ()).map_err(|health| (health, request.register))
}

/// What was read in a round.
#[derive(Clone, Copy, Default)]
struct Reading {
    rpm: Option<f32>,
    amperes: Option<f32>,
}

impl Reading {
    async fn take<W: VfdWire>(
        &mut self,
        order: &Order,
        monitor: &Monitor,
        vfd: &mut VfdOnWire<'_, W>,
    ) -> Result<(), (VfdHealth, u16)> {
        let &Monitor { read, register, words: count, speed, current, fault } = monitor;
        let request = VfdRequest::read(read, register, count);
        let words = vfd.exchange(&request).await.map_err(|health| (health, register))?;
        let word = |index: u8| words[usize::from(index)];
        if let Some(index) = speed {
            self.rpm = Some(f32::from(word(index)) * order.vfd.rpm_per_word);
        }
        if let Some((index, amperes)) = current {
            self.amperes = Some(f32::from(word(index)) * amperes);
        }
        match fault {
            Some((index, mask)) if word(index) & mask != 0 => {
                Err((VfdHealth::Tripped(word(index) & mask), register + u16::from(index)))
            }
            _ => Ok(()),
        }
    }
}

/// What is known of the VFD from round to round.
struct Follower {
    asked: VfdTaken,
    wanted: SpindleWanted,
    /// Since when that is wanted.
    since: Instant,
    /// The spindle has its speed.
    is_reached: bool,
    /// Rounds since then in which it had not.
    off_rounds: u8,
    known_at: Instant,
    rounds: u8,
    /// The next round is due at once.
    has_more: bool,
}

impl Follower {
    fn new() -> Self {
        let now = Instant::now();
        Self {
            asked: VfdTaken::NOTHING,
            wanted: SpindleWanted::default(),
            since: now,
            is_reached: false,
            off_rounds: 0,
            known_at: now,
            rounds: 0,
            has_more: false,
        }
    }

    /// Takes what is wanted now.
    fn take(&mut self, order: &Order) {
        let (wanted, before) = (order.wanted, core::mem::replace(&mut self.wanted, order.wanted));
        if wanted == before {
            return;
        }
        (self.since, self.is_reached, self.off_rounds) = (Instant::now(), false, 0);
        // The enable output may have been off meanwhile.
        if wanted.turns != before.turns && self.asked.spindle == Some(wanted.spindle) {
            if order.turns() {
                self.asked.is_stale = true;
            } else {
                self.asked.spindle = None;
            }
        }
    }

    fn is_settled(&self, order: &Order) -> bool {
        self.asked.has_taken(order.wanted.spindle) && (self.is_reached || !order.turns())
    }

    fn judge(&mut self, order: &Order, read: &Reading) -> Result<(), (VfdHealth, u16)> {
        let rpm = read.rpm.unwrap_or_default();
        let is_late = self.since.elapsed() > order.reaches_within;
        let fails = |health| Err((health, order.vfd.speed_register()));
        if !order.turns() {
            return if is_late && rpm > order.within_rpm { fails(VfdHealth::Runs) } else { Ok(()) };
        }
        // On its way to the speed before it may pass this one.
        let is_told = self.asked.has_taken(order.wanted.spindle) && self.asked.speed == Some(order.speed_word());
        let is_off = (rpm - order.rpm).abs() > order.within_rpm || !is_told;
        if !is_off {
            (self.is_reached, self.off_rounds) = (true, 0);
        } else if self.is_reached {
            self.off_rounds += 1;
            if self.off_rounds >= DEVIATES_ROUNDS {
                return fails(VfdHealth::Deviates);
            }
        } else if is_late {
            return fails(VfdHealth::Late);
        }
        Ok(())
    }
}
