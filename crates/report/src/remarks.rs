//! Remarks about a program's lines, in words that several verbs use.

use std::collections::BTreeMap;

use crate::survey::{Fit, Outside, Survey};
use isostep_sim::{AXES, ConsoleError, Outcome};

/// The number of remarks that are printed one by one.
pub const SHOWN_MAX: usize = 10;

/// Names of the axes.
pub use isostep_console::AXIS_NAMES;

/// A line without its comments, cut off if it is very long.
pub fn shortened(text: &str) -> String {
    let (mut kept, mut in_comment) = (String::new(), false);
    for c in text.split(';').next().unwrap_or(text).chars() {
        match c {
            '(' => in_comment = true,
            ')' if in_comment => in_comment = false,
            _ if in_comment => {}
            _ => kept.push(c),
        }
    }
    let text = kept.trim();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// The meaning of an `error:N` for a line of a program.
pub fn meaning(code: u8) -> String {
    let words = ConsoleError::from_code(code).map_or(String::new(), |error| error.to_string());
    // A sender can wait until `?` reports Idle; a file cannot.
    if code == ConsoleError::NotIdle.code() { format!("{words} In a file, put G4 P0 before it.") } else { words }
}

/// `M6 x 12, G64`: the most frequent first, at most ten.
pub fn by_word(counts: &BTreeMap<String, usize>) -> String {
    let mut counts: Vec<_> = counts.iter().collect();
    counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    let words =
        counts.iter().map(|(word, count)| if **count > 1 { format!("{word} x {count}") } else { (*word).clone() });
    let more = counts.len().saturating_sub(SHOWN_MAX);
    let reported = words.take(SHOWN_MAX).collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{reported} and {more} other kinds") } else { reported }
}

/// The dwells of a laser that do not pierce, and what does; `None` if there are none.
pub fn dark_dwells(survey: &Survey) -> Option<String> {
    let lines = numbers(&survey.dark_dwells, survey.dark_dwells_total)?;
    Some(format!(
        "the laser does not pierce at line {lines}: it is dark wherever nothing moves; a short slow move does, such as G1 X0.1 F6"
    ))
}

/// `3, 9 and 4 more`; `None` if there are none.
pub fn numbers(listed: &[usize], total: usize) -> Option<String> {
    let shown: Vec<_> = listed.iter().take(SHOWN_MAX).map(usize::to_string).collect();
    let more = if total > shown.len() { format!(" and {} more", total - shown.len()) } else { String::new() };
    (total > 0).then(|| shown.join(", ") + &more)
}

/// The results of the first probing moves, and how many more there are.
pub fn probes(outcome: &Outcome) -> Vec<String> {
    let mut words: Vec<_> =
        outcome.probes().take(SHOWN_MAX).map(|said| format!("line {}: {}", said.line, said.text)).collect();
    let more = outcome.probes().count().saturating_sub(SHOWN_MAX);
    if more > 0 {
        words.push(format!("and {more} more"));
    }
    words
}

/// The move that leaves the travel, by how much, and the remedy.
pub fn outside(outside: &Outside) -> String {
    let Outside { line, axis, place_mm, nearest_mm, .. } = outside;
    let (text, beyond_mm) = (shortened(&outside.text), (place_mm - nearest_mm).abs());
    format!(
        "line {line} `{text}`: {axis} goes to {place_mm:.3} mm, {beyond_mm:.3} mm beyond the travel, which ends at {nearest_mm:.3}: {}",
        remedy(outside.fit)
    )
}

/// `X1 Y2 Z3` for the values of the axes.
pub fn words(values: [String; AXES]) -> String {
    let words: Vec<_> = AXIS_NAMES.iter().zip(values).map(|(name, value)| format!("{name}{value}")).collect();
    words.join(" ")
}

fn remedy(fit: Fit) -> String {
    match fit {
        Fit::StartAt(place_mm) => format!("it fits with --start {}", place_mm.map(|mm| mm.to_string()).join(",")),
        Fit::OriginAt(place_mm) => {
            format!("it fits with a work offset: `G21 G10 L2 P1 {}` as its first line", words(place_mm.map(|mm| mm.to_string())))
        }
        Fit::TooWide(axis, needs_mm, travel_mm) => format!(
            "the program needs {needs_mm:.1} mm of {}, and the travel is {travel_mm:.1} mm ($13{axis}): scale the program or split it",
            AXIS_NAMES[axis]
        ),
        Fit::Nowhere => {
            "no start and no origin of G54 was found that puts that right, as it goes to machine coordinates (G53, G28), or \
             has offsets of its own: correct the program"
                .to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use isostep_console::Settings;
    use isostep_sim::program::Program;

    use super::*;

    fn left(text: &str) -> String {
        let lines = Program::read(text.as_bytes()).unwrap();
        outside(&Survey::of(&lines, &Settings::DEFAULT, [35.0, 40.0, 15.0]).outside.unwrap())
    }

    #[test]
    fn a_line_is_shown_without_its_comment_and_not_whole_when_long() {
        assert_eq!(shortened("$H   ; find the zero"), "$H");
        assert_eq!(shortened("(first) G0 X5 (then) Y5 ; (last"), "G0 X5  Y5");
        assert_eq!(shortened(&"X1".repeat(50)).len(), 63);
    }

    #[test]
    fn words_are_counted_the_most_frequent_first() {
        let counts = [("G64", 1), ("M100", 12), ("%", 2)].map(|(word, count)| (word.to_owned(), count));
        assert_eq!(by_word(&counts.into()), "M100 x 12, % x 2, G64");
        let many = (10..30).map(|number| (format!("M{number}"), 1)).collect();
        assert!(by_word(&many).ends_with("M19 and 10 other kinds"), "{}", by_word(&many));
    }

    #[test]
    fn what_leaves_the_travel_is_reported_with_what_would_help() {
        assert_eq!(
            left("G0 X5\nG0 X-40 (there)\n"),
            "line 2 `G0 X-40`: X goes to -40.000 mm, 5.001 mm beyond the travel, which ends at -34.999: it fits with --start 41,40,15"
        );
        assert!(
            left("$H\nG0 Y-20\n").ends_with("it fits with a work offset: `G21 G10 L2 P1 X0 Y21 Z0` as its first line")
        );
        assert!(left("G0 Y500\n").ends_with(
            "the program needs 500.0 mm of Y, and the travel is 400.0 mm ($131): scale the program or split it"
        ));
        assert!(left("$H\nG53 G0 Z-1\n").contains("machine coordinates (G53, G28)"));
    }
}
