//! The figures on the screen.

use std::fmt::Write;

use super::accuracy::MoveErrors;
use super::board::Moving;
use super::figures::{Conditions, Figures, PortFigures, Target, together};
use super::laws;
use super::micro::{GeneratorFigures, MicroFigures, RampFigures};
use super::progress::grouped;
use super::stops::Latency;

/// Everything, conditions first.
pub fn table(figures: &Figures) -> String {
    let mut text = format!("\n{} Command: {}\n", conditions(&figures.conditions), figures.conditions.command);
    for port in &figures.ports {
        text += &format!("\n{}\n", port.port.name());
        for part in [rates(port), accuracy(port), load(port), stops(port)] {
            text += &part;
        }
    }
    text += &figures.mathematics.as_ref().map_or(String::new(), mathematics);
    text + &targets(&figures.targets) + "\nPlanning and compiling on this computer: cargo bench -p isostep-profile\n"
}

/// What every figure depends on, in a sentence.
pub fn conditions(conditions: &Conditions) -> String {
    format!(
        "All figures: {}, {} MHz, {}; driver {}, status polled over USB at {} Hz; from rest in {} s, at most {} \
         steps/s2.",
        conditions.board,
        conditions.clock_hz / 1_000_000,
        conditions.build,
        conditions.driver.to_uppercase(),
        conditions.poll_hz,
        conditions.ramp_s,
        grouped(conditions.accel_max_steps_s2 as u64),
    )
}

fn rates(port: &PortFigures) -> String {
    let mut text = String::from("  highest rate sustained, steps/s of each axis\n");
    for rates in &port.rates {
        let highest = rates.highest_steps_s.map_or("none".to_owned(), |rate| grouped(rate.into()));
        let errors = rates.errors.map_or(String::new(), |errors| format!("edges within {:.0} ns", errors.max_ns));
        line(&mut text, &axes_words(rates.axes), &format!("{highest:>11}  {errors}"));
        if let (Some(next), Some(why)) = (rates.next_steps_s, &rates.why_not) {
            line(&mut text, "", &format!("{:>11}  {why}", format!("not {}", grouped(next.into()))));
        }
    }
    text
}

/// `1 axis`, `3 axes`.
pub fn axes_words(axes: usize) -> String {
    format!("{axes} {}", if axes == 1 { "axis" } else { "axes" })
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
        let name = format!("{}, {}", stop.input.name(), together(stop.rate_steps_s));
        line(&mut text, &name, &stop.latency.words(Latency::words));
    }
    text
}

fn mathematics(figures: &MicroFigures) -> String {
    let mut text = String::from("\nmathematics of a move, on the chip\n");
    for (name, words) in costs(figures) {
        line(&mut text, &name, &words);
    }
    text += &laws(figures);
    writeln!(text, "  step generators over {}", ramp_words(&figures.ramp)).expect("a String takes any text");
    writeln!(text, "    {:<38} {}", "", GENERATOR_HEAD.map(|name| format!("{name:>22}")).concat())
        .expect("a String takes any text");
    for generator in &figures.generators {
        line(&mut text, generator.name, &generator_cells(generator).map(|cell| format!("{cell:>22}")).concat());
    }
    text
}

/// A law a line.
fn laws(figures: &MicroFigures) -> String {
    let row = |name: &str, cells: [String; 9]| {
        format!("    {name:<12}{}\n", cells.map(|cell| format!("{cell:>17}")).concat())
    };
    let head = row("", laws::HEAD.map(str::to_owned));
    let rows = figures.laws.iter().map(|one| row(one.law, one.cells()));
    format!(
        "  speed laws, of three axes: plan, begin (the first segment of each axis), then a ramp\n{head}{}",
        rows.collect::<String>()
    )
}

/// What a segment and a step cost.
pub fn costs(figures: &MicroFigures) -> Vec<(String, String)> {
    let compile = figures.compile.iter().map(|phase| {
        let [mean, max] = [phase.cycles_mean.round() as u64, phase.cycles_max].map(grouped);
        (format!("compile a segment, {}", phase.phase), format!("{mean} cycles, {max} at most, of {}", phase.segments))
    });
    let lead = figures.queue_lead_ticks_per_cycle;
    let after = [
        ("compiling against moving".to_owned(), format!("{lead:.1} times as fast for 3 axes, where it is closest")),
        ("replay a step".to_owned(), format!("{:.1} cycles", figures.fill_cycles_per_step)),
    ];
    compile.chain(after).collect()
}

/// The columns of [`generator_cells`].
pub const GENERATOR_HEAD: [&str; 5] =
    ["cycles a step", "slowest step", "worst speed error", "above a tenth of top", "last step late"];

/// A generator's cost and truth.
pub fn generator_cells(generator: &GeneratorFigures) -> [String; 5] {
    let truth = generator.truth;
    [
        format!("{:.1}", generator.cycles_mean),
        generator.cycles_max.map_or("ahead".to_owned(), grouped),
        format!("{:.3} %", truth.speed_error_max_percent),
        format!("{:.4} %", truth.speed_error_max_above_tenth_percent),
        format!("{:+.3} us", truth.drift_s * 1e6),
    ]
}

/// The ramp that the generators are compared over.
pub fn ramp_words(ramp: &RampFigures) -> String {
    let [steps, top, accel] =
        [ramp.steps.into(), ramp.top_speed_steps_s as u64, ramp.accel_steps_s2 as u64].map(grouped);
    format!("{steps} steps, to {top} steps/s at {accel} steps/s2")
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
    writeln!(text, "    {name:<38} {figures}").expect("a String takes any text");
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
