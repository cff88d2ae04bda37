//! Prints the figures of a run for people.

use isostep_report::kinematics::{AxisFigures, JumpFigures, OfLimit};
use isostep_report::pace::Pace;
use isostep_report::ringing::{Deviation, RingingFigures};
use isostep_report::tool::{BeamFigures, ToolFigures};
use isostep_report::{Figures, MoveFigures};

use isostep_report::pace::words as pace;
use isostep_report::remarks::{AXIS_NAMES, SHOWN_MAX, words};

/// At most this many moves are listed one by one, unless all are requested.
const ROWS_MAX: usize = 40;

/// Prints the figures. With `all_moves` every move is listed, regardless of their number.
pub fn print(figures: &Figures, all_moves: bool) {
    if figures.homing_ns > 0 {
        println!("\nhoming: {:.3} s", seconds(figures.homing_ns));
    }
    if figures.moves_total > 0 {
        if all_moves || figures.moves_total <= ROWS_MAX {
            print_moves(&figures.moves);
        } else {
            print_summary(figures);
        }
        print_axes(&figures.axes);
        figures.belts.iter().for_each(|belts| println!("  {belts}"));
        if let Some(shaping) = &figures.shaping {
            println!("\nshaping\n  {shaping}");
        }
        print!("{}", ringing_words(&figures.ringing, &figures.ringing_unshaped));
        print_pace(&figures.pace);
    }
    if let Some(tool) = &figures.tool {
        print!("{}", tool_words(tool));
    }
    print_losses(figures);
    print_checks(figures);
    let place = words(figures.position_mm.map(|mm| format!(" {mm:.2}")));
    let steps = figures.position_steps.map(|n| n.to_string()).join(", ");
    println!("\nfinal position: {place} mm ({steps} steps)");
    println!("{} steps in {:.3} s of machine time", figures.steps_total, seconds(figures.duration_ns));
}

/// Prints where steps were lost, and what to set.
fn print_losses(figures: &Figures) {
    if figures.losses_total > 0 {
        println!("\nsteps lost");
        figures.losses.iter().take(SHOWN_MAX).for_each(|loss| println!("  {loss}"));
    }
    if figures.losses_total > SHOWN_MAX {
        println!("  and {} times more", figures.losses_total - SHOWN_MAX);
    }
}

/// Prints each promise and whether it was kept.
pub fn print_checks(figures: &Figures) {
    println!("\nchecks");
    for verdict in &figures.verdicts {
        let mark = if verdict.kept { "ok    " } else { "BROKEN" };
        println!("  {mark} {:<36} {}", verdict.promise, verdict.detail);
    }
}

/// For a program with many moves: prints how many there are, their lengths, and the two to look at first.
fn print_summary(figures: &Figures) {
    let lengths = &figures.lengths;
    println!("\nmoves");
    println!(
        "  {} moves of {:.3} to {:.3} mm (median {:.3}), {:.3} mm in all; --moves lists them",
        figures.moves_total, lengths.least_mm, lengths.most_mm, lengths.median_mm, lengths.total_mm
    );
    let longest = figures.moves.iter().max_by(|one, other| one.duration_s().total_cmp(&other.duration_s()));
    if let Some(one) = longest {
        println!("  the longest lasts {:.3} s: move {}{}", one.duration_s(), one.number, line_words(one.line));
    }
    let judged = figures.moves.iter().filter(|one| one.exact.is_some());
    let worst = judged.max_by(|one, other| one.error_max_ns().total_cmp(&other.error_max_ns()));
    if let Some(one) = worst {
        let ns = one.error_max_ns();
        println!("  the largest error of a step is {ns:.0} ns: move {}{}", one.number, line_words(one.line));
    }
}

/// The intervals are those of every moving axis, because one profile drives them all. The column `apart` is the largest
/// difference when they are measured from each axis's own edges.
fn print_moves(moves: &[MoveFigures]) {
    println!("\nmoves                                               every axis, s");
    let place = format!("to {}, mm", AXIS_NAMES.join(" "));
    println!(
        "   # {:>22} {:>21} {:>8} {:>10} {:>8} {:>10} {:>7} {:>7}",
        place, "steps", "blend", "accelerate", "cruise", "decelerate", "apart", "error"
    );
    for one in moves {
        let steps = one.steps.map(|n| n.to_string()).join(" ");
        let apart = one.apart_s.map_or("-".to_owned(), |apart_s| format!("{:.0} ns", apart_s * 1e9));
        let error = one.exact.map_or("-".to_owned(), |_| format!("{:.0} ns", one.error_max_ns()));
        let blend = if one.blend_s > 0.0 { format!("{:.6}", one.blend_s) } else { "-".to_owned() };
        println!(
            "{:>4} {:>22} {steps:>21} {blend:>8} {:>10.6} {:>8.6} {:>10.6} {apart:>7} {error:>7}",
            one.number,
            one.to_mm.map(|mm| format!("{mm:.2}")).join(" "),
            one.planned.accel_s,
            one.planned.cruise_s,
            one.planned.decel_s,
        );
    }
    println!("  blend: round the corner where the move begins; steps: those of that blend and of the line behind it");
    println!(
        "  apart: the most that two axes' intervals differ, measured from each axis's own edges (-: fewer than two to measure)"
    );
    println!(
        "  error: the most that a step is off its closed-form instant (-: in a shaped run, which is checked as a whole)"
    );
}

/// Prints the limits that each axis kept within moves, and the jumps of its speed at corners.
fn print_axes(axes: &[AxisFigures]) {
    println!("\naxes                      within moves, from the edges alone                        at corners");
    println!(
        "{:>20} {:>23} {:>23} {:>27} {:>8}  where",
        "speed, mm/s", "accelerates, mm/s2", "decelerates, mm/s2", "jumps, mm/s (mm/min)", "at most"
    );
    for one in axes {
        let [speed, accel, decel] = [(one.speed_mm_s, 2), (one.accel_mm_s2, 1), (one.decel_mm_s2, 1)]
            .map(|(OfLimit { found, limit }, digits)| format!("{found:.digits$} of {limit:.digits$}"));
        let (jump, place) = one.jump.map_or(("-".to_owned(), String::new()), |jump| {
            (format!("{:.2} ({:.0})", jump.mm_s, jump.mm_min), place_words(&jump))
        });
        let most = format!("{:.2}", one.jump_limit_mm_s);
        println!("   {} {speed:>15} {accel:>23} {decel:>23} {jump:>27} {most:>8}  {place}", one.axis);
    }
    println!(
        "  at most: sqrt(8 x acceleration x $11), or twice the start speed; within moves a figure is up to 1 % high"
    );
}

/// The swinging of loads on springs, in words, and below how without shapers.
fn ringing_words(axes: &[RingingFigures], unshaped: &[RingingFigures]) -> String {
    if axes.is_empty() {
        return String::new();
    }
    let deviation = |found: Option<Deviation>| {
        found.map_or("-".to_owned(), |found| {
            format!("{:.4}, move {}{}", found.mm, found.move_number, line_words(found.line))
        })
    };
    let mut text = format!(
        "\nringing, mm\n   {:<16} {:<32} {:<32} {}\n",
        "load", "after stops, amplitude", "after corners, deviation", "anywhere"
    );
    let mut add = |load: &str, one: &RingingFigures| {
        let (stops, corners) = (deviation(one.after_stops), deviation(one.after_corners));
        text += &format!("   {load:<16} {stops:<32} {corners:<32} {:.4}\n", one.anywhere_mm);
    };
    for (index, one) in axes.iter().enumerate() {
        add(&format!("{} {} Hz, {}", one.axis, one.natural_hz, one.damping_ratio), one);
        unshaped.get(index).into_iter().for_each(|one| add("  unshaped", one));
    }
    text + "  after a corner: within one period of the load; a deviation is from where the axis is, and good to half a step\n"
}

/// Prints what keeps the program from going faster.
fn print_pace(pace: &Pace) {
    println!("\nwhere the time goes");
    println!("  {:.3} s from the first move to the last: limited by {}", pace.total_s(), pace::limited_by(pace));
    if let Some(words) = pace::beyond_board(pace) {
        println!("  on the board: {words}");
    }
    if let Some(lost) = pace::lost(pace) {
        println!("  lost: {lost}");
    }
    pace::worst(pace).for_each(|place| println!("    {place}"));
    let seconds = [("slowest", &pace.slowest_second), ("busiest", &pace.busiest_second)];
    for (which, second) in seconds.iter().filter_map(|(which, second)| Some((which, second.as_ref()?))) {
        println!("  the {which} second: {}", pace::second(second));
    }
}

/// The tool's work, in words.
fn tool_words(tool: &ToolFigures) -> String {
    let mut text = "\ntool\n".to_owned();
    if let Some(duty) = tool.duty {
        let [least, most, mean] = [duty.least, duty.most, duty.mean].map(|ratio| ratio * 100.0);
        let name = if tool.laser { "laser shone" } else { "spindle on" };
        let times = format!("{} changes", tool.duty_changes);
        text +=
            &format!("  {name} for {:.3} s, PWM at {least:.1} to {most:.1} % (mean {mean:.1} %), {times}\n", tool.on_s);
    }
    text += &tool.beam.as_ref().map_or(String::new(), beam_words);
    if tool.flood_s + tool.mist_s > 0.0 {
        text += &format!("  coolant: flood for {:.3} s, mist for {:.3} s\n", tool.flood_s, tool.mist_s);
    }
    text
}

fn beam_words(beam: &BeamFigures) -> String {
    let mut text = format!(
        "  its beam made {:.3} mm of path in {:.3} s, and stood for {:.6} s\n",
        beam.path_mm, beam.path_s, beam.still_s
    );
    if let Some(found) = beam.beginnings {
        text += &format!(
            "  moves of constant power that begin with another level: {}; it changes within {:.2} us of there, 99 % within {:.2} us\n",
            found.total, found.most_us, found.p99_us
        );
    }
    text
}

fn place_words(jump: &JumpFigures) -> String {
    format!("to move {}{}", jump.move_number, line_words(jump.line))
}

fn line_words(line: Option<usize>) -> String {
    line.map_or(String::new(), |line| format!(", line {line}"))
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(program: &str) -> String {
        let outcome = isostep_sim::run(program.as_bytes(), &isostep_sim::Config::default()).unwrap();
        Figures::new("test", &outcome).tool.as_ref().map_or(String::new(), tool_words)
    }

    #[test]
    fn ringing_is_reported_for_axes_with_a_load_and_only_then() {
        let reported = |springs: &str| {
            let springs = springs.parse().unwrap_or_default();
            let config = isostep_sim::Config { springs, ..isostep_sim::Config::default() };
            let outcome = isostep_sim::run(b"G91 G1 F1200 X5\nY5\n", &config).unwrap();
            let ringing = Figures::new("test", &outcome).ringing;
            [ringing_words(&ringing, &[]), ringing_words(&ringing, &ringing)]
        };
        assert_eq!(reported(""), ["", ""]);
        let [words, beside] = reported("X:8:0.05");
        assert_eq!(beside.matches("\n     unshaped ").count(), 1, "{beside}");
        assert!(!words.contains("unshaped"), "{words}");
        assert!(
            words.contains("\n   X 8 Hz, 0.05 ") && words.contains(", move 2, line 2") && !words.contains("Y 8"),
            "{words}"
        );
    }

    #[test]
    fn what_the_tool_did_is_reported_if_it_was_used() {
        assert_eq!(words("G0 X1\n"), "");
        assert_eq!(words("M8\nG4 P0.5\nM9\n"), "\ntool\n  coolant: flood for 0.500 s, mist for 0.000 s\n");
        let laser = words("$32=1\nG91 G1 F600 M3 S500\nX6\nG4 P0.1\nM5\n");
        assert!(laser.contains("PWM at 50.0 to 50.0 % (mean 50.0 %), 2 changes"), "{laser}");
        assert!(laser.contains("its beam made 6.000 mm of path in "), "{laser}");
        assert!(laser.contains("begin with another level: 1; it changes within 0."), "{laser}");
        assert!(words("M3 S500\nG4 P1\nM5\n").contains("spindle on for "));
    }
}
