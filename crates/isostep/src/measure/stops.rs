//! The delay of a stop: from an input, a second reset byte, or the last edge of an axis whose port faults, to the last edge of
//! any axis.

use anyhow::Result;

use super::board::Board;
use super::figure::{Better, Figure, Findings};
use crate::screen::grouped;

/// A cause that stops a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// X's limit switch.
    LimitSwitch,
    /// The limit switch of the first of Y's two motors.
    FirstMotor,
    /// That of the second.
    SecondMotor,
    /// The emergency stop.
    EmergencyStop,
    /// The byte 0x18 from the console, while the machine brakes because of a first one.
    SecondReset,
    /// A step port that runs dry, because the task that feeds it gets no time.
    DryPort,
    /// A step that comes too late, because the processor cannot make the steps as fast as they are due.
    LateStep,
}

/// Some stops by one cause.
#[derive(Clone, Debug, Default)]
pub struct Stops {
    /// The rate of each axis, steps/s.
    pub rate_steps_s: u32,
    /// The time from the cause to the last edge of any axis, of each stop, us.
    pub latencies_us: Vec<f64>,
    /// The most steps by which a reported position was beside the edges counted; none if no position was reported.
    pub astray_steps: Option<u64>,
}

impl Cause {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::LimitSwitch => "limit switch",
            Self::FirstMotor => "limit switch of Y's first motor",
            Self::SecondMotor => "limit switch of its second motor",
            Self::EmergencyStop => "emergency stop",
            Self::SecondReset => "second reset byte",
            Self::DryPort => "last edge of a step port that runs dry",
            Self::LateStep => "last edge of an axis whose step comes too late",
        }
    }

    /// The key of its figures. Inputs have the numbers of a Pico's pads.
    pub fn key(self) -> &'static str {
        match self {
            Self::LimitSwitch => "stop.9",
            Self::FirstMotor => "stop.first",
            Self::SecondMotor => "stop.second",
            Self::EmergencyStop => "stop.12",
            Self::SecondReset => "stop.reset",
            Self::DryPort => "stop.dry",
            Self::LateStep => "stop.late",
        }
    }
}

/// Measures `count` stops by each cause, of moves at a rate that the board may choose otherwise.
///
/// # Errors
/// When the board is gone.
pub fn measure(
    board: &mut dyn Board,
    found: &mut Findings,
    causes: &[Cause],
    rate_steps_s: u32,
    count: u32,
) -> Result<()> {
    for &cause in causes {
        board.note(&format!("{count} stops by the {}", cause.name()));
        let (key, what) = (cause.key(), format!("from the {} to the last edge of any axis", cause.name()));
        let most = Figure::new(key, format!("{what}, at most"), "us");
        match board.stops(cause, rate_steps_s, count)? {
            Ok(stops) => add(found, board.method().unit_ns, key, &what, most, &stops),
            Err(why_not) => found.add(most.missing(why_not)),
        }
    }
    Ok(())
}

fn add(found: &mut Findings, unit_ns: f64, key: &str, what: &str, most: Figure, stops: &Stops) {
    let Stops { rate_steps_s, latencies_us, astray_steps } = stops;
    let count = latencies_us.len();
    let finely = format!("{}, {count} stops at {} steps/s", super::finely(unit_ns), grouped((*rate_steps_s).into()));
    let most_us = latencies_us.iter().copied().fold(0.0, f64::max);
    let mean_us = latencies_us.iter().sum::<f64>() / count.max(1) as f64;
    let period_us = 1e6 / f64::from(*rate_steps_s);
    let compared =
        |figure: Figure| {
            figure
                .flattered_by("the last edge comes up to a period before the stop; more stops find the worst")
                .compared(Better::Lower, 0.2, period_us)
        };
    found.add(compared(most.measured(most_us, &*finely)));
    found.add(compared(Figure::new(format!("{key}.mean"), format!("{what}, mean"), "us").measured(mean_us, finely)));
    let astray =
        Figure::new(format!("{key}.position"), format!("{what}: the position reported then is off by"), "steps");
    found.add(match astray_steps {
        Some(steps) => {
            let figure = astray.measured(*steps as f64, "a step").compared(Better::Lower, 0.0, 0.0);
            figure.promised(0.0)
        }
        None => astray.missing("no position was reported"),
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(stops: &Stops) -> Findings {
        let mut found = Findings::default();
        add(&mut found, 8.0, "stop.9", "from there", Figure::new("stop.9", "from there", "us"), stops);
        found
    }

    #[test]
    fn stops_have_a_longest_a_mean_and_a_position() {
        let stops = Stops { rate_steps_s: 250_000, latencies_us: vec![3.0, 1.0, 5.0], astray_steps: Some(0) };
        let found = of(&stops);
        let value = |key: &str| found.figure(key).unwrap().value;
        assert_eq!([value("stop.9"), value("stop.9.mean"), value("stop.9.position")], [5.0, 3.0, 0.0].map(Some));
        assert_eq!(found.figure("stop.9").unwrap().tolerance_least, 4.0, "a period");
        assert!(found.broken().is_empty());
        assert!(of(&Stops { astray_steps: Some(1), ..stops.clone() }).broken()[0].contains("off by, 1 steps"));
        let unknown = of(&Stops { astray_steps: None, ..stops });
        assert_eq!(unknown.figure("stop.9.position").unwrap().verdict(None), "no position was reported");
    }
}
