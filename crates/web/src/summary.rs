//! The report of a page at the end of a run.

use isostep_motion::AXES;
use isostep_sim::stream::{Pause, Refusal};
use isostep_sim::verify::{Gathered, Verdict};
use isostep_sim::{ConsoleError, Outcome};
use serde::Serialize;

/// Lines that are reported one by one.
const REPORTED_MAX: usize = 1_000;
/// As many texts as `$G` and `$#` make, with a table that is full.
const SAID_MAX: usize = 60;

#[derive(Serialize)]
struct Summary<'a> {
    duration_s: f64,
    homing_s: f64,
    motion_s: f64,
    moves: usize,
    steps: usize,
    state: String,
    position_mm: [f64; AXES],
    travel_mm: [f64; AXES],
    lines_sent: usize,
    cut_short: bool,
    alarm: Option<u8>,
    verdicts: Vec<Verdict>,
    refusals: Vec<Refused<'a>>,
    refusals_total: usize,
    pauses: &'a [Pause],
    messages: Vec<&'a str>,
    /// The last texts that the machine has sent, answers apart.
    said_last: Vec<&'a str>,
}

/// A refused line with its reason in words.
#[derive(Serialize)]
struct Refused<'a> {
    line: usize,
    text: &'a str,
    code: u8,
    words: String,
}

impl<'a> From<&'a Refusal> for Refused<'a> {
    fn from(refusal: &'a Refusal) -> Self {
        // The machine's own words about this line, or what the code means.
        let words =
            refusal.words.clone().or_else(|| ConsoleError::from_code(refusal.code).map(|error| error.to_string()));
        Self { line: refusal.line, text: &refusal.text, code: refusal.code, words: words.unwrap_or_default() }
    }
}

/// The summary as JSON.
pub(crate) fn of(gathered: &Gathered, end: &Outcome) -> String {
    let summary = Summary {
        duration_s: end.duration_ns as f64 * 1e-9,
        homing_s: gathered.homing_ns() as f64 * 1e-9,
        motion_s: end.motion_s,
        moves: gathered.moves(),
        steps: gathered.edges(),
        state: end.state_words(),
        position_mm: end.position_mm,
        travel_mm: end.travel_mm,
        lines_sent: end.lines_sent,
        cut_short: end.cut_short,
        alarm: end.alarm_code,
        verdicts: gathered.verdicts(end),
        refusals: end.refusals.iter().take(REPORTED_MAX).map(Refused::from).collect(),
        refusals_total: end.refusals.len(),
        pauses: &end.pauses,
        messages: end.messages().take(REPORTED_MAX).collect(),
        said_last: end.said.iter().rev().take(SAID_MAX).rev().map(|said| said.text.as_str()).collect(),
    };
    serde_json::to_string(&summary).expect("numbers and texts have a form in JSON")
}
