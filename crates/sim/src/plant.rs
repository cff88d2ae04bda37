//! The limit switch of one axis.
//!
//! Positions are microsteps from where the limit switch closes, positive away from it. They are the true positions,
//! which the controller knows only through the switch.

use std::collections::VecDeque;
use std::fmt;
use std::str::FromStr;

use oorandom::Rand32;

/// A fault of a limit switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SwitchFault {
    /// No fault.
    #[default]
    None,
    /// It never closes: a broken wire.
    StuckOpen,
    /// It never opens: a short to ground, or a chip jammed in it.
    StuckClosed,
}

impl fmt::Display for SwitchFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::StuckOpen => "stuck-open",
            Self::StuckClosed => "stuck-closed",
        })
    }
}

impl FromStr for SwitchFault {
    type Err = UnknownFault;

    fn from_str(name: &str) -> Result<Self, UnknownFault> {
        let known = [Self::None, Self::StuckOpen, Self::StuckClosed];
        known.into_iter().find(|fault| fault.to_string() == name).ok_or_else(|| UnknownFault(name.to_owned()))
    }
}

/// A text that names no fault of a switch.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no fault of a switch: use stuck-open, stuck-closed or none")]
pub struct UnknownFault(String);

/// Over what part of a turn the switch of an axis without an end is closed: ten degrees.
const CLOSED_OF_TURN: i32 = 36;

/// A normally open switch with bounce. It is closed from position 0, or from near it, downwards.
///
/// A mechanical switch does not always close at exactly the same position. With a scatter, each approach has its own
/// position. It is drawn from a uniform distribution when the carriage has left the whole scatter range.
#[derive(Debug)]
pub struct Switch {
    fault: SwitchFault,
    bounce_ns: u32,
    scatter_steps: i32,
    /// One turn of an axis without an end.
    turn_steps: Option<i32>,
    closes_at_steps: i32,
    is_drawn: bool,
    closed_at_steps: i32,
    touched: bool,
    flips_ns: VecDeque<u64>,
}

impl Switch {
    /// A switch with the carriage at `place_steps`; its contacts bounce for up to `bounce_ns`.
    pub fn new(place_steps: i32, fault: SwitchFault, bounce_ns: u32) -> Self {
        Self {
            fault,
            bounce_ns,
            scatter_steps: 0,
            turn_steps: None,
            closes_at_steps: 0,
            is_drawn: false,
            closed_at_steps: 0,
            touched: place_steps <= 0,
            flips_ns: VecDeque::new(),
        }
    }

    /// The same switch, but it closes up to `scatter_steps` to either side of its nominal position.
    pub fn scattering(self, scatter_steps: i32) -> Self {
        Self { scatter_steps, ..self }
    }

    /// The same switch on an axis without an end. It is closed over the last part of every turn of `turn_steps`.
    pub fn turning(self, turn_steps: Option<i32>) -> Self {
        Self { turn_steps, ..self }
    }

    /// Position of the carriage when the switch last closed.
    pub fn closed_at_steps(&self) -> i32 {
        self.closed_at_steps
    }

    /// Changes the resolution: a step becomes `scale` steps, and a turn has `turn_steps`. The scatter in mm stays the
    /// same.
    pub fn rescale(&mut self, scale: f64, turn_steps: Option<i32>) {
        self.turn_steps = turn_steps;
        for steps in [&mut self.scatter_steps, &mut self.closes_at_steps, &mut self.closed_at_steps] {
            *steps = (f64::from(*steps) * scale).round() as i32;
        }
    }

    /// Sets or clears its fault.
    pub fn set_fault(&mut self, fault: SwitchFault) {
        self.fault = fault;
    }

    /// True if its contacts conduct.
    pub fn is_closed(&self) -> bool {
        match self.fault {
            SwitchFault::None => self.touched == self.flips_ns.len().is_multiple_of(2),
            SwitchFault::StuckOpen => false,
            SwitchFault::StuckClosed => true,
        }
    }

    /// Notes that the carriage has moved to `place_steps` at `now_ns`.
    pub fn follow(&mut self, place_steps: i32, now_ns: u64, random: &mut Rand32) {
        let place_steps = self.in_turn(place_steps);
        self.draw(place_steps, random);
        let touched = place_steps <= self.closes_at_steps;
        if touched != self.touched {
            if touched {
                self.closed_at_steps = place_steps;
            }
            self.touched = touched;
            self.flips_ns = self.bounce(now_ns, random);
        }
    }

    /// The position within the turn, which begins where the switch closes downwards.
    fn in_turn(&self, place_steps: i32) -> i32 {
        self.turn_steps.map_or(place_steps, |turn_steps| {
            let closed_steps = turn_steps / CLOSED_OF_TURN;
            (place_steps + closed_steps).rem_euclid(turn_steps) - closed_steps
        })
    }

    /// Draws where it closes next. Without a scatter no random number is used, so that the bounces stay the same.
    fn draw(&mut self, place_steps: i32, random: &mut Rand32) {
        let is_clear = place_steps > self.scatter_steps;
        if is_clear && !self.is_drawn && self.scatter_steps > 0 {
            let places = 2 * self.scatter_steps.unsigned_abs() + 1;
            self.closes_at_steps = random.rand_range(0..places) as i32 - self.scatter_steps;
        }
        self.is_drawn = is_clear;
    }

    /// The next instant at which its contacts bounce.
    pub fn next_flip_ns(&self) -> Option<u64> {
        self.flips_ns.front().copied()
    }

    /// Applies every bounce up to `now_ns`.
    pub fn settle(&mut self, now_ns: u64) {
        while self.next_flip_ns().is_some_and(|at_ns| at_ns <= now_ns) {
            self.flips_ns.pop_front();
        }
    }

    /// Zero to three pairs of flips, so that the contact has the new state in the end.
    fn bounce(&self, now_ns: u64, random: &mut Rand32) -> VecDeque<u64> {
        if self.bounce_ns == 0 {
            return VecDeque::new();
        }
        let flips = 2 * random.rand_range(0..4);
        let mut at_ns: Vec<_> =
            (0..flips).map(|_| now_ns + 1 + u64::from(random.rand_range(0..self.bounce_ns))).collect();
        at_ns.sort_unstable();
        at_ns.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_switch_closes_at_its_place_and_opens_when_left() {
        let mut random = Rand32::new(1);
        let mut switch = Switch::new(5, SwitchFault::None, 0);
        for (place, closed) in [(1, false), (0, true), (-4, true), (0, true), (1, false)] {
            switch.follow(place, 0, &mut random);
            assert_eq!(switch.is_closed(), closed, "at {place}");
        }
    }

    #[test]
    fn a_switch_that_scatters_closes_elsewhere_each_time_and_once_an_approach() {
        let mut random = Rand32::new(3);
        let mut switch = Switch::new(5, SwitchFault::None, 0).scattering(2);
        let mut closed_at = [0; 5];
        for _ in 0..1_000 {
            let mut closings = 0;
            for place in (-4..=5).rev().chain(-3..=4) {
                let before = switch.is_closed();
                switch.follow(place, 0, &mut random);
                closings += u32::from(switch.is_closed() && !before);
            }
            assert_eq!(closings, 1);
            closed_at[(switch.closed_at_steps() + 2) as usize] += 1;
        }
        assert!(closed_at.iter().all(|&times| (150..250).contains(&times)), "{closed_at:?}");
        switch.rescale(2.0, None);
        assert_eq!(switch.scatter_steps, 4);
    }

    #[test]
    fn bounces_end_within_their_time_as_the_contact_stands() {
        let mut random = Rand32::new(7);
        let mut bounced = 0;
        for touch in 0..100 {
            let now_ns = touch * 1_000_000;
            let mut switch = Switch::new(1, SwitchFault::None, 500);
            switch.follow(0, now_ns, &mut random);
            assert!(switch.is_closed(), "first contact");
            while let Some(at_ns) = switch.next_flip_ns() {
                assert!((now_ns + 1..=now_ns + 500).contains(&at_ns));
                switch.settle(at_ns);
                bounced += 1;
            }
            assert!(switch.is_closed());
        }
        assert!(bounced > 100);
    }

    #[test]
    fn stuck_switches_do_not_follow() {
        for (fault, closed) in [(SwitchFault::StuckOpen, false), (SwitchFault::StuckClosed, true)] {
            let mut switch = Switch::new(5, fault, 0);
            for place in [5, -5] {
                switch.follow(place, 0, &mut Rand32::new(1));
                assert_eq!(switch.is_closed(), closed);
            }
        }
    }
}
