//! Prints the results of a check for people.

use isostep_report::pace::LEAST_SHOWN_S;
use isostep_report::survey::{LISTED_MAX, Survey};
use isostep_sim::AXES;

use super::look::{Checked, Machine, On};
use crate::pace;
use crate::remarks::{self, AXIS_NAMES, SHOWN_MAX, shortened};

/// The details of one program on each machine.
pub fn detail(checked: &Checked, all: bool) -> String {
    if let Some(why) = &checked.unreadable {
        return format!("{}: {why}\n", checked.program);
    }
    let mut text = String::new();
    for (index, on) in checked.on.iter().enumerate() {
        text += &format!("{}{} on {}\n", if index > 0 { "\n" } else { "" }, checked.program, on.machine);
        // One machine may refuse `$` lines that another accepts.
        let is_as_on_first = checked.on[0].survey.refused == on.survey.refused;
        if index == 0 || !is_as_on_first {
            text += &fate(&on.survey, all);
        }
        text += &places(on);
        text += &times(on);
    }
    text
}

fn row(name: &str, words: &str) -> String {
    format!("  {name:<11}{words}\n")
}

/// What happens to the program's lines.
fn fate(survey: &Survey, all: bool) -> String {
    let Survey { lines, blocks, statements, empty, moves, arcs, refused_total, .. } = *survey;
    let mut text = row(
        "lines",
        &format!(
            "{lines}: {blocks} of G-code ({moves} that move, {arcs} of them arcs), {statements} of $, {empty} empty, % or comments"
        ),
    );
    text += &row("refused", &if refused_total == 0 { "none".to_owned() } else { refused_total.to_string() });
    let reported = if all { LISTED_MAX } else { SHOWN_MAX };
    for refused in survey.refused.iter().take(reported) {
        let (line, code, remedy) = (refused.line, refused.code, &refused.remedy);
        text += &format!("    line {line} `{}`: error:{code} {remedy}\n", shortened(&refused.text));
    }
    if refused_total > reported {
        let how = if all { "" } else { "; --all tells up to 1,000" };
        text += &format!(
            "    and {} more, in all {}{how}\n",
            refused_total - reported,
            remarks::by_word(&survey.refused_by_word)
        );
    }
    text += &persons(survey);
    if let Some((least, most)) = survey.feeds_mm_min {
        let range = if least == most { format!("{least:.0}") } else { format!("{least:.0} to {most:.0}") };
        text += &row("feeds", &format!("{range} mm/min"));
    }
    let left_on = if survey.leaves_tool_on { ", and leaves the spindle on (M3, M4)" } else { "" };
    text + &match survey.ends_at {
        Some(line) => row("ends", &format!("by M2 or M30, line {line}{left_on}")),
        None => row("ends", &format!("without M2 or M30: its modes stay in force{left_on}")),
    }
}

/// Where a person has to act.
fn persons(survey: &Survey) -> String {
    let tool = |(tool, line): (&u8, &usize)| match tool {
        0 => format!("any (line {line})"),
        tool => format!("T{tool} (line {line})"),
    };
    let tools: Vec<_> = survey.tools.iter().map(tool).collect();
    let mut text = if tools.is_empty() { String::new() } else { row("tools", &tools.join(", ")) };
    if let Some(lines) = remarks::numbers(&survey.pauses, survey.pauses_total) {
        text += &row("waits", &format!("for a person and ~ at line {lines}"));
    }
    text + &remarks::dark_dwells(survey).map_or(String::new(), |words| row("dark", &words))
}

fn places(on: &On) -> String {
    let Some(extents) = on.survey.extents_mm else { return row("extents", "nothing moves") };
    let axis = |index: usize| {
        let [low_mm, high_mm] = [extents.low_mm, extents.high_mm].map(|mm| without_dust(mm[index]));
        format!("{} {low_mm:.3} to {high_mm:.3}", AXIS_NAMES[index])
    };
    let axes = std::array::from_fn::<_, AXES, _>(axis).join(", ");
    let sizes = extents.size_mm().map(|mm| format!("{mm:.3}")).join(" x ");
    let text = row("extents", &format!("{axes} mm: {sizes}"));
    let start = on.start_mm.map(|mm| mm.to_string()).join(",");
    text + &match &on.survey.outside {
        None => row("travel", &format!("it stays within, from --start {start}")),
        Some(outside) => row("travel", &format!("left: {}", remarks::outside(outside))),
    }
}

/// Rounds very small values to zero, so that `-0.000` is not printed.
fn without_dust(mm: f64) -> f64 {
    if mm.abs() < 0.000_5 { 0.0 } else { mm }
}

fn times(on: &On) -> String {
    let (Some(time_s), Some(pace)) = (on.time_s, &on.pace) else {
        return row("time", on.trouble.as_deref().unwrap_or("-"));
    };
    let homing = on.homing_s.filter(|s| *s > 0.0).map_or(String::new(), |s| format!(", after {s:.3} s of homing"));
    let waits = on.waits_s.map_or(String::new(), |[before_s, after_s]| {
        let words = |s: f64, place: &str| if s < LEAST_SHOWN_S { String::new() } else { format!(", {s:.3} s {place}") };
        words(before_s, "waiting before the first move") + &words(after_s, "waiting after the last")
    });
    let refused = if on.survey.refused_total > 0 { ", without what is refused" } else { "" };
    let mut text = row(
        "time",
        &format!(
            "{time_s:.3} s: {:.3} s moving, {:.3} s standing{waits}{homing}{refused}",
            pace.moving_s, pace.standing_s
        ),
    );
    if let Some(shaping) = &on.shaping {
        text += &row("shaping", &shaping.to_string());
    }
    if let Some(words) = pace::beyond_board(pace) {
        text += &row("the board", &words);
    }
    for (index, probe) in on.probes.iter().enumerate() {
        text += &row(if index == 0 { "probed" } else { "" }, probe);
    }
    if pace.moves > 0 {
        text += &row("limited by", &pace::limited_by(pace));
    }
    if let Some(lost) = pace::lost(pace) {
        text += &row("time lost", &lost);
    }
    for worst in pace::worst(pace) {
        text += &format!("    {worst}\n");
    }
    for (index, corner) in pace::corners(pace).enumerate() {
        text += &if index == 0 { row("corners", "those that cost most") } else { String::new() };
        text += &format!("    {corner}\n");
    }
    text + &pace::fastest(pace).map_or(String::new(), |fastest| row("fastest", &fastest))
}

/// A line for each of many programs.
pub fn table(checked: &[Checked], machines: &[Machine]) -> String {
    let folder = common_folder(checked);
    let name = |one: &Checked| one.program[folder.len()..].to_owned();
    let width = checked.iter().map(|one| name(one).chars().count()).max().unwrap_or(0).max("program".len());
    let mut text = format!("{:<width$} {:>7} {:>20} {:>20} {:>20}", "program", "lines", "X, mm", "Y, mm", "Z, mm");
    for machine in machines {
        text += &format!(" {:>11}", format!("{}, s", machine_name(machine, machines)));
    }
    text += "  refused, and what else is wrong\n";
    for one in checked {
        text += &format!("{:<width$} {}\n", name(one), cells(one));
    }
    text + "  X, Y, Z: where its moves are, from where it begins; *: without what is refused\n"
}

/// The folder that contains all programs, with the slash behind it; empty if they are in several folders.
fn common_folder(checked: &[Checked]) -> &str {
    let folder = |one: &'_ Checked| one.program.rfind('/').map_or(0, |slash| slash + 1);
    let Some(first) = checked.first() else { return "" };
    let common = &first.program[..folder(first)];
    if checked.iter().all(|one| one.program[..folder(one)] == *common) { common } else { "" }
}

fn machine_name(machine: &Machine, machines: &[Machine]) -> String {
    if machines.len() == 1 { "time".to_owned() } else { machine.name.clone() }
}

fn cells(one: &Checked) -> String {
    let Some(first) = one.on.first() else { return format!("{:>7} {}", "-", one.unreadable.as_deref().unwrap_or("-")) };
    let mut text = format!("{:>7}", first.survey.lines);
    for axis in 0..AXES {
        let extents = first.survey.extents_mm;
        let words = extents.map_or("-".to_owned(), |bounds| {
            let [low_mm, high_mm] = [bounds.low_mm, bounds.high_mm].map(|mm| without_dust(mm[axis]));
            format!("{low_mm:.2}..{high_mm:.2}")
        });
        text += &format!(" {words:>20}");
    }
    for on in &one.on {
        let mark = if on.survey.refused_total > 0 { "*" } else { " " };
        text += &format!(" {:>11}", on.time_s.map_or("-".to_owned(), |s| format!("{s:.3}{mark}")));
    }
    format!("{text}  {}", wrong(one))
}

fn wrong(one: &Checked) -> String {
    // A line that only one machine refuses is refused because of that machine's settings.
    let mut refused: Vec<String> = Vec::new();
    for on in one.on.iter().filter(|on| on.survey.refused_total > 0) {
        let words = remarks::by_word(&on.survey.refused_by_word);
        if !refused.contains(&words) {
            refused.push(words);
        }
    }
    let of_machines = one.on.iter().flat_map(|on| {
        let left = on
            .survey
            .outside
            .as_ref()
            .map(|outside| format!("leaves the travel of {} (line {})", on.machine, outside.line));
        let longer_s = on.pace.as_ref().map(|pace| pace.longer_on_board_s).filter(|s| *s >= LEAST_SHOWN_S);
        let longer = longer_s.map(|s| format!("the board takes {s:.3} s longer on {}", on.machine));
        let dark = remarks::dark_dwells(&on.survey).map(|_| format!("its laser is dark in dwells on {}", on.machine));
        let trouble = on.trouble.as_ref().map(|trouble| format!("on {}: {trouble}", on.machine));
        [left, longer, dark, trouble].into_iter().flatten()
    });
    let all: Vec<_> = refused.into_iter().chain(of_machines).collect();
    if all.is_empty() { "-".to_owned() } else { all.join("; ") }
}
