//! Prints the figures on the screen.

use std::fmt::Write;

use super::accuracy::MoveErrors;
use super::beside::beside;
use super::board::{Moving, WITH_SECOND};
use super::chip::Chip;
use super::figures::{ChipFigures, Conditions, Figures, MachineFigures, PortFigures, together};
use super::micro::{GeneratorFigures, MicroFigures, RampFigures};
use super::outputs::OffFigures;
use super::starts::Delay;
use super::stops::{Latency, StopMeasurement};
use super::target::Target;
use super::{floats, flow, laws, levels};
use isostep::screen::grouped;

/// Explains the figures of the ideal chip.
pub const BESIDE: &str =
    "Beneath a figure, where it is another: that of a chip whose flash reads like RAM (ideal flash).";

/// Rows with a name and words.
type Rows = Vec<Vec<String>>;

/// The whole table, with the conditions first.
pub fn table(figures: &Figures) -> String {
    let Figures { conditions, chip, ideal_flash: ideal, .. } = figures;
    let mut text = format!("\n{} Command: {}\n", self::conditions(conditions), conditions.command);
    text += &format!("{BESIDE}\n");
    for port in &chip.ports {
        text += &format!("\n{}\n", port.port.name());
        let ideal = ideal.port(port.port);
        let mut add = |heading: &str, rows: &dyn Fn(&PortFigures) -> Rows| {
            text += &section(heading, rows(port), ideal.map_or(Rows::new(), rows));
        };
        for (heading, rows) in OF_MACHINES {
            add(heading, &|port| rows(&port.machine));
        }
        add(STARTS, &starts);
        add(LEVELS, &levels);
        for (heading, rows) in OF_MACHINES {
            let heading = format!("{heading}{WITH_SECOND}");
            add(&heading, &|port| port.with_second.as_ref().map_or(Rows::new(), rows));
        }
    }
    text += &chip.mathematics.as_ref().map_or(String::new(), |one| mathematics(one, ideal.mathematics.as_ref()));
    text + &targets(figures) + "\nPlanning and compiling on this computer: cargo bench -p isostep-profile\n"
}

/// The rows of a machine in one section.
type Part = fn(&MachineFigures) -> Rows;

/// The sections of each machine.
const OF_MACHINES: [(&str, Part); 5] =
    [(RATES, rates), (ACCURACY, accuracy), (LOAD, load), (STOPS, stops), (MOVES, moves)];

const RATES: &str = "highest rate sustained, steps/s of each axis";
const ACCURACY: &str = "edges against the closed form";
const LOAD: &str = "load of the core";
const STOPS: &str = "from an input to the last edge";
const STARTS: &str = "from the arrival of a line to the first edge, less the plan's own time to its first step";
const MOVES: &str = "short moves carried, of a sender that counts characters";

const LEVELS: &str = "levels of a laser, in lines of pixels of 0.1 mm";

/// A heading and its rows, with the ideal chip's rows below those that differ.
fn section(heading: &str, rows: Rows, ideal: Rows) -> String {
    let mut text = format!("  {heading}\n");
    for row in beside(rows, ideal, 1) {
        line(&mut text, &row[0], &row[1]);
    }
    text
}

/// The conditions of all figures in a sentence.
pub fn conditions(conditions: &Conditions) -> String {
    format!(
        "All figures: {}, {} MHz, flash {} ({} cycles for a word that it does not hold), {}; driver {}, status polled \
         over USB at {} Hz; from rest in {} s, at most {} steps/s2.",
        conditions.board,
        conditions.clock_hz / 1_000_000,
        conditions.flash,
        conditions.miss_cycles,
        conditions.build,
        conditions.driver.to_uppercase(),
        conditions.poll_hz,
        conditions.ramp_s,
        grouped(conditions.accel_max_steps_s2 as u64),
    )
}

fn rates(port: &MachineFigures) -> Rows {
    let rows = port.rates.iter().map(|rates| {
        let highest = rates.highest_steps_s.map_or("none".to_owned(), |rate| grouped(rate.into()));
        let errors = rates.errors.map_or(String::new(), |errors| format!("edges within {:.0} ns", errors.max_ns));
        let mut words = format!("{highest:>11}  {errors}");
        if let (Some(next), Some(why)) = (rates.next_steps_s, &rates.why_not) {
            words += &format!("\n{:>11}  {why}", format!("not {}", grouped(next.into())));
        }
        row(axes_words(rates.axes), words)
    });
    rows.collect()
}

/// `1 axis`, `3 axes`.
pub fn axes_words(axes: usize) -> String {
    format!("{axes} {}", if axes == 1 { "axis" } else { "axes" })
}

fn accuracy(port: &MachineFigures) -> Rows {
    let rate = row("rate", together(port.accuracy.rate_steps_s));
    let rows = match port.accuracy.edges.result() {
        Err(why_not) => vec![row("not carried", why_not)],
        Ok(MoveErrors { move_s, errors, drift, .. }) => {
            let ends = grouped(drift.end_edges);
            let spread = [errors.median_ns, errors.p99_ns, errors.max_ns].map(|ns| format!("{ns:.0}")).join(", ");
            let drift_words = format!(
                "{:+.2} ns/s; last {ends} edges less the first {ends}: {:+.1} ns",
                drift.slope_ns_s, drift.last_less_first_ns
            );
            vec![
                row("edges", format!("{} in {move_s:.1} s", grouped(errors.edges))),
                row("median, p99, max", format!("{spread} ns")),
                row("earliest, latest", format!("{:+.0}, {:+.0} ns", errors.earliest_ns, errors.latest_ns)),
                row("drift", drift_words),
            ]
        }
    };
    [rate].into_iter().chain(rows).collect()
}

fn load(port: &MachineFigures) -> Rows {
    let rows = port.load.iter().flat_map(|load| {
        let rate = together(load.rate_steps_s);
        [
            row(format!("{rate}, cruising"), load.cruising.words(Moving::words)),
            row(format!("{rate}, ramps"), load.ramping.words(Moving::words)),
        ]
    });
    rows.collect()
}

fn stops(port: &MachineFigures) -> Rows {
    let row = |stop: &StopMeasurement| {
        let name = format!("{}, {}", stop.input.name(), together(stop.rate_steps_s));
        row(name, stop.latency.words(Latency::words))
    };
    port.stops.iter().map(row).collect()
}

fn starts(port: &PortFigures) -> Rows {
    port.starts.iter().map(|start| row(start.cache.name(), start.delay.words(Delay::words))).collect()
}

fn moves(port: &MachineFigures) -> Rows {
    port.moves.rows().map(|[name, carried]| row(name, carried)).into()
}

fn levels(port: &PortFigures) -> Rows {
    let levels = &port.levels;
    vec![
        row("from their steps, at 1,000 moves/s", levels.distances.words(levels::words)),
        row("carried, constant (M3)", levels.carried_constant.words(levels::rate_words)),
        row("carried, by speed (M4)", levels.carried_by_speed.words(levels::rate_words)),
        row("from a stop to dark, coolant off", port.outputs.words(OffFigures::words)),
    ]
}

fn row(name: impl Into<String>, words: impl Into<String>) -> Vec<String> {
    vec![name.into(), words.into()]
}

fn mathematics(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> String {
    let costs = |figures: &MicroFigures| costs(figures).into_iter().map(|(name, words)| row(name, words)).collect();
    let mut text = section("cost on the chip", costs(figures), ideal.map_or(Rows::new(), costs));
    text.insert_str(0, "\nmathematics of a move\n");
    text += &laws(figures, ideal);
    text += &flow(figures, ideal);
    writeln!(text, "  step generators over {}", ramp_words(&figures.ramp)).expect("a String takes any text");
    line(&mut text, "", &cells(22, &GENERATOR_HEAD.map(str::to_owned)));
    let generators = |figures: &MicroFigures| {
        let row = |one: &GeneratorFigures| row(one.name, cells(22, &generator_cells(one)));
        figures.generators.iter().map(row).collect()
    };
    for row in beside(generators(figures), ideal.map_or(Rows::new(), generators), 1) {
        line(&mut text, &row[0], &row[1]);
    }
    text
}

/// One line per law.
fn laws(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> String {
    let rows = |figures: &MicroFigures| figures.laws.iter().map(|one| row(one.law, cells(17, &one.cells()))).collect();
    let mut text =
        String::from("  speed laws, of three axes: plan, begin (the first segment of each axis), then a ramp\n");
    text += &format!("    {:<12}{}\n", "", cells(17, &laws::HEAD.map(str::to_owned)));
    for row in beside(rows(figures), ideal.map_or(Rows::new(), rows), 1) {
        text += &format!("    {:<12}{}\n", row[0], row[1]);
    }
    text
}

/// One line per case.
fn flow(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> String {
    let rows = |figures: &MicroFigures| figures.flow.iter().map(|one| row(one.case, cells(17, &one.cells()))).collect();
    let mut text =
        String::from("  a move of 0.2 mm of three axes that flows, cycles; moves/s if the core did nothing else\n");
    text += &format!("    {:<17}{}\n", "", cells(17, &flow::HEAD.map(str::to_owned)));
    for row in beside(rows(figures), ideal.map_or(Rows::new(), rows), 1) {
        text += &format!("    {:<17}{}\n", row[0], row[1]);
    }
    text
}

/// The cells side by side, each `width` wide.
fn cells(width: usize, cells: &[String]) -> String {
    cells.iter().map(|cell| format!("{cell:>width$}")).collect()
}

/// The cost of a segment and of a step.
pub fn costs(figures: &MicroFigures) -> Vec<(String, String)> {
    let compile = figures.compile.iter().map(|phase| {
        let [mean, max] = [phase.cycles_mean.round() as u64, phase.cycles_max].map(grouped);
        (format!("compile a segment, {}", phase.phase), format!("{mean} cycles, {max} at most, of {}", phase.segments))
    });
    let lead = figures.queue_lead_ticks_per_cycle;
    let after = [
        ("compiling against moving".to_owned(), format!("{lead:.1} times as fast for 3 axes, where it is closest")),
        ("replay a step".to_owned(), format!("{:.1} cycles", figures.fill_cycles_per_step)),
        ("operations on f64, cycles".to_owned(), floats::words(&figures.floats)),
    ];
    compile.chain(after).collect()
}

/// The columns of [`generator_cells`].
pub const GENERATOR_HEAD: [&str; 5] =
    ["cycles a step", "slowest step", "worst speed error", "above a tenth of top", "last step late"];

/// The cost and the accuracy of a generator.
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

/// The ramp on which the generators are compared.
pub fn ramp_words(ramp: &RampFigures) -> String {
    let [steps, top, accel] =
        [ramp.steps.into(), ramp.top_speed_steps_s as u64, ramp.accel_steps_s2 as u64].map(grouped);
    format!("{steps} steps, to {top} steps/s at {accel} steps/s2")
}

/// One line per target: whether the chip meets it, its name and bound, and what was measured on each chip.
fn targets(figures: &Figures) -> String {
    let heads = [Chip::AsItIs, Chip::IdealFlash, Chip::CostlyMiss].map(|chip| format!("{:>20}", chip.name())).concat();
    let mut text = format!("\n{:<88}{heads}\n", "targets");
    for target in &figures.chip.targets {
        let mark = if target.met { "met    " } else { "NOT MET" };
        let measured = measured_cells(target, figures).map(|cell| format!("{cell:>20}")).concat();
        writeln!(text, "  {mark} {:<50} {:<27}{measured}", target.what, target.aim()).expect("a String takes any text");
    }
    text
}

/// What was measured on the real chip, on the ideal one, and on the one with costly misses.
pub fn measured_cells(target: &Target, figures: &Figures) -> [String; 3] {
    let cell = |target: &Target| {
        let measured = target.measured.map_or("no figure".to_owned(), number);
        if target.met { measured } else { format!("{measured} NOT MET") }
    };
    let on = |chip: &ChipFigures| chip.target(&target.what).map_or("-".to_owned(), cell);
    [target.measured.map_or("no figure".to_owned(), number), on(&figures.ideal_flash), on(&figures.miss_costs_twice)]
}

impl Target {
    /// The target in words.
    pub fn aim(&self) -> String {
        let bound = if self.at_least { "at least" } else { "at most" };
        format!("{bound} {} {}", number(self.target), self.unit)
    }
}

/// A number with commas between thousands. A number below 100 has up to two decimals.
pub fn number(value: f64) -> String {
    if value.abs() >= 100.0 { grouped(value.round() as u64) } else { format!("{}", (value * 100.0).round() / 100.0) }
}

/// A name, and words that may have several lines.
fn line(text: &mut String, name: &str, words: &str) {
    for (index, words) in words.lines().enumerate() {
        writeln!(text, "    {:<41} {words}", if index == 0 { name } else { "" }).expect("a String takes any text");
    }
}

#[cfg(test)]
mod tests {
    use super::super::figures::ChipFigures;
    use super::*;

    fn on(measured: [Option<f64>; 3]) -> ChipFigures {
        let [rate, error, stop] = measured;
        let targets = vec![
            Target::at_least("rate".to_owned(), rate, 1e6, "steps/s"),
            Target::at_most("error".to_owned(), error, 50.0, "ns"),
            Target::at_most("stop".to_owned(), stop, 10.0, "us"),
        ];
        ChipFigures { ports: Vec::new(), mathematics: None, targets }
    }

    #[test]
    fn targets_say_whether_they_are_met_and_by_which_chip() {
        let mut costly = on([Some(900_000.0), None, Some(9.0)]);
        costly.targets.pop();
        let figures = Figures {
            conditions: Conditions::default(),
            chip: on([Some(1_200_000.0), Some(52.126), None]),
            ideal_flash: on([Some(1_300_000.0), Some(40.0), Some(2.0)]),
            miss_costs_twice: costly,
        };
        let text = targets(&figures);
        let words: Vec<String> =
            text.lines().skip(2).map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        assert_eq!(words[0], "met rate at least 1,000,000 steps/s 1,200,000 1,300,000 900,000 NOT MET");
        assert_eq!(words[1], "NOT MET error at most 50 ns 52.13 40 no figure NOT MET");
        assert_eq!(words[2], "NOT MET stop at most 10 us no figure 2 -");
    }
}
