//! The tool's findings about a whole program.

use isostep_program::{plain_lines, tools_asked};
use isostep_report::check::{Check, Stand, rows};
use isostep_report::{Figures, remarks};
use isostep_sim::program::{Program, lines, raw_lines};
use isostep_sim::{Flash, run_watched};
use serde::Serialize;

use crate::config;
use crate::trouble::Trouble;

/// A longer program's record takes more memory than a page should ask for.
pub(crate) const RECORDED_LINES_MAX: usize = 50_000;

/// The findings of `isostep check`, as JSON of rows: of a program that is too long, those from its lines alone. Nothing moves.
///
/// # Errors
/// [`Trouble`] with the line of the program, or of the settings, that cannot be.
pub fn check(program: &[u8], settings: &str) -> Result<String, Trouble> {
    let config = config(settings)?;
    let lines = Program::read_raw(program)?;
    let check = if lines.len() > RECORDED_LINES_MAX {
        let why = format!(
            "more lines than {RECORDED_LINES_MAX} take more memory here than a page has: `isostep check` says how long they take, and why"
        );
        Check::unrun(&lines, &config.settings, Stand::default(), &why)
    } else {
        Check::of(&lines, &config.settings, Stand::default(), &mut |_| {})
    };
    Ok(serde_json::to_string(&rows(&check, false)).expect("texts have a form in JSON"))
}

/// The lines of a program that have M6, each with its tool and the comment about it, as JSON.
///
/// # Errors
/// [`Trouble`] if the file is no text.
pub fn tools(program: &[u8]) -> Result<String, Trouble> {
    let asked = tools_asked(&raw_lines(program)?);
    let rows: Vec<_> =
        asked.into_iter().map(|one| ToolRow { line: one.line, tool: one.tool, comment: one.comment }).collect();
    Ok(serde_json::to_string(&rows).expect("texts have a form in JSON"))
}

/// A line that has M6.
#[derive(Serialize)]
struct ToolRow {
    line: usize,
    tool: u32,
    comment: Option<String>,
}

/// The plain lines of a program that computes or calls, each with the number of the line that it was made from, as JSON; `null` for a program of
/// plain lines.
///
/// # Errors
/// [`Trouble`] with the line that cannot be carried out.
pub fn plain(program: &[u8]) -> Result<String, Trouble> {
    let source = lines(program)?;
    let is_plain = plain_lines(&source).is_ok_and(|made| made.is_plain());
    let program = Program::read(program)?;
    let numbered =
        program.iter().enumerate().map(|(index, line)| (program.number(index + 1), String::from_utf8_lossy(line)));
    let made = (!is_plain).then(|| numbered.collect::<Vec<_>>());
    Ok(serde_json::to_string(&made).expect("texts have a form in JSON"))
}

/// Every figure of a run, as `isostep sim --json` writes them, for the program of this name.
///
/// # Errors
/// As [`check`], and if the program is too long.
pub fn report(name: &str, program: &[u8], settings: &str) -> Result<String, Trouble> {
    let config = config(settings)?;
    let lines = Program::read(program)?;
    if lines.len() > RECORDED_LINES_MAX {
        let words = format!(
            "a report of {} lines takes more memory than a page has, which makes one of at most {RECORDED_LINES_MAX}: \
             `isostep sim {} --json OUT.json` makes it",
            lines.len(),
            remarks::shortened(name),
        );
        return Err(Trouble::without_line(words));
    }
    let outcome = run_watched(lines, &config, Flash::blank(), &mut |_| {})?;
    Ok(serde_json::to_string_pretty(&Figures::new(name, &outcome)).expect("figures have a form in JSON"))
}
