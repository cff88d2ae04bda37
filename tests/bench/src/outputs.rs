//! Measures how soon a stop switches the tool's outputs off. A laser and flood coolant are on; the time counts from the
//! cause until the last output is off.

use std::fmt::Write;

use anyhow::Result;
use oorandom::Rand32;
use serde::Serialize;

use super::board::{Board, ToolFigures};
use super::effort::Effort;
use super::measured::Measured;
use super::port::Port;
use super::progress::Case;

/// The latest instant of a stop, us after the laser was switched on.
const WINDOW_US: u32 = 60_000;
/// A fixed seed, so that the stops come at the same instants in every run.
const SEED: u64 = 1;
/// A crash takes the chip a second, so only one stop in this many is a crash.
const CRASH_EVERY: u32 = 20;

/// The causes of stops: the emulator's name, the name in the report, and the script that makes the stop and prepares
/// the next move.
const CAUSES: [(&str, &str, &str); 4] = [
    (
        "X_LIMIT",
        "limit switch",
        "switch X stuck-closed\nexpect ALARM:1\nswitch X normal\nwait-ms 12\nsend $X\nexpect ok",
    ),
    ("ESTOP", "emergency stop", "estop pressed\nexpect ALARM:10\nestop released\nwait-ms 12\nsend $X\nexpect ok"),
    ("RESET", "reset byte", "bytes 18\nexpect Grbl"),
    ("CRASH", "hard fault", "crash\nwait-reset\nexpect Grbl"),
];
const CRASH: u32 = 3;

/// The longest times for which the outputs stayed on.
#[derive(Clone, Debug, Serialize)]
pub struct OffFigures {
    /// Number of stops by all causes.
    pub stops: u32,
    /// The longest time for each cause, us.
    pub most_us: Vec<Off>,
}

/// The longest time for one cause.
#[derive(Clone, Debug, Serialize)]
pub struct Off {
    pub cause: &'static str,
    pub most_us: f64,
}

impl OffFigures {
    pub fn words(&self) -> String {
        let each = self.most_us.iter().map(|Off { cause, most_us }| format!("{cause} {most_us:.1}"));
        format!("{} us at most, of {} stops", each.collect::<Vec<_>>().join(", "), self.stops)
    }
}

/// Measures stops at random instants of moves with the laser on.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<Measured<OffFigures>> {
    let case = Case::named(board.chip, port, &format!("{} stops with a laser on", effort.stops));
    let off = board
        .run(&script(effort.stops), f64::from(effort.stops))?
        .and_then(|summary| off(&summary.tool, effort.stops).into());
    case.end(&off.words(OffFigures::words));
    Ok(off)
}

fn script(stops: u32) -> String {
    let mut random = Rand32::new(SEED);
    let mut script = "expect Grbl\n".to_owned();
    for line in ["$32=1", "$30=1000", "$100=80", "$110=20000", "$120=5000"] {
        writeln!(script, "send {line}\nexpect ok").expect("a String takes any text");
    }
    // The moves take place far from the switch, because each stop leaves the machine in a different position.
    script += "send G91G0X300\nexpect ok\nwait-idle\n";
    for number in 0..stops {
        let cause = if number % CRASH_EVERY == 0 { CRASH } else { random.rand_range(0..CRASH) };
        let (distance_mm, wait_us) = (if number % 2 == 0 { 40 } else { -40 }, random.rand_range(0..WINDOW_US));
        let go_on = CAUSES[cause as usize].2;
        writeln!(
            script,
            "send M4S800M8G91G1F6000X{distance_mm}\nexpect ok\nwait-output pwm on\nwait-us {wait_us}.7\n{go_on}"
        )
        .expect("a String takes any text");
    }
    script
}

fn off(tool: &ToolFigures, stops: u32) -> Result<OffFigures, String> {
    let most_us = CAUSES.map(|(input, cause, _)| {
        let own = tool.stops.iter().filter(|stop| stop.input == input);
        let most_ns = own.map(|stop| stop.outputs_off_ns.unwrap_or(f64::INFINITY)).fold(0.0, f64::max);
        Off { cause, most_us: most_ns * 1e-3 }
    });
    match most_us.iter().find(|off| !off.most_us.is_finite()) {
        Some(Off { cause, .. }) => Err(format!("after a {cause} an output stayed on")),
        None => Ok(OffFigures { stops, most_us: most_us.to_vec() }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::board::ToolStop;
    use super::*;

    #[test]
    fn the_longest_of_each_cause_is_reported() {
        let stop = |input: &str, outputs_off_ns| ToolStop { input: input.to_owned(), outputs_off_ns };
        let of = |stops| off(&ToolFigures { stops }, 3).map(|off| off.words());
        let words = of(vec![stop("ESTOP", Some(3_240.0)), stop("ESTOP", Some(1_000.0)), stop("RESET", Some(900.0))]);
        let reported = "limit switch 0.0, emergency stop 3.2, reset byte 0.9, hard fault 0.0 us at most, of 3 stops";
        assert_eq!(words.as_deref(), Ok(reported));
        assert_eq!(of(vec![stop("RESET", None)]), Err("after a reset byte an output stayed on".to_owned()));
    }

    #[test]
    fn one_stop_in_twenty_is_a_crash() {
        let script = script(40);
        assert_eq!(script.matches("\ncrash\n").count(), 2);
        assert_eq!(script.matches("wait-output pwm on").count(), 40);
    }
}
