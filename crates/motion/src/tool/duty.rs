//! From levels to duties of the PWM output.

use super::power::Level;

/// The duty that makes each level. Level zero has duty zero. From the least level to the full one the duty rises
/// linearly, from the least duty to the full one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duties {
    least: Level,
    least_duty: u16,
    full_duty: u16,
    /// Duty per level, times 65,536.
    duty_per_level: u32,
}

impl Duties {
    /// `least` is the least level, the slowest at which a spindle turns. `least_duty` and `full_duty` are the duties of
    /// the least and of the full level, both of 65,535.
    #[must_use]
    pub fn new(least: Level, least_duty: u16, full_duty: u16) -> Self {
        let (duties, levels) = (full_duty.saturating_sub(least_duty), u16::MAX - least.of_65535());
        let duty_per_level = (u32::from(duties) << 16).checked_div(levels.into()).unwrap_or(0);
        Self { least, least_duty, full_duty, duty_per_level }
    }

    /// The level that is made when `level` is asked for: zero, or the least level or more.
    #[must_use]
    pub fn made(&self, level: Level) -> Level {
        if level == Level::ZERO { level } else { level.max(self.least) }
    }

    /// The duty that makes `level`, of 65,535. Below the least level it is the duty of the least level.
    #[must_use]
    pub fn duty(&self, level: Level) -> u16 {
        match level {
            Level::ZERO => 0,
            Level::FULL => self.full_duty,
            _ => {
                let above = u64::from(level.of_65535().saturating_sub(self.least.of_65535()));
                self.least_duty + ((above * u64::from(self.duty_per_level)) >> 16) as u16
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duties_are_even_between_the_least_and_the_full() {
        let plain = Duties::new(Level::ZERO, 0, u16::MAX);
        let levels = [0.0, 0.001, 0.25, 0.5, 1.0].map(Level::of_ratio);
        for level in levels {
            assert!(plain.duty(level).abs_diff(level.of_65535()) <= 1, "{level:?}");
        }
        // A spindle of 24,000 rpm, which turns from 6,000 rpm on, at a duty of 20 %, and has its full speed at 90 %.
        let spindle = Duties::new(Level::of_ratio(0.25), 13_107, 58_982);
        assert_eq!(levels.map(|level| spindle.duty(level)), [0, 13_107, 13_107, 28_398, 58_982]);
    }

    #[test]
    fn nothing_is_off_and_no_duty_is_above_the_full_one() {
        for least in [0.0, 0.3, 0.999, 1.0].map(Level::of_ratio) {
            let duties = Duties::new(least, 1_000, 50_000);
            assert_eq!(duties.duty(Level::ZERO), 0);
            let all = (1..=1_000).map(|ratio| duties.duty(Level::of_ratio(ratio as f32 / 1_000.0)));
            assert!(all.is_sorted() && duties.duty(Level::FULL) == 50_000, "{least:?}");
        }
    }
}
