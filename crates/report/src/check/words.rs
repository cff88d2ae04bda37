//! The results of a check in words.

use isostep_console::ToolChange;
use isostep_sim::AXES;
use serde::Serialize;

use super::Check;
use crate::pace::{LEAST_SHOWN_S, words as pace};
use crate::remarks::{self, AXIS_NAMES, SHOWN_MAX, shortened};
use crate::survey::{LISTED_MAX, Survey};

/// A group of lines under one name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// In one or two words.
    pub name: &'static str,
    /// The lines.
    pub words: String,
    /// The places that it is about, a line for each.
    pub places: Vec<String>,
}

fn row(name: &'static str, words: impl Into<String>) -> Row {
    Row { name, words: words.into(), places: Vec::new() }
}

/// All that is said of a program on a machine. Of refused lines up to ten are reported, or `all`.
pub fn rows(check: &Check, all: bool) -> Vec<Row> {
    [fate(&check.survey, all), places(check), times(check)].concat()
}

/// The remarks about the program's lines.
pub fn fate(survey: &Survey, all: bool) -> Vec<Row> {
    let Survey { lines, blocks, statements, empty, moves, arcs, .. } = *survey;
    let counts = format!(
        "{lines}: {blocks} of G-code ({moves} that move, {arcs} of them arcs), {statements} of $, {empty} empty, % or comments"
    );
    let made = survey.made_from.map(|of| {
        row(
            "made",
            format!("from {of} lines of the file: parameters, expressions, O-words and M98 are carried out before the machine gets them"),
        )
    });
    let mut said = vec![row("lines", counts)];
    said.extend(made);
    said.push(refused(survey, all));
    said.extend(persons(survey));
    if let Some((least, most)) = survey.feeds_mm_min {
        let range = if least == most { format!("{least:.0}") } else { format!("{least:.0} to {most:.0}") };
        said.push(row("feeds", format!("{range} mm/min")));
    }
    let left_on = if survey.leaves_tool_on { ", and leaves the spindle on (M3, M4)" } else { "" };
    said.push(match survey.ends_at {
        Some(line) => row("ends", format!("by M2 or M30, line {line}{left_on}")),
        None => row("ends", format!("without M2 or M30: its modes stay in force{left_on}")),
    });
    said
}

fn refused(survey: &Survey, all: bool) -> Row {
    let total = survey.refused_total;
    let mut said = row("refused", if total == 0 { "none".to_owned() } else { total.to_string() });
    let reported = if all { LISTED_MAX } else { SHOWN_MAX };
    for refused in survey.refused.iter().take(reported) {
        let (line, code, remedy) = (refused.line, refused.code, &refused.remedy);
        let error = if code == 0 { String::new() } else { format!("error:{code} ") };
        said.places.push(format!("line {line} `{}`: {error}{remedy}", shortened(&refused.text)));
    }
    if total > reported {
        let how = if all { "" } else { "; --all tells up to 1,000" };
        let by_word = remarks::by_word(&survey.refused_by_word);
        said.places.push(format!("and {} more, in all {by_word}{how}", total - reported));
    }
    said
}

/// The places where a person has to act.
fn persons(survey: &Survey) -> Vec<Row> {
    let tool = |(tool, line): (&u32, &usize)| {
        let name = if *tool == 0 { "any".to_owned() } else { format!("T{tool}") };
        let comment = survey.tool_comments.get(tool).map_or(String::new(), |comment| format!(": {comment}"));
        format!("{name} (line {line}){comment}")
    };
    let tools: Vec<_> = survey.tools.iter().map(tool).collect();
    let waits = remarks::numbers(&survey.pauses, survey.pauses_total);
    let rows = [
        (!tools.is_empty())
            .then(|| row("tools", tools.join(if survey.tool_comments.is_empty() { ", " } else { "; " }))),
        (!tools.is_empty()).then(|| needed(survey.settings.tool_change())).flatten().map(|words| row("needed", words)),
        waits.map(|lines| row("waits", format!("for a person and ~ at line {lines}"))),
        needs_messages(survey).then(|| row("messages", "none: no (MSG, ...) says what the tools are")),
        remarks::dark_dwells(survey).map(|words| row("dark", words)),
        above_full(survey).map(|words| row("power", words)),
        beside_places(survey).map(|words| row("places", words)),
        comments(survey),
    ];
    rows.into_iter().flatten().collect()
}

/// What has to be done before M6 with `$341`.
fn needed(change: ToolChange) -> Option<&'static str> {
    match change {
        ToolChange::Manual => {
            Some("$H before M6, which goes up and waits ($341=1), and a probe or a plate to measure the tool ($TPW)")
        }
        ToolChange::ManualAtSetter => Some(
            "$H before M6, and G59.3 above the plate that measures tools (G10 L2 P9), where $TPW goes down ($341=2)",
        ),
        ToolChange::AutomaticAtSetter => Some(
            "$H before M6, and G59.3 above the plate that measures tools (G10 L2 P9), which each tool touches ($341=3)",
        ),
        _ => None,
    }
}

/// True if a tool is changed, and nothing tells the person more than its number.
fn needs_messages(survey: &Survey) -> bool {
    survey.messages == 0 && (!survey.tools.is_empty() || survey.tool_numbers.len() > 1)
}

fn above_full(survey: &Survey) -> Option<String> {
    let lines = remarks::numbers(&survey.above_full, survey.above_full_total)?;
    let (highest_rpm, full_rpm) = survey.highest_rpm?;
    Some(format!(
        "S up to {highest_rpm:.0} is above $30={full_rpm:.0}, from which on the power is full, at line {lines}"
    ))
}

fn beside_places(survey: &Survey) -> Option<String> {
    let lines = remarks::numbers(&survey.moves_beside_places, survey.moves_beside_places_total)?;
    Some(format!(
        "G28.1 and G30.1 store the place where the machine stands, and axis words beside them are a move after that, at line {lines}"
    ))
}

/// The remarks about comments that act on the machine.
fn comments(survey: &Survey) -> Option<Row> {
    let place = |(words, lines): (&String, &Vec<usize>)| {
        let lines = remarks::numbers(lines, lines.len()).unwrap_or_default();
        format!("line {lines}: {words}")
    };
    let words = "with bytes that act at once, if a sender does not strip them: write plain ASCII";
    let places: Vec<_> = survey.acting.iter().map(place).collect();
    (!places.is_empty()).then(|| Row { places, ..row("comments", words) })
}

fn places(check: &Check) -> Vec<Row> {
    let Some(extents) = check.survey.extents_mm else { return vec![row("extents", "nothing moves")] };
    let axis = |index: usize| {
        let [low_mm, high_mm] = [extents.low_mm, extents.high_mm].map(|mm| without_dust(mm[index]));
        format!("{} {low_mm:.3} to {high_mm:.3}", AXIS_NAMES[index])
    };
    let (rotary, linear): (Vec<_>, Vec<_>) = (0..AXES).partition(|&index| check.survey.settings.is_rotary(index));
    let sizes: Vec<_> = linear.iter().map(|&index| format!("{:.3}", extents.size_mm()[index])).collect();
    let mut axes = format!("{} mm: {}", linear.into_iter().map(axis).collect::<Vec<_>>().join(", "), sizes.join(" x "));
    rotary.into_iter().for_each(|index| axes += &format!(", {} degrees", axis(index)));
    let start = check.start_mm.map(|mm| mm.to_string()).join(",");
    let travel = match &check.survey.outside {
        None => format!("it stays within, from --start {start}"),
        Some(outside) => format!("left: {}", remarks::outside(outside)),
    };
    vec![row("extents", axes), row("travel", travel)]
}

/// Rounds very small values to zero, so that `-0.000` is not printed.
pub fn without_dust(mm: f64) -> f64 {
    if mm.abs() < 0.000_5 { 0.0 } else { mm }
}

fn times(check: &Check) -> Vec<Row> {
    let (Some(time_s), Some(pace)) = (check.time_s, &check.pace) else {
        return vec![row("time", check.trouble.as_deref().unwrap_or("-"))];
    };
    let (moving_s, standing_s) = (pace.moving_s, pace.standing_s);
    let beside = beside(check);
    let time = row("time", format!("{time_s:.3} s: {moving_s:.3} s moving, {standing_s:.3} s standing{beside}"));
    let probed = check.probes.iter().enumerate();
    let probed = probed.map(|(index, probe)| row(if index == 0 { "probed" } else { "" }, probe));
    let rows = [
        Some(time),
        check.shaping.as_ref().map(|shaping| row("shaping", shaping.to_string())),
        pace::beyond_board(pace).map(|words| row("the board", words)),
    ];
    let limited = (pace.moves > 0).then(|| row("limited by", pace::limited_by(pace)));
    let rest = [
        limited,
        lost(check),
        corners(check),
        pace::fastest(pace, &check.survey.settings).map(|words| row("fastest", words)),
    ];
    rows.into_iter().flatten().chain(probed).chain(rest.into_iter().flatten()).collect()
}

/// Times beside that of the program.
fn beside(check: &Check) -> String {
    let shown = |s: f64, words: String| if s < LEAST_SHOWN_S { String::new() } else { words };
    let [before_s, after_s] = check.waits_s.unwrap_or_default();
    let before = shown(before_s, format!(", {before_s:.3} s waiting before the first move"));
    let after = shown(after_s, format!(", {after_s:.3} s waiting after the last"));
    let homing = check.homing_s.filter(|s| *s > 0.0).map_or(String::new(), |s| format!(", after {s:.3} s of homing"));
    let refused = if check.survey.refused_total > 0 { ", without what is refused" } else { "" };
    format!("{before}{after}{homing}{refused}")
}

fn lost(check: &Check) -> Option<Row> {
    let pace = check.pace.as_ref()?;
    let (lost, places) = (pace::lost(pace), pace::worst(pace).collect::<Vec<_>>());
    let is_reported = lost.is_some() || !places.is_empty();
    is_reported.then(|| Row { places, ..row("time lost", lost.unwrap_or_else(|| "at its ends".to_owned())) })
}

fn corners(check: &Check) -> Option<Row> {
    let places: Vec<_> = pace::corners(check.pace.as_ref()?).collect();
    (!places.is_empty()).then(|| Row { places, ..row("corners", "those that cost most") })
}
