//! Faults around the controller and their times. They can be combined, and each is written in one word.

use std::fmt;
use std::str::FromStr;

use isostep_motion::{Axis, Motor};

use crate::drivers::DriverFault;
use crate::vfd::VfdFault;

const NS_PER_S: f64 = 1e9;
/// A fault must begin within a day.
const LATEST_S: f64 = 86_400.0;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The wire of the emergency stop is broken: its contact seems to be open.
    BrokenEmergencyStop,
    /// Something presses the limit switch of an axis, or of its second motor.
    Limit(Motor),
    /// The wire of an axis's limit switch is broken: it never closes.
    Broken(Motor),
    /// The contact of an axis's limit switch opens and closes although nothing touches it.
    Chatter(Motor),
    /// The button of the feed hold is pressed. If this input is a safety door, the door is open.
    Hold,
    /// The button of the cycle start is pressed.
    Start,
    /// The probe touches something.
    Probe,
    /// The motor of an axis makes no step.
    Stall(Motor),
    /// Something is wrong with a drive that closes its own loop, so that it is in alarm.
    Alarm(Motor),
    /// Something is wrong with a UART driver.
    Driver(Motor, DriverFault),
    /// Something is wrong with the VFD, or with its wire.
    Vfd(VfdFault),
    /// Consoles and coordinator get no processor time.
    Starve,
    /// The host does not read.
    Deaf,
}

/// A fault: what, when, and for how long. As text `WHAT@SECONDS`, or `WHAT@SECONDS+SECONDS` for one that ends:
/// `limit:X@1.5+0.2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The kind of fault.
    pub trouble: Trouble,
    /// When it begins, ns since power-up.
    pub at_ns: u64,
    /// Its duration, ns; `None` for ever.
    pub lasts_ns: Option<u64>,
}

/// A text that does not describe a fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no fault: it is given as WHAT@SECONDS or WHAT@SECONDS+SECONDS, such as limit:X@1.5+0.2, where WHAT is one of {kinds}",
    kinds = kinds()
)]
pub struct UnknownFault(String);

/// The part before the `@`, of what belongs to no motor.
const PLAIN: [(&str, Trouble); 7] = [
    ("e-stop", Trouble::EmergencyStop),
    ("broken:e-stop", Trouble::BrokenEmergencyStop),
    ("hold", Trouble::Hold),
    ("start", Trouble::Start),
    ("probe", Trouble::Probe),
    ("starve", Trouble::Starve),
    ("deaf", Trouble::Deaf),
];

/// The troubles of a motor, its switch and its driver.
fn of_motor(motor: Motor) -> impl Iterator<Item = Trouble> {
    let own = [Trouble::Limit, Trouble::Broken, Trouble::Chatter, Trouble::Stall, Trouble::Alarm];
    own.map(|trouble| trouble(motor)).into_iter().chain(DriverFault::ALL.map(|fault| Trouble::Driver(motor, fault)))
}

/// The words for all of them.
fn kinds() -> String {
    let plain = PLAIN.iter().map(|(words, _)| (*words).to_owned());
    let of_motor = of_motor(Motor::first(Axis::X)).map(|trouble| trouble.to_string().replace(":X", ":AXIS"));
    plain
        .chain(VfdFault::ALL.map(|fault| Trouble::Vfd(fault).to_string()))
        .chain(of_motor)
        .collect::<Vec<_>>()
        .join(", ")
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Limit(motor) => write!(f, "limit:{motor}"),
            Self::Broken(motor) => write!(f, "broken:{motor}"),
            Self::Chatter(motor) => write!(f, "chatter:{motor}"),
            Self::Stall(motor) => write!(f, "stall:{motor}"),
            Self::Alarm(motor) => write!(f, "alarm:{motor}"),
            Self::Driver(motor, fault) => write!(f, "driver-{fault}:{motor}"),
            Self::Vfd(fault) => write!(f, "vfd-{fault}"),
            plain => f.write_str(PLAIN.iter().find(|(_, trouble)| trouble == plain).map_or("", |(words, _)| words)),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}@{}", self.trouble, self.at_ns as f64 / NS_PER_S)?;
        self.lasts_ns.map_or(Ok(()), |ns| write!(f, "+{}", ns as f64 / NS_PER_S))
    }
}

impl FromStr for Fault {
    type Err = UnknownFault;

    fn from_str(text: &str) -> Result<Self, UnknownFault> {
        let parsed = text.split_once('@').and_then(|(what, when)| {
            let (at, lasts) = when.split_once('+').map_or((when, None), |(at, lasts)| (at, Some(lasts)));
            let lasts_ns = match lasts {
                Some(lasts) => Some(nanoseconds(lasts)?),
                None => None,
            };
            Some(Self { trouble: trouble(what)?, at_ns: nanoseconds(at)?, lasts_ns })
        });
        parsed.ok_or_else(|| UnknownFault(text.to_owned()))
    }
}

fn nanoseconds(seconds: &str) -> Option<u64> {
    let seconds: f64 = seconds.parse().ok()?;
    (0.0..=LATEST_S).contains(&seconds).then_some((seconds * NS_PER_S).round() as u64)
}

fn trouble(what: &str) -> Option<Trouble> {
    let motors = Axis::ALL.into_iter().flat_map(|axis| [Motor::first(axis), Motor::second(axis)]);
    let plain = PLAIN.into_iter().map(|(_, trouble)| trouble);
    plain
        .chain(VfdFault::ALL.map(Trouble::Vfd))
        .chain(motors.flat_map(of_motor))
        .find(|trouble| trouble.to_string() == what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_reported_as_they_are_read() {
        let reported = [
            "e-stop@1",
            "broken:e-stop@1",
            "limit:X@1.5+0.2",
            "limit:Y2@1",
            "broken:Y@0",
            "chatter:Z@0.001+0.05",
            "hold@2+0.3",
            "start@2+0.3",
        ];
        for text in reported.into_iter().chain([
            "probe@3+1",
            "stall:X@2+0.01",
            "alarm:Y2@2+0.5",
            "driver-open-coil:Y2@1",
            "vfd-cut@1+0.5",
            "starve@4+0.05",
            "deaf@5+2",
        ]) {
            assert_eq!(text.parse::<Fault>().map(|fault| fault.to_string()).as_deref(), Ok(text));
        }
        for text in [
            "limit@1",
            "limit:2@1",
            "limit:W@1",
            "deaf:X@1",
            "deaf",
            "deaf@-1",
            "deaf@1+x",
            "deaf@1+1+1",
            "deaf@1e9",
            "",
        ] {
            let error = text.parse::<Fault>().unwrap_err().to_string();
            assert!(error.contains("such as limit:X@1.5+0.2"), "{text}: {error}");
        }
    }
}
