//! Patterns, which may stand for a line or a number in a dialogue.

/// True if the text is what is written, where `...` stands for any text.
pub fn matches(pattern: &str, text: &str) -> bool {
    let Some((begin, rest)) = pattern.split_once("...") else { return pattern == text };
    let Some(text) = text.strip_prefix(begin) else { return false };
    (0..=text.len()).any(|at| text.is_char_boundary(at) && matches(rest, &text[at..]))
}

/// True if the lines are what is written, where `...` alone stands for any number of lines.
pub fn all_match(patterns: &[String], lines: &[String]) -> bool {
    let plain = patterns.iter().position(|pattern| pattern == "...").unwrap_or(patterns.len());
    let begins =
        lines.len() >= plain && patterns[..plain].iter().zip(lines).all(|(pattern, line)| matches(pattern, line));
    match &patterns[plain..] {
        [] => begins && lines.len() == plain,
        [_, rest @ ..] => begins && (plain..=lines.len()).any(|at| all_match(rest, &lines[at..])),
    }
}

/// A whole number, or all from one to another, both included: `5`, `5..7` or `..7`; `*` is any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbers {
    least: i64,
    most: i64,
}

impl Numbers {
    /// 0 alone.
    pub const ZERO: Self = Self { least: 0, most: 0 };

    /// Reads them.
    pub fn read(text: &str) -> Option<Self> {
        let (least, most) = text.split_once("..").unwrap_or((text, text));
        let (least, most) = if text == "*" { ("", "") } else { (least, most) };
        let number = |text: &str, open| if text.is_empty() { Some(open) } else { text.parse().ok() };
        let numbers = Self { least: number(least, i64::MIN)?, most: number(most, i64::MAX)? };
        (numbers.least <= numbers.most).then_some(numbers)
    }

    /// True if this is one of them.
    pub fn contains(self, number: i64) -> bool {
        (self.least..=self.most).contains(&number)
    }
}

#[test]
fn dots_stand_for_any_text_and_any_lines() {
    for (pattern, text, expected) in [
        ("ok", "ok", true),
        ("ok", "okay", false),
        ("<Idle|...", "<Idle|MPos:0.000>", true),
        ("...|Pn:X>", "<Idle|Pn:X>", true),
        ("...|Pn:X>", "<Idle|Pn:XY>", false),
        ("[MSG:... is hot...", "[MSG:X driver is hot: cool it]", true),
    ] {
        assert_eq!(matches(pattern, text), expected, "{pattern} {text}");
    }
    let lines = ["[MSG:a]", "ALARM:1", "ok"].map(str::to_owned);
    let written =
        |patterns: &[&str]| all_match(&patterns.iter().map(|&each| each.to_owned()).collect::<Vec<_>>(), &lines);
    assert!(written(&["...", "ALARM:1", "..."]) && written(&["[MSG:...", "ALARM:1", "ok"]) && written(&["..."]));
    assert!(!written(&["ALARM:1", "..."]) && !written(&["...", "ALARM:1"]) && !written(&[]));
}

#[test]
fn numbers_include_both_ends() {
    let numbers = Numbers::read("-5..7").unwrap();
    assert!(numbers.contains(-5) && numbers.contains(7) && !numbers.contains(8) && !numbers.contains(-6));
    assert!(Numbers::read("5").unwrap().contains(5));
    assert!(Numbers::read("..5").unwrap().contains(-9) && !Numbers::read("..5").unwrap().contains(6));
    assert!(Numbers::read("*").unwrap().contains(i64::MIN));
    assert_eq!([Numbers::read("7..5"), Numbers::read("x"), Numbers::read("1..x")], [None; 3]);
}
