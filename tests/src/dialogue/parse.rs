//! From the text of a file to dialogues: headings, sentences, notes and steps.

use std::fmt;

use super::step::Step;

/// One dialogue.
#[derive(Debug)]
pub struct Dialogue {
    /// Its name, a word of small letters, digits and `_`: the name of its test.
    pub name: String,
    /// Its steps, each with the number of its line.
    pub steps: Vec<(usize, Step)>,
}

/// What is wrong in a line of a file.
#[derive(Debug, PartialEq, Eq)]
pub struct Wrong {
    /// Number of the line.
    pub line: usize,
    /// The value, what was expected, and the remedy.
    pub why: String,
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.line, self.why)
    }
}

/// Reads a file. What stands before the first heading is about the file.
///
/// # Errors
/// The first line that is no step, and a dialogue without a sentence or without a step.
pub fn dialogues(text: &str) -> Result<Vec<Dialogue>, Wrong> {
    let (mut found, mut repeats) = (Vec::<Dialogue>::new(), Vec::new());
    let mut lines = (1..).zip(text.lines()).peekable();
    while let Some((line, text)) = lines.next() {
        let wrong = |why| Wrong { line, why };
        if let Some(name) = text.strip_prefix("=== ") {
            let is_name = name.chars().all(|each| each.is_ascii_lowercase() || each.is_ascii_digit() || each == '_');
            if !is_name || found.iter().any(|dialogue| dialogue.name == name) {
                return Err(wrong(format!(
                    "`{name}` is no new name: use small letters, digits and _, and each name once"
                )));
            }
            let sentence = lines.peek().map_or("", |(_, text)| text);
            if !sentence
                .starts_with(|first: char| first.is_uppercase() || first.is_ascii_digit() || "`$".contains(first))
            {
                let why = format!("`{sentence}` is no sentence: write in the line below the heading what is tested");
                return Err(Wrong { line: line + 1, why });
            }
            while lines.next_if(|(_, text)| !text.is_empty()).is_some() {}
            if let Some((times, _)) = repeats.pop() {
                return Err(wrong(format!("the dialogue before has a `repeat {times}` without `end`: write it")));
            }
            found.push(Dialogue { name: name.to_owned(), steps: Vec::new() });
        } else if let Some(dialogue) = found.last_mut().filter(|_| !text.is_empty() && !text.starts_with('#')) {
            if let Some(times) = text.strip_prefix("repeat ") {
                let times: usize =
                    times.parse().map_err(|_| wrong(format!("`{times}` is no number of times: write one")))?;
                repeats.push((times, dialogue.steps.len()));
            } else if text == "end" {
                let (times, from) =
                    repeats.pop().ok_or_else(|| wrong("nothing is repeated here: remove `end`".to_owned()))?;
                let steps = dialogue.steps.split_off(from);
                dialogue.steps.extend(steps.iter().cycle().take(times * steps.len()).cloned());
            } else {
                dialogue.steps.push((line, Step::read(text).map_err(wrong)?));
            }
        }
    }
    let (last, empty) = (text.lines().count(), found.iter().find(|dialogue| dialogue.steps.is_empty()));
    empty.map_or(Ok(()), |each| {
        Err(Wrong { line: last, why: format!("`{}` has no steps: write or remove it", each.name) })
    })?;
    Ok(found)
}

#[test]
fn a_file_is_read() {
    let text = "About the file.\n\n=== one\nIt is tested.\nIt goes on.\n\nhomed\n# A note.\n> G0 X1\n< ok\n\n=== two\nMore.\n\nhomed\n";
    let found = dialogues(text).unwrap();
    let lines = |at: usize| found[at].steps.iter().map(|(line, _)| *line).collect::<Vec<_>>();
    assert_eq!((found.len(), found[0].name.as_str(), found[1].name.as_str()), (2, "one", "two"));
    assert_eq!((lines(0), lines(1)), (vec![7, 9, 10], vec![15]));
    let repeated = dialogues("=== one\nIt.\n\nhomed\nrepeat 2\n> G0 X1\n< ok\nend\nsilence\n").unwrap();
    assert_eq!(repeated[0].steps.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [4, 6, 7, 6, 7, 9]);
}

#[test]
fn a_wrong_line_is_reported_with_what_was_expected() {
    let reported = |text: &str| dialogues(text).unwrap_err().to_string();
    assert!(reported("=== One\nA.\n\nhomed\n").starts_with("1: `One` is no new name: use small letters"));
    assert!(reported("=== one\nA.\n\nhomed\n=== one\nA.\n\nhomed\n").starts_with("5: `one` is no new name"));
    assert!(reported("=== one\n\nhomed\n").starts_with("2: `` is no sentence: write in the line below"));
    assert!(reported("=== one\nA.\n\n").contains("`one` has no steps"));
    for (step, words) in [
        ("jump", "`jump` is no step: use one of "),
        ("wait 5", "`5` is no time: write one as `0.5 s`, `20 ms` or `87 us`"),
        ("switch W closed", "`W` is no motor"),
        ("switch X shut", "`shut` is no state of a switch: use closed, open or normal"),
        ("with $9999=1", "`$9999=1` is no setting"),
        ("with door", "`door` is nothing a machine can have"),
        ("steps 1", "`1` has 1 numbers: write one for each of the "),
        ("steps 1 2 7..5", "`7..5` is no number"),
        ("tool laser", "`laser` is no output"),
        ("! \\xZZ", "`\\xZZ` is no byte"),
        ("end", "nothing is repeated here: remove `end`"),
        ("repeat x", "`x` is no number of times"),
        ("report", "a report of nothing: write what it must have"),
    ] {
        let said = reported(&format!("=== one\nA.\n\n{step}\n"));
        assert!(said.starts_with("4: ") && said.contains(words), "{step}: {said}");
    }
}
