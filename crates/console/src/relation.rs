//! The rules between settings: what each compares, and what is said where it is broken.

use core::fmt;

use crate::axes::{X, Y};
use crate::setting_error::plain;
use crate::settings::{Carries, TRAVEL_LEAST_MM};
use crate::{AXES, AXIS_NAMES, Error, Settings, setting_table};

/// A rule between settings: the limit that is broken, if it is (0 where the text names none), Grbl's error, and the text. There
/// `#n` stands for a setting and its value, `$n` for its number (of those that each axis has, X's), `*` for the limit, `@` for
/// the axis and `&` for its unit of length.
type Rule = (Option<f32>, Error, &'static str);

const RULES: usize = 16;

/// The rules for an axis, in the order in which they are checked. The first three are the same for all.
#[rustfmt::skip]
fn rules(s: &Settings, axis: usize, carries: Carries<'_>) -> [Rule; RULES] {
    let (steps_per_mm, start_mm_min) = (s.steps_per_mm[axis], s.start_rate_mm_min[axis]);
    let [least, most] = setting_table::find(100).map(|(row, _)| [row.min, row.max]).unwrap_or_default();
    let if_so = |is_broken: bool| is_broken.then_some(0.0);
    [
        (if_so(s.soft_limits && !s.homing), Error::SoftLimitsNeedHoming,
            "#20 needs a machine that homes: set $22=1 or $20=0"),
        (if_so(s.spindle_min_rpm >= s.spindle_max_rpm), Error::BadNumber,
            "#31 is not below the S at full duty, #30 rpm: lower $31 or raise $30"),
        (if_so(s.pwm_least_percent > s.pwm_full_percent), Error::BadNumber,
            "#35 is above the duty at $30, #36 %: lower $35 or raise $36"),
        ((!s.has_travel(axis)).then_some(TRAVEL_LEAST_MM), Error::BadNumber,
            "#130 is below the least, * &: raise it"),
        (if_so(s.offset_mm(axis) == 0.0 && s.homing_pull_off_mm >= s.reach_mm(axis)), Error::BadNumber,
            "#27 is not below the travel of @, #130 &: lower $27 or raise $130"),
        (if_so(s.homing_pull_off_mm + s.offset_mm(axis).abs() >= s.reach_mm(axis)), Error::BadNumber,
            "#27 with the offset of the second motor, #170, is not below the travel of @, #130 &: lower $27 or raise $130"),
        // Other microsteps may have led the steps per millimetre beyond their range.
        ((steps_per_mm < least).then_some(least), Error::BadNumber,
            "#100 is below the least, * steps/&: raise it"),
        ((steps_per_mm > most).then_some(most), Error::BadNumber,
            "#100 is above the most, * steps/&: lower it"),
        (beyond_step_rate(s, axis, carries), Error::RateTooHigh,
            "#110 is above the * &/min that the step outputs carry with #0 at #100 steps/&: lower one of the three"),
        (if_so(start_mm_min > s.max_rate_mm_min[axis]), Error::RateTooHigh,
            "#910 is above the top speed, #110 &/min: lower $910 or raise $110"),
        (if_so(s.needs_start() && start_mm_min == 0.0), Error::BadNumber,
            "#940 is a speed profile over displacement and never leaves standstill: raise $910 above 0, or lower $940"),
        (if_so(s.speed_profile != 0 && s.shaper_kind[axis] != 0), Error::BadNumber,
            "#950 and #940 do not work together, as only the trapezoid is shaped: set $950=0 or $940=0"),
        (if_so(s.speed_profile != 0 && s.switch_room_mm != 0.0), Error::BadNumber,
            "#906 and #940 do not work together, as only the trapezoid brakes within a room: set $906=0 or $940=0"),
        (not_as_x(s, axis), Error::BadNumber,
            "#100 is not the * steps/mm of X, but with #907 both motors move both axes: make them the same"),
        (if_so(s.has_crossed_belts() && axis <= Y && s.second_motor() == Some(axis)), Error::BadNumber,
            "#905 asks for a second motor of @, which with #907 has two already: set $905=0 or $907=0"),
        (beyond_room(s, axis), Error::BadNumber,
            "#25 is above the * &/min from which @ brakes within the room behind its switch, #906 &: lower $25 or raise $906"),
    ]
}

/// The time for which a homing seek goes on after its switch before it brakes, at most, s: as the machine has it.
const SEEK_GOES_ON_S: f64 = 16e-3;

/// The highest speed of a homing seek, mm/min, if that of the axis does not brake within the room behind its switch.
fn beyond_room(settings: &Settings, axis: usize) -> Option<f32> {
    let room_mm = f64::from(settings.switch_room_mm);
    if room_mm == 0.0 || !settings.seeks_switch(axis) || settings.second_motor() == Some(axis) {
        return None;
    }
    let decel_mm_s2 = f64::from(settings.decel_mm_s2()[axis]);
    let asked_mm_s = f64::from(settings.homing_seek_mm_min.min(settings.max_rate_mm_min[axis])) / 60.0;
    let brakes_mm = asked_mm_s * (SEEK_GOES_ON_S + asked_mm_s / decel_mm_s2 / 2.0);
    let most_mm_s =
        decel_mm_s2 * (libm::sqrt(SEEK_GOES_ON_S * SEEK_GOES_ON_S + 2.0 * room_mm / decel_mm_s2) - SEEK_GOES_ON_S);
    (brakes_mm > room_mm).then(|| libm::truncf((most_mm_s * 60.0) as f32))
}

/// The steps/mm of X, if crossed belts move `axis` and it has others.
fn not_as_x(settings: &Settings, axis: usize) -> Option<f32> {
    let steps_per_mm = settings.steps_per_mm;
    (settings.has_crossed_belts() && axis == Y && steps_per_mm[axis] != steps_per_mm[X]).then_some(steps_per_mm[X])
}

/// The highest top speed of an axis, mm/min, if it needs a higher step rate than the step outputs carry.
fn beyond_step_rate(settings: &Settings, axis: usize, carries: Carries<'_>) -> Option<f32> {
    let (asked_mm_min, steps_per_mm) = (settings.max_rate_mm_min[axis], settings.steps_per_mm[axis]);
    // Computed as the machine does it. Rounded to `f32`, a rate just above the limit would pass.
    let asked_steps_s = f64::from(asked_mm_min) / 60.0 * f64::from(steps_per_mm);
    let max_steps_s = carries(settings.pulse_us);
    // Truncated, not rounded, so that the value in the message is itself acceptable.
    (asked_steps_s > f64::from(max_steps_s)).then(|| libm::truncf(max_steps_s * 60.0 / steps_per_mm))
}

/// A rule between settings that is broken. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict<'s> {
    settings: &'s Settings,
    axis: usize,
    limit: f32,
    error: Error,
    text: &'static str,
}

impl<'s> Conflict<'s> {
    /// The first rule that is broken.
    pub(crate) fn first(settings: &'s Settings, carries: Carries<'_>) -> Option<Self> {
        for axis in 0..AXES {
            for (limit, error, text) in rules(settings, axis, carries) {
                if let Some(limit) = limit {
                    return Some(Self { settings, axis, limit, error, text });
                }
            }
        }
        None
    }

    /// Grbl's error for this, or the most similar one.
    pub fn error(&self) -> Error {
        self.error
    }

    /// The numbers of the settings that do not work together.
    pub fn numbers(&self) -> impl Iterator<Item = u16> {
        self.text.split(MARKS).filter_map(|part| leading(part).0).map(|number| self.number(number))
    }

    /// The setting of the axis, for that of X.
    fn number(&self, number: u16) -> u16 {
        let is_of_each_axis = setting_table::find(number).is_some_and(|(row, _)| row.numbers().len() > 1);
        if is_of_each_axis { number + self.axis as u16 } else { number }
    }
}

const MARKS: [char; 5] = ['#', '$', '*', '@', '&'];

/// The number that a text begins with, and the rest.
fn leading(text: &'static str) -> (Option<u16>, &'static str) {
    let end = text.bytes().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    (digits.parse().ok(), rest)
}

impl fmt::Display for Conflict<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { settings, axis, limit, mut text, .. } = *self;
        while let Some(place) = text.find(MARKS) {
            f.write_str(&text[..place])?;
            let mark = text.as_bytes()[place];
            let (number, rest) = leading(&text[place + 1..]);
            let number = self.number(number.unwrap_or_default());
            match mark {
                b'#' => write!(f, "${number}={}", plain(settings.get(number).unwrap_or_default()))?,
                b'$' => write!(f, "${number}")?,
                b'*' => write!(f, "{}", plain(limit))?,
                b'@' => f.write_str(AXIS_NAMES[axis])?,
                _ => f.write_str(settings.unit(axis))?,
            }
            text = rest;
        }
        f.write_str(text)
    }
}

impl core::error::Error for Conflict<'_> {}

/// Why settings do not work together. They are kept, but nothing moves with them. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unfit<'s>(pub Conflict<'s>);

impl fmt::Display for Unfit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; until then nothing moves", self.0)
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;
    use std::vec::Vec;

    use super::*;

    type Change = fn(&mut Settings);

    /// The first rule that `change` breaks, in words.
    fn broken(change: Change) -> std::string::String {
        let mut settings = Settings::DEFAULT;
        change(&mut settings);
        let conflict = settings.check(&|_| 3_000.0).unwrap_err();
        std::format!("error:{} {conflict}", conflict.error().code())
    }

    #[test]
    fn a_broken_rule_names_settings_values_limit_and_remedy() {
        assert_eq!(Settings::DEFAULT.check(&|_| 3_000.0), Ok(()));
        let rows: &[(Change, &str)] = &[
            (|s| s.homing = false, "error:10 $20=1 needs a machine that homes: set $22=1 or $20=0"),
            (
                |s| s.spindle_min_rpm = 1000.5,
                "error:2 $31=1000.500 is not below the S at full duty, $30=1000 rpm: lower $31 or raise $30",
            ),
            (
                |s| (s.pwm_least_percent, s.pwm_full_percent) = (60.0, 50.0),
                "error:2 $35=60 is above the duty at $30, $36=50 %: lower $35 or raise $36",
            ),
            (|s| s.travel_mm[1] = 0.0, "error:2 $131=0 is below the least, 1 mm: raise it"),
            (
                |s| (s.homing_pull_off_mm, s.travel_mm[1]) = (100.0, 100.0),
                "error:2 $27=100 is not below the travel of Y, $131=100 mm: lower $27 or raise $131",
            ),
            (
                |s| (s.second_motor_axis, s.square_offset_mm[1], s.travel_mm[1]) = (2, -1.5, 3.0),
                "error:2 $27=2 with the offset of the second motor, $171=-1.500, is not below the travel of Y, $131=3 mm: \
                 lower $27 or raise $131",
            ),
            (|s| s.steps_per_mm[1] = 0.05, "error:2 $101=0.050 is below the least, 0.100 steps/mm: raise it"),
            (|s| s.steps_per_mm[1] = 10_001.0, "error:2 $101=10001 is above the most, 10000 steps/mm: lower it"),
            (
                |s| (s.steps_per_mm[1], s.pulse_us) = (70.0, 4),
                "error:12 $111=2880 is above the 2571 mm/min that the step outputs carry with $0=4 at $101=70 steps/mm: \
                 lower one of the three",
            ),
            (
                |s| s.start_rate_mm_min[1] = 2881.0,
                "error:12 $911=2881 is above the top speed, $111=2880 mm/min: lower $911 or raise $111",
            ),
            (
                |s| (s.speed_profile, s.start_rate_mm_min[0]) = (3, 60.0),
                "error:2 $940=3 is a speed profile over displacement and never leaves standstill: raise $911 above 0, or lower $940",
            ),
            (
                |s| (s.speed_profile, s.shaper_kind[1]) = (1, 4),
                "error:2 $951=4 and $940=1 do not work together, as only the trapezoid is shaped: set $951=0 or $940=0",
            ),
            (
                |s| (s.speed_profile, s.switch_room_mm) = (1, 3.0),
                "error:2 $906=3 and $940=1 do not work together, as only the trapezoid brakes within a room: set $906=0 or $940=0",
            ),
            (
                |s| (s.kinematics, s.steps_per_mm[1]) = (1, 50.5),
                "error:2 $101=50.500 is not the 50 steps/mm of X, but with $907=1 both motors move both axes: make them the same",
            ),
            (
                |s| (s.kinematics, s.second_motor_axis) = (1, 2),
                "error:2 $905=2 asks for a second motor of Y, which with $907=1 has two already: set $905=0 or $907=0",
            ),
            // 50 (sqrt(0.016² + 2 * 0.5 / 50) - 0.016) = 6.316 mm/s.
            (
                |s| (s.switch_room_mm, s.accel_mm_s2[0]) = (0.5, 1000.0),
                "error:2 $25=600 is above the 378 mm/min from which Y brakes within the room behind its switch, $906=0.500 mm: \
                 lower $25 or raise $906",
            ),
        ];
        for &(change, words) in rows {
            assert_eq!(broken(change), words);
        }
        assert_eq!(rows.len(), RULES);
    }

    #[test]
    fn a_rule_names_settings_that_there_are() {
        for (_, _, text) in rules(&Settings::DEFAULT, 0, &|_| 1.0) {
            let numbers = text.split(['#', '$']).skip(1).map(|part| leading(part).0.unwrap());
            let unknown: Vec<_> = numbers.filter(|&number| setting_table::find(number).is_none()).collect();
            assert_eq!(unknown, [0; 0], "{text}");
        }
        let mut settings = Settings::DEFAULT;
        settings.speed_profile = 3;
        let numbers: Vec<_> =
            settings.check(&|_| 1.0).unwrap_err().numbers().map(|number| number.to_string()).collect();
        assert_eq!(numbers, ["110", "0", "100"], "the first broken rule");
        let settings = Settings { travel_mm: core::array::from_fn(|axis| [100.0, 1.0][axis % 2]), ..Settings::DEFAULT };
        let numbers: Vec<_> = settings.check(&|_| 3_000.0).unwrap_err().numbers().collect();
        assert_eq!(numbers, [27, 131, 27, 131], "of the axis, as often as the text names them");
    }
}
