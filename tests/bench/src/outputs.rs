//! Measures how soon a stop switches the tool's outputs off. A laser and flood coolant are on; the time counts from the
//! cause until the last output is off.

use std::fmt::Write;

use anyhow::Result;
use isostep::measure::{Better, Figure, Findings, Measured, finely};
use oorandom::Rand32;

use super::runs::{Job, Runs, ToolFigures};

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

/// Measures stops at random instants of moves with the laser on.
pub fn measure(runs: &Runs, found: &mut Findings, stops: u32) -> Result<()> {
    let ran = runs.run(Job::Script(&script(stops)), f64::from(stops))?;
    let unit = finely(runs.candidate.model.chip().cycle_ns());
    add(found, stops, &unit, ran.map(|summary| summary.tool));
    Ok(())
}

/// The longest time for each cause.
fn add(found: &mut Findings, stops: u32, unit: &str, tool: Measured<ToolFigures>) {
    for (input, cause, _) in CAUSES {
        let what = format!("from the cause ({cause}) to a dark laser and coolant off, at most");
        let figure = Figure::new(format!("dark.{input}"), what, "us").compared(Better::Lower, 0.2, 0.5);
        let longest = tool.as_ref().map(|tool| {
            let own = tool.stops.iter().filter(|stop| stop.input == input);
            own.map(|stop| stop.outputs_off_ns.unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
        });
        found.add(match longest {
            Ok(ns) if ns.is_finite() => figure.measured(ns * 1e-3, format!("{unit}, {stops} stops by all causes")),
            Ok(_) => figure.missing(format!("after a {cause} an output stayed on")),
            Err(why_not) => figure.missing(why_not),
        });
    }
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

#[cfg(test)]
mod tests {
    use super::super::runs::ToolStop;
    use super::*;

    #[test]
    fn the_longest_of_each_cause_is_reported() {
        let stop = |input: &str, outputs_off_ns| ToolStop { input: input.to_owned(), outputs_off_ns };
        let of = |stops| {
            let mut found = Findings::default();
            add(&mut found, 3, "8 ns", Ok(ToolFigures { stops }));
            found
        };
        let found = of(vec![stop("ESTOP", Some(3_240.0)), stop("ESTOP", Some(1_000.0)), stop("RESET", Some(900.0))]);
        let values =
            ["X_LIMIT", "ESTOP", "RESET", "CRASH"].map(|input| found.figure(&format!("dark.{input}")).unwrap().value);
        assert_eq!(values, [0.0, 3.24, 0.9, 0.0].map(Some));
        let on = of(vec![stop("RESET", None)]);
        assert_eq!(on.figure("dark.RESET").unwrap().verdict(None), "after a reset byte an output stayed on");
    }

    #[test]
    fn one_stop_in_twenty_is_a_crash() {
        let script = script(40);
        assert_eq!(script.matches("\ncrash\n").count(), 2);
        assert_eq!(script.matches("wait-output pwm on").count(), 40);
    }
}
