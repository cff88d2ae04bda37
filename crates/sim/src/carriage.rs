//! A carriage between two end stops, and the field of the motor that moves it.
//!
//! The rotor follows the field, and the carriage the rotor. At an end stop both stand while the field runs on. The rotor is
//! drawn towards the end until the field is two full steps ahead. Beyond that the torque draws it back: it falls to
//! the next place in phase, four full steps behind, and comes forward with the field again. So four full steps are lost at a
//! time, and none if the field comes back before.
//!
//! Positions are microsteps from where the limit switch closes, positive away from it.

/// Torque repeats after so many full steps.
const PERIOD_FULL: i32 = 4;
/// The lead that the field can have on a rotor that is blocked, full steps.
const AHEAD_MAX_FULL: i32 = PERIOD_FULL / 2;

/// A carriage and its true position.
#[derive(Debug)]
pub struct Carriage {
    /// The place where it would be without the end stops.
    field_steps: i32,
    /// By how many half steps it is beside that: -1, 0 or 1. Belts that two motors share move it by half steps.
    beside_half_steps: i32,
    stops_steps: (i32, i32),
}

impl Carriage {
    /// A carriage at `place_steps`, between end stops at `stops_steps`.
    pub fn new(place_steps: i32, stops_steps: (i32, i32)) -> Self {
        Self { field_steps: place_steps.clamp(stops_steps.0, stops_steps.1), beside_half_steps: 0, stops_steps }
    }

    /// Its position.
    pub fn place_steps(&self) -> i32 {
        self.field_steps.clamp(self.stops_steps.0, self.stops_steps.1)
    }

    /// The lead of the field on the rotor, beyond an end stop: negative towards the switch.
    pub fn ahead_steps(&self) -> i32 {
        self.field_steps - self.place_steps()
    }

    /// Changes the resolution: a step becomes `scale` steps. The carriage keeps its position in mm, and the side of the
    /// switch it is on. The end stops are then at `stops_steps`, or at the carriage if it is beyond them.
    pub fn rescale(&mut self, scale: f64, stops_steps: (i32, i32)) {
        let scaled = |steps: i32| (f64::from(steps) * scale).round() as i32;
        let (place_steps, ahead_steps) = (self.place_steps(), self.ahead_steps());
        let place_steps = if place_steps > 0 { scaled(place_steps).max(1) } else { scaled(place_steps) };
        self.field_steps = place_steps + scaled(ahead_steps);
        self.stops_steps = (stops_steps.0.min(place_steps), stops_steps.1.max(place_steps));
    }

    /// Moves it by `steps`; returns how many of them an end stop blocked, which are lost.
    pub fn shift(&mut self, steps: i32) -> u32 {
        let wanted = self.field_steps + steps;
        self.field_steps = wanted.clamp(self.stops_steps.0, self.stops_steps.1);
        wanted.abs_diff(self.field_steps)
    }

    /// Its position in half steps.
    pub fn half_steps(&self) -> i32 {
        2 * self.place_steps() + self.beside_half_steps
    }

    /// True if no end stop keeps it from moving by so many half steps.
    pub fn may_shift_half(&self, half_steps: i32) -> bool {
        let to = self.half_steps() + half_steps;
        (2 * self.stops_steps.0..=2 * self.stops_steps.1).contains(&to)
    }

    /// Moves it by so many half steps, which no end stop blocks. Returns whether its position in whole steps is another then: of two
    /// half steps, one back and one forth, it does not change.
    pub fn shift_half(&mut self, half_steps: i32) -> bool {
        let beside = self.beside_half_steps + half_steps;
        self.field_steps += beside / 2;
        self.beside_half_steps = beside % 2;
        beside / 2 != 0
    }

    /// Turns the field by a step (1 or -1), of which a full step has `microsteps`; returns how many were lost.
    pub fn turn(&mut self, step: i32, microsteps: i32) -> u32 {
        self.field_steps += step;
        let ahead_steps = self.ahead_steps();
        if ahead_steps.abs() <= AHEAD_MAX_FULL * microsteps {
            return 0;
        }
        let lost = PERIOD_FULL * microsteps;
        self.field_steps -= ahead_steps.signum() * lost;
        lost.unsigned_abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_end_stops_steps_are_lost() {
        let mut carriage = Carriage::new(2, (-3, 10));
        assert_eq!(carriage.shift(-4), 0);
        assert_eq!(carriage.shift(-4), 3);
        assert_eq!(carriage.place_steps(), -3);
        assert_eq!(carriage.shift(15), 2);
        assert_eq!(carriage.place_steps(), 10);
    }

    #[test]
    fn with_another_resolution_the_carriage_stays_where_it_is() {
        let mut carriage = Carriage::new(100, (-150, 1_000));
        carriage.rescale(1.6, (-240, 1_600));
        assert_eq!(carriage.place_steps(), 160);
        assert_eq!(carriage.shift(2_000), 560);
        carriage.rescale(0.5, (-120, 600));
        assert_eq!(carriage.place_steps(), 800, "beyond the new end stop");
        assert_eq!(carriage.shift(1), 1);
        carriage.rescale(0.001, (-1, 2));
        carriage.rescale(0.001, (-1, 2));
        assert_eq!(carriage.place_steps(), 1, "still off its switch");
    }

    /// Steps of both directions against both ends, by what remains of them after whole periods.
    #[test]
    fn at_an_end_the_rotor_falls_back_by_four_full_steps_each_time_the_field_is_two_ahead() {
        for microsteps in [1, 8, 16, 256] {
            for (towards, end) in [(-1, -5_000), (1, 5_000)] {
                let mut carriage = Carriage::new(end, (-5_000, 5_000));
                let mut lost = 0;
                for turned in 1..=20 * microsteps {
                    lost += carriage.turn(towards, microsteps) as i32;
                    // The field is from two full steps behind the end to two ahead of it.
                    let field = (turned + 2 * microsteps - 1).rem_euclid(4 * microsteps) + 1 - 2 * microsteps;
                    assert_eq!(lost, turned - field);
                    assert_eq!(carriage.place_steps(), end + towards * field.min(0));
                    assert_eq!(carriage.ahead_steps(), towards * field.max(0));
                }
                assert_eq!(lost, 20 * microsteps);
            }
        }
    }

    #[test]
    fn of_a_field_that_comes_back_in_time_nothing_is_lost() {
        for (towards, end) in [(-1, -30), (1, 90)] {
            for ahead in 0..=16 {
                let mut carriage = Carriage::new(end, (-30, 90));
                let turns = std::iter::repeat_n(towards, ahead).chain(std::iter::repeat_n(-towards, 40));
                assert_eq!(turns.map(|step| carriage.turn(step, 8)).sum::<u32>(), 0);
                assert_eq!(carriage.place_steps(), end + towards * (ahead as i32 - 40), "{ahead} ahead");
            }
        }
    }

    #[test]
    fn the_field_stays_as_far_ahead_with_another_resolution() {
        let mut carriage = Carriage::new(-30, (-30, 90));
        (0..6).for_each(|_| assert_eq!(carriage.turn(-1, 8), 0));
        carriage.rescale(2.0, (-60, 180));
        assert_eq!((carriage.place_steps(), carriage.ahead_steps()), (-60, -12));
    }
}
