//! The figures on the screen.

use std::fmt::Write;

use super::accuracy::MoveErrors;
use super::board::Moving;
use super::figures::{Conditions, Figures, PortFigures, Target, together};
use super::progress::grouped;
use super::stops::Latency;

/// Everything, conditions first.
pub fn table(figures: &Figures) -> String {
    let mut text = format!("\n{}\n", conditions(&figures.conditions));
    for port in &figures.ports {
        text += &format!("\n{}\n", port.port.name());
        for part in [rates(port), accuracy(port), load(port), stops(port)] {
            text += &part;
        }
    }
    text + &targets(&figures.targets) + "\nPlanning and compiling on this computer: cargo bench -p isostep-profile\n"
}

/// What every figure depends on, in a sentence.
pub fn conditions(conditions: &Conditions) -> String {
    format!(
        "All figures: {}, {} MHz, {}; driver {}, status polled over USB at {} Hz; from rest in {} s, at most {} \
         steps/s2. Command: {}",
        conditions.board,
        conditions.clock_hz / 1_000_000,
        conditions.build,
        conditions.driver.to_uppercase(),
        conditions.poll_hz,
        conditions.ramp_s,
        grouped(conditions.accel_max_steps_s2 as u64),
        conditions.command,
    )
}

fn rates(port: &PortFigures) -> String {
    let mut text = String::from("  highest rate sustained, steps/s of each axis\n");
    for rates in &port.rates {
        let highest = rates.highest_steps_s.map_or("none".to_owned(), |rate| grouped(rate.into()));
        let errors = rates.errors.map_or(String::new(), |errors| format!("edges within {:.0} ns", errors.max_ns));
        line(&mut text, &format!("{} axes", rates.axes), &format!("{highest:>11}  {errors}"));
        if let (Some(next), Some(why)) = (rates.next_steps_s, &rates.why_not) {
            line(&mut text, "", &format!("{:>11}  {why}", format!("not {}", grouped(next.into()))));
        }
    }
    text
}

fn accuracy(port: &PortFigures) -> String {
    let mut text = format!("  edges against the closed form, {}\n", together(port.accuracy.rate_steps_s));
    match port.accuracy.edges.result() {
        Err(why_not) => line(&mut text, "not carried", why_not),
        Ok(MoveErrors { move_s, errors, drift, .. }) => {
            let ends = grouped(drift.end_edges);
            let difference_ns = drift.last_less_first_ns;
            line(&mut text, "edges", &format!("{} in {move_s:.1} s", grouped(errors.edges)));
            let spread = [errors.median_ns, errors.p99_ns, errors.max_ns].map(|ns| format!("{ns:.0}")).join(", ");
            line(&mut text, "median, p99, max", &format!("{spread} ns"));
            line(&mut text, "earliest, latest", &format!("{:+.0}, {:+.0} ns", errors.earliest_ns, errors.latest_ns));
            line(&mut text, "drift", &format!("{:+.2} ns/s", drift.slope_ns_s));
            line(&mut text, "", &format!("last {ends} edges less the first {ends}: {difference_ns:+.1} ns"));
        }
    }
    text
}

fn load(port: &PortFigures) -> String {
    let mut text = String::from("  load of the core\n");
    for load in &port.load {
        line(&mut text, &format!("{}, cruising", together(load.rate_steps_s)), &load.cruising.words(Moving::words));
        line(&mut text, "in ramps", &load.ramping.words(Moving::words));
    }
    text
}

fn stops(port: &PortFigures) -> String {
    let mut text = String::from("  from an input to the last edge\n");
    for stop in &port.stops {
        let words = stop.latency.words(|latency| {
            let Latency { max_us, mean_us, stops } = latency;
            format!("max {max_us:.2} us, mean {mean_us:.2} us, {stops} stops at {}", together(stop.rate_steps_s))
        });
        line(&mut text, stop.input.name(), &words);
    }
    text
}

fn targets(targets: &[Target]) -> String {
    let mut text = String::from("\ntargets\n");
    for target in targets {
        let mark = if target.met { "met    " } else { "NOT MET" };
        let measured = target.measured.map_or("no figure".to_owned(), number);
        let bound = if target.at_least { "at least" } else { "at most" };
        let aim = format!("{bound} {} {}", number(target.target), target.unit);
        writeln!(text, "  {mark} {:<46} {measured:>12}   {aim}", target.what).expect("a String takes any text");
    }
    text
}

/// With thousands apart, and a decimal or two where it is small.
pub fn number(value: f64) -> String {
    if value.abs() >= 100.0 { grouped(value.round() as u64) } else { format!("{}", (value * 100.0).round() / 100.0) }
}

fn line(text: &mut String, name: &str, figures: &str) {
    writeln!(text, "    {name:<30} {figures}").expect("a String takes any text");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_say_whether_they_are_met() {
        let text = targets(&[
            Target::at_least("rate".to_owned(), Some(1_200_000.0), 1e6, "steps/s"),
            Target::at_most("error".to_owned(), Some(52.126), 50.0, "ns"),
            Target::at_most("stop".to_owned(), None, 10.0, "us"),
        ]);
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert!(lines[0].starts_with("  met     rate") && lines[0].contains("1,200,000   at least 1,000,000 steps/s"));
        assert!(lines[1].starts_with("  NOT MET error") && lines[1].contains("52.13   at most 50 ns"));
        assert!(lines[2].starts_with("  NOT MET stop") && lines[2].contains("no figure"));
    }
}
