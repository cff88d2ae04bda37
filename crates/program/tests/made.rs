//! What becomes of a program, as text.

use isostep_program::{LineError, plain_lines};

/// The plain lines of a program, each behind the number of its line.
///
/// # Errors
/// The first error.
pub fn numbered(program: &str) -> Result<Vec<String>, LineError> {
    let source: Vec<&str> = program.lines().collect();
    let lines = plain_lines(&source)?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    lines.map(|line| line.map(|line| format!("{} {}", line.number, text(&line.text)))).collect()
}

/// The plain lines of a program that is good.
pub fn lines(program: &str) -> Vec<String> {
    let lines = numbered(program).unwrap_or_else(|error| panic!("{error}"));
    lines.into_iter().map(|line| line.split_once(' ').map_or(String::new(), |(_, text)| text.to_owned())).collect()
}

/// The first error of a program, in words.
pub fn error(program: &str) -> String {
    numbered(program).expect_err(program).to_string()
}
