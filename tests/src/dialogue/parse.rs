//! From the text of a file to dialogues: headings, sentences, notes and steps.

use std::fmt;

use isostep_sim::Port;

use super::step::Step;

/// A machine that dialogues are carried out on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    /// The simulated one.
    Simulator,
    /// The emulated board, whose steps this port makes.
    Board(Port),
}

impl On {
    fn read(name: &str) -> Result<Self, String> {
        match name {
            "simulator" => Ok(Self::Simulator),
            "board" => Ok(Self::Board(Port::Pio)),
            "timer-board" => Ok(Self::Board(Port::Timer)),
            _ => Err(format!("`{name}` is no machine: use simulator, board (steps by PIO) or timer-board")),
        }
    }
}

/// One dialogue.
#[derive(Debug)]
pub struct Dialogue {
    /// Its name, a word of small letters, digits and `_`: the name of its test.
    pub name: String,
    /// The machines that it is carried out on: the simulated one, unless it says otherwise.
    pub on: Vec<On>,
    /// Its steps, each with the number of its line.
    pub steps: Vec<(usize, Step)>,
}

/// The fault in a line of a file.
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

/// A line with its number.
type Line = (usize, String);

/// Reads a file. What stands before the first heading is about the file.
///
/// # Errors
/// The first line that is no step, and a dialogue without a sentence or without a step.
pub fn dialogues(text: &str) -> Result<Vec<Dialogue>, Wrong> {
    let lines: Vec<Line> = (1..).zip(text.lines().map(str::to_owned)).collect();
    let mut found = Vec::<Dialogue>::new();
    let is_heading = |(_, text): &Line| text.starts_with("=== ");
    let begin = lines.iter().position(is_heading).unwrap_or(lines.len());
    for part in lines[begin..].chunk_by(|_, next| !is_heading(next)) {
        let dialogue = dialogue(part)?;
        if found.iter().any(|other| other.name == dialogue.name) {
            return Err(Wrong { line: part[0].0, why: not_a_name(&dialogue.name) });
        }
        found.push(dialogue);
    }
    Ok(found)
}

fn not_a_name(name: &str) -> String {
    format!("`{name}` is no new name: use small letters, digits and _, and each name once")
}

/// A dialogue, from its heading on.
fn dialogue(lines: &[Line]) -> Result<Dialogue, Wrong> {
    let (line, name) = (lines[0].0, &lines[0].1["=== ".len()..]);
    if !name.chars().all(|each| each.is_ascii_lowercase() || each.is_ascii_digit() || each == '_') {
        return Err(Wrong { line, why: not_a_name(name) });
    }
    let sentence = lines.get(1).map_or("", |(_, text)| text);
    if !sentence.starts_with(|first: char| first.is_uppercase() || first.is_ascii_digit() || "`$".contains(first)) {
        let why = format!("`{sentence}` is no sentence: write in the line below the heading what is tested");
        return Err(Wrong { line: line + 1, why });
    }
    let steps: Vec<_> = lines.iter().skip_while(|(_, text)| !text.is_empty()).cloned().collect();
    let mut dialogue = Dialogue { name: name.to_owned(), on: vec![On::Simulator], steps: Vec::new() };
    for (line, text) in expanded(&steps)? {
        let wrong = |why| Wrong { line, why };
        if let Some(names) = text.strip_prefix("on: ") {
            dialogue.on = names.split(' ').map(On::read).collect::<Result<_, _>>().map_err(wrong)?;
        } else if !text.is_empty() && !text.starts_with('#') {
            dialogue.steps.push((line, Step::read(&text).map_err(wrong)?));
        }
    }
    if dialogue.steps.is_empty() {
        return Err(Wrong { line, why: format!("`{name}` has no steps: write or remove it") });
    }
    Ok(dialogue)
}

/// The lines, where those between `repeat` or `each` and `end` stand as often as they are to be carried out.
fn expanded(lines: &[Line]) -> Result<Vec<Line>, Wrong> {
    let (mut all, mut rest) = (Vec::new(), lines);
    while let Some(((line, text), behind)) = rest.split_first() {
        rest = behind;
        let wrong = |why: String| Wrong { line: *line, why };
        let (names, rows) = match text.split_once(' ') {
            Some(("repeat", times)) => {
                let times: usize =
                    times.parse().map_err(|_| wrong(format!("`{times}` is no number of times: write one")))?;
                ("", vec![""; times])
            }
            Some(("each", table)) => {
                let (names, rows) =
                    table.split_once(':').ok_or_else(|| wrong(format!("`{table}` has no names and a colon")))?;
                let below = rest.iter().take_while(|(_, text)| text.starts_with("| ")).count();
                let below_rows = rest[..below].iter().map(|(_, text)| &text[2..]);
                let rows = rows.split(", ").map(str::trim).filter(|row| !row.is_empty()).chain(below_rows).collect();
                rest = &rest[below..];
                (names, rows)
            }
            _ if text == "end" => return Err(wrong("nothing is repeated here: remove `end`".to_owned())),
            _ => {
                all.push((*line, text.clone()));
                continue;
            }
        };
        let length = body(rest).ok_or_else(|| wrong(format!("`{text}` has no `end`: write it")))?;
        for row in rows {
            let filled: Vec<_> = rest[..length].iter().map(|(line, text)| (*line, filled(text, names, row))).collect();
            all.extend(expanded(&filled)?);
        }
        rest = &rest[length + 1..];
    }
    Ok(all)
}

/// The number of lines up to the `end` that belongs to what is before them.
fn body(lines: &[Line]) -> Option<usize> {
    let mut depth = 0;
    lines.iter().position(|(_, text)| {
        if text == "end" && depth == 0 {
            return true;
        }
        depth -= u32::from(text == "end");
        depth += u32::from(text.starts_with("repeat ") || text.starts_with("each "));
        false
    })
}

/// A line with the values of a row in place of their names in braces. Values stand apart by ` | `, or by spaces, and then the last
/// one may have spaces.
fn filled(text: &str, names: &str, row: &str) -> String {
    let names: Vec<_> = names.split(' ').collect();
    let apart = if row.contains(" | ") { " | " } else { " " };
    let values = row.splitn(names.len(), apart).map(str::trim);
    names.iter().zip(values).fold(text.to_owned(), |text, (name, value)| text.replace(&format!("{{{name}}}"), value))
}

#[test]
fn a_file_is_read() {
    let text = "About the file.\n\n=== one\nIt is tested.\nIt goes on.\n\nhomed\n# A note.\n> G0 X1\n< ok\n\n=== two\nMore.\n\nhomed\n";
    let found = dialogues(text).unwrap();
    let lines = |at: usize| found[at].steps.iter().map(|(line, _)| *line).collect::<Vec<_>>();
    assert_eq!((found.len(), found[0].name.as_str(), found[1].name.as_str()), (2, "one", "two"));
    assert_eq!((lines(0), lines(1)), (vec![7, 9, 10], vec![15]));
    let on = |text: &str| dialogues(text).unwrap().swap_remove(0).on;
    assert_eq!(on("=== one\nIt.\n\nhomed\n"), [On::Simulator]);
    let both = [On::Simulator, On::Board(Port::Timer)];
    assert_eq!(on("=== one\nIt.\n\non: simulator timer-board\nhomed\n"), both);
    let repeated = dialogues("=== one\nIt.\n\nhomed\nrepeat 2\n> G0 X1\n< ok\nend\nsilence\n").unwrap();
    assert_eq!(repeated[0].steps.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [4, 6, 7, 6, 7, 9]);
}

#[test]
fn a_table_is_carried_out_row_by_row() {
    let text = "=== one\nIt.\n\neach a b: 1 x y, 2 z\neach c d:\n| 3 | y z\n| 4 | w\n> {a}{c} {b} {d}\nend\nend\n";
    let lines = ["13 x y y z", "14 x y w", "23 z y z", "24 z w"].map(|line| Step::read(&format!("> {line}")).unwrap());
    let steps = dialogues(text).unwrap().swap_remove(0).steps;
    assert_eq!(steps, lines.map(|step| (8, step)));
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
        ("repeat 2", "`repeat 2` has no `end`: write it"),
        ("each x", "`x` has no names and a colon"),
        ("report", "a report of nothing: write what it must have"),
        ("on: moon", "`moon` is no machine: use simulator, board"),
        ("figure axes", "`axes`: which figure, and what must it be?"),
    ] {
        let said = reported(&format!("=== one\nA.\n\n{step}\n"));
        assert!(said.starts_with("4: ") && said.contains(words), "{step}: {said}");
    }
}
