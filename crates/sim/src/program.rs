//! A program as a sender reads it: its lines, after a check that nothing in them must not be sent.

use std::ops::Deref;
use std::sync::Arc;

use isostep_console::{Error, LineAssembler, Realtime, realtime};
use isostep_program::{LineError, plain_lines};

/// The lines of a program as they are sent, without their line ends. Parameters, expressions and subroutines of the file have been
/// carried out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Program {
    lines: Arc<Vec<Vec<u8>>>,
    /// Their origin, if they are not those of the file.
    origin: Option<Arc<Origin>>,
}

/// The file that lines are made from.
#[derive(Debug, Default, PartialEq, Eq)]
struct Origin {
    /// The number of its lines.
    lines: usize,
    /// The line of the file that each is made from, from 1.
    numbers: Vec<usize>,
    /// The lines of the file that cannot be carried out, each with the number of lines that were made before it.
    errors: Vec<(usize, LineError)>,
}

impl Program {
    /// Reads a file that is to be sent.
    ///
    /// # Errors
    /// [`ProgramError`] with the line at fault.
    pub fn read(file: &[u8]) -> Result<Self, ProgramError> {
        let program = Self::made(lines(file)?);
        let first = program.errors().next().map(|(_, error)| error.clone());
        first.map_or(Ok(program), |error| Err(error.into()))
    }

    /// Reads a file as it is written, for whoever looks at each of its lines: [`clean`] says which must not be sent, and
    /// [`errors`](Self::errors) which cannot be carried out.
    ///
    /// # Errors
    /// [`ProgramError`] if the file is empty or no text.
    pub fn read_raw(file: &[u8]) -> Result<Self, ProgramError> {
        raw_lines(file).map(Self::made)
    }

    fn made(source: Vec<Vec<u8>>) -> Self {
        let (mut lines, mut origin) = (Vec::new(), Origin { lines: source.len(), ..Origin::default() });
        match plain_lines(&source) {
            Ok(plain) if plain.is_plain() => return source.into(),
            Ok(made) => {
                for line in made {
                    match line {
                        Ok(line) => {
                            origin.numbers.push(line.number);
                            lines.push(line.text.into_owned());
                        }
                        Err(error) => origin.errors.push((lines.len(), error)),
                    }
                }
            }
            Err(error) => origin.errors.push((0, error)),
        }
        Self { lines: lines.into(), origin: Some(origin.into()) }
    }

    /// These lines in place of as many others.
    #[must_use]
    pub fn with_lines(&self, lines: Vec<Vec<u8>>) -> Self {
        Self { lines: lines.into(), origin: self.origin.clone() }
    }

    /// The line of the file that a line is made from. Both count from 1.
    pub fn number(&self, line: usize) -> usize {
        match &self.origin {
            Some(origin) => origin.numbers.get(line.wrapping_sub(1)).copied().unwrap_or(origin.lines + 1),
            None => line,
        }
    }

    /// The number of lines of the file, if these are made from others.
    pub fn made_from(&self) -> Option<usize> {
        self.origin.as_ref().map(|origin| origin.lines)
    }

    /// The lines of the file that cannot be carried out, each with the number of lines that were made before it.
    pub fn errors(&self) -> impl Iterator<Item = (usize, &LineError)> {
        self.origin.iter().flat_map(|origin| origin.errors.iter().map(|(before, error)| (*before, error)))
    }
}

impl Deref for Program {
    type Target = [Vec<u8>];

    fn deref(&self) -> &[Vec<u8>] {
        &self.lines
    }
}

impl From<Vec<Vec<u8>>> for Program {
    fn from(lines: Vec<Vec<u8>>) -> Self {
        Self { lines: lines.into(), origin: None }
    }
}

impl FromIterator<Vec<u8>> for Program {
    fn from_iter<I: IntoIterator<Item = Vec<u8>>>(lines: I) -> Self {
        Vec::from_iter(lines).into()
    }
}

/// The reason why a file is not a program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProgramError {
    /// It has no content.
    #[error("the program is empty: it needs at least one line of G-code")]
    Empty,
    /// It contains a byte that text cannot contain.
    #[error("line {line}: byte 0x{byte:02x} is not text: {}", remedy(*.byte))]
    Binary {
        /// Line number, from 1.
        line: usize,
        /// The byte.
        byte: u8,
    },
    /// It contains a byte outside a comment that the controller would execute at once.
    #[error("line {line}: '{}' is a real-time command, obeyed the moment it arrives: take it out of the program", char::from(*.byte))]
    RealTime {
        /// Line number, from 1.
        line: usize,
        /// The byte.
        byte: u8,
    },
    /// A line with parameters, expressions or O-words cannot be carried out.
    #[error(transparent)]
    Line(#[from] LineError),
}

/// The remedy for a byte that text cannot contain.
fn remedy(byte: u8) -> &'static str {
    match byte {
        // A UTF-16 file begins with these bytes, and UTF-8 never has them.
        0xfe.. => "save the file as plain text (UTF-8)",
        0x80.. => "remove it, or put it in a comment",
        _ => "is this a G-code file?",
    }
}

/// A line as the controller's interpreter takes it: without spaces and comments, in upper case.
///
/// # Errors
/// As [`LineAssembler::push`].
pub fn stripped(line: &[u8]) -> Result<String, Error> {
    assembled(line).line().map(str::to_owned)
}

/// The message of the comments of a line to the operator, `(MSG, ...)`; empty if there is none.
pub fn message(line: &[u8]) -> String {
    assembled(line).message().to_owned()
}

fn assembled(line: &[u8]) -> LineAssembler {
    let mut assembler = LineAssembler::new();
    let _ = assembler.take(&mut &*line);
    let _ = assembler.push(b'\n');
    assembler
}

/// The lines of `program` without their line ends, which are LF, CR, CR LF, or CR CR LF (a file whose line ends were
/// converted twice). Characters that old systems put at the end of a file, 0x1a and NULs, are dropped.
///
/// Comments stay, but their real-time characters (`?`, `!`, `~`) and non-ASCII characters become spaces, as in a
/// careful sender. The controller would execute the former anywhere in the stream, and may drop the latter.
///
/// # Errors
/// [`ProgramError`] with the line at fault.
pub fn lines(program: &[u8]) -> Result<Vec<Vec<u8>>, ProgramError> {
    (1..).zip(as_written(program)?).map(|(line, bytes)| clean(line, bytes)).collect()
}

/// The same lines as they are written, for whoever looks at each of them: [`clean`] says which must not be sent.
///
/// # Errors
/// [`ProgramError`] if the file is empty or no text.
pub fn raw_lines(program: &[u8]) -> Result<Vec<Vec<u8>>, ProgramError> {
    let unless_binary = |(line, bytes): (usize, &[u8])| match clean(line, bytes) {
        Err(error @ ProgramError::Binary { byte: ..0x80 | 0xfe.., .. }) => Err(error),
        _ => Ok(bytes.to_vec()),
    };
    (1..).zip(as_written(program)?).map(unless_binary).collect()
}

fn as_written(program: &[u8]) -> Result<impl Iterator<Item = &[u8]>, ProgramError> {
    let text = program.strip_prefix(b"\xef\xbb\xbf").unwrap_or(program);
    let end = text.iter().rposition(|byte| !matches!(byte, 0x1a | 0)).map_or(0, |last| last + 1);
    let text = &text[..end];
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(ProgramError::Empty);
    }
    Ok(split(text))
}

/// The lines of a text without their line ends. LF, CR, CR LF and CR CR LF each end one line, so line numbers are those
/// of editors.
pub(crate) fn split(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || (!text.is_empty()).then(|| cut_line(&mut text)))
}

/// Takes the first line off, with its end.
#[inline(never)]
fn cut_line<'t>(text: &mut &'t [u8]) -> &'t [u8] {
    let end = text.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(text.len());
    let (line, ended) = text.split_at(end);
    let behind = ended.strip_prefix(b"\r\r\n").or_else(|| ended.strip_prefix(b"\r\n"));
    *text = behind.or(ended.get(1..)).unwrap_or_default();
    line
}

/// A line as it is sent: see [`lines`]. `line` is its number.
///
/// # Errors
/// [`ProgramError`] if it must not be sent.
pub fn clean(line: usize, bytes: &[u8]) -> Result<Vec<u8>, ProgramError> {
    let clean = |(byte, in_comment)| match byte {
        b'\t' | b' '..=b'~' if !matches!(byte, b'?' | b'!' | b'~') => Ok(byte),
        b'?' | b'!' | b'~' | 0x80.. if in_comment => Ok(b' '),
        b'?' | b'!' | b'~' => Err(ProgramError::RealTime { line, byte }),
        _ => Err(ProgramError::Binary { line, byte }),
    };
    let mut cleaned = Vec::with_capacity(bytes.len());
    for each in with_comments(bytes) {
        cleaned.push(clean(each)?);
    }
    Ok(cleaned)
}

/// Each byte of a line, and whether it is in a comment.
fn with_comments(bytes: &[u8]) -> impl Iterator<Item = (u8, bool)> {
    bytes.iter().scan(None, |comment, &byte| {
        match (*comment, byte) {
            (None, b'(' | b';') => *comment = Some(byte),
            (Some(b'('), b')') => *comment = None,
            _ => {}
        }
        Some((byte, comment.is_some()))
    })
}

/// The bytes in the comments of a line that the controller obeys at once, if a sender does not strip it: the place of each
/// byte in the line, and what it does. A status report is left out.
pub fn acting(bytes: &[u8]) -> Vec<(usize, &'static str)> {
    let act = |(place, (byte, in_comment)): (usize, (u8, bool))| {
        let does = match realtime::classify(byte).filter(|_| in_comment)? {
            Realtime::Status | Realtime::FullStatus | Realtime::Modal | Realtime::Ignored => return None,
            Realtime::Reset => "resets",
            Realtime::Hold => "holds the machine",
            Realtime::Resume => "resumes a hold, M0 and M6",
            Realtime::Door => "acts as a safety door that opens",
            Realtime::JogCancel => "cancels a jog",
            Realtime::Override(0x90..=0x94) => "changes the feed",
            Realtime::Override(0x95..=0x97) => "changes the rapids",
            Realtime::Override(_) => "changes the speed of the spindle",
            Realtime::SpindleStop => "stops the spindle in a hold",
            Realtime::Flood => "switches flood coolant",
            Realtime::Mist => "switches mist coolant",
            Realtime::ToolChange => "parts lines by hand from the program in a change of the tool",
        };
        Some((place, does))
    };
    with_comments(bytes).enumerate().filter_map(act).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_end_counts_once() {
        let expected: [&[u8]; 4] = [b"G21", b"", b"G0X1", b"$H"];
        assert_eq!(lines(b"G21\n\r\nG0X1\r$H\n").unwrap(), expected);
        assert_eq!(lines(b"G21\r\r\n\r\r\nG0X1\r\n$H\r\r\n").unwrap(), expected, "converted twice");
        assert_eq!(lines(b"G21\r\rG0X1\r$H\r").unwrap(), expected, "two of CR are two");
        assert_eq!(lines(b"\xef\xbb\xbfG21").unwrap(), [b"G21"]);
        assert_eq!(lines(b"G21\r\r\n?"), Err(ProgramError::RealTime { line: 2, byte: b'?' }));
    }

    #[test]
    fn a_program_is_made_and_its_lines_keep_the_numbers_of_the_file() {
        let file = b"#1=3 (what?)\no1 repeat [2]\nG0 X#1\n#1=[#1+1]\no1 endrepeat\nM2\n%\n";
        let program = Program::read(file).unwrap();
        assert_eq!(program.join(&b'\n'), b"G0 X3\nG0 X4\nM2");
        assert_eq!((1..=4).map(|line| program.number(line)).collect::<Vec<_>>(), [3, 3, 6, 8]);
        assert_eq!(program.made_from(), Some(7));
        let plain = Program::read(b"G0 X1\nO7\nM2\n%\n").unwrap();
        assert_eq!((plain.len(), plain.number(3), plain.made_from()), (4, 3, None));
    }

    #[test]
    fn a_line_that_cannot_be_carried_out_is_an_error_or_is_passed_over() {
        let file = b"G0 X1\nX[1\n?\nM2\n";
        let error = Program::read(b"G0 X1\nX[1\nM2\n").unwrap_err();
        assert_eq!(error.to_string(), "line 2 `X[1`: a bracket is not closed: add ]");
        let raw = Program::read_raw(file).unwrap();
        assert_eq!(raw.join(&b'\n'), b"G0 X1\n?\nM2");
        assert_eq!(raw.errors().map(|(before, error)| (before, error.line)).collect::<Vec<_>>(), [(1, 2)]);
        let unfit = Program::read_raw(b"G0 X1\no1 if [1]\n").unwrap();
        assert!(unfit.is_empty() && unfit.errors().count() == 1);
    }

    #[test]
    fn comments_may_hold_anything_that_is_text() {
        let program = "G0 X1 (why? 1 µm!) Y2 ; sure~";
        assert_eq!(lines(program.as_bytes()).unwrap(), [b"G0 X1 (why  1   m ) Y2 ; sure "]);
    }

    #[test]
    fn what_acts_in_a_comment_is_found() {
        let found = |line: &[u8]| acting(line).into_iter().map(|(place, _)| line[place]).collect::<Vec<_>>();
        assert_eq!(found("G0 X1 (Äpfel, Ñ, a\u{a0}b, µ, ü; why?) Y1 ; !~".as_bytes()), [0x84, 0x91, 0xa0, b'!', b'~']);
        assert_eq!(found(b"G0 X1 ! (fine)"), [0; 0], "outside of comments it must not be sent at all");
        assert_eq!(acting("(Ä)".as_bytes()), [(2, "acts as a safety door that opens")]);
    }

    #[test]
    fn one_line_that_must_not_be_sent_spoils_no_program() {
        let text = "G0 X1 (µ)\n?\nG0 X2 µ\n";
        let raw = raw_lines(text.as_bytes()).unwrap();
        assert_eq!(raw.concat(), text.replace('\n', "").as_bytes());
        let sent: Vec<_> = (1..).zip(&raw).map(|(line, bytes)| clean(line, bytes).is_ok()).collect();
        assert_eq!(sent, [true, false, false]);
        assert!(lines(text.as_bytes()).is_err() && raw_lines(b"\x7fELF").is_err() && raw_lines(b"\xff\xfeG").is_err());
    }

    #[test]
    fn what_old_systems_put_at_the_end_is_dropped() {
        for program in [&b"G21\r\nG0 X1\r\n\x1a"[..], b"G21\nG0 X1\x1a", b"G21\nG0 X1\n\0\0", b"G21\nG0 X1\n\x1a\0\x1a"]
        {
            assert_eq!(lines(program).unwrap(), [&b"G21"[..], b"G0 X1"], "{program:?}");
        }
        assert_eq!(lines(b"\x1a"), Err(ProgramError::Empty));
        assert_eq!(lines(b"G21\x1a\nG0"), Err(ProgramError::Binary { line: 1, byte: 0x1a }), "not at the end");
    }

    #[test]
    fn bytes_that_are_no_text_have_a_remedy() {
        let reported = |program: &[u8]| lines(program).unwrap_err().to_string();
        assert_eq!(
            reported("G21\n\nG0 X1 µ".as_bytes()),
            "line 3: byte 0xc2 is not text: remove it, or put it in a comment"
        );
        assert_eq!(reported(b"\xff\xfeG\x000\0"), "line 1: byte 0xff is not text: save the file as plain text (UTF-8)");
        assert_eq!(reported(b"\xfe\xff\0G\x000"), "line 1: byte 0xfe is not text: save the file as plain text (UTF-8)");
        assert_eq!(reported(b"\x7fELF"), "line 1: byte 0x7f is not text: is this a G-code file?");
    }

    #[test]
    fn what_must_not_be_sent_is_refused_with_its_line() {
        assert_eq!(lines(b" \n\r\n"), Err(ProgramError::Empty));
        assert_eq!(lines(b"G21\n?\n"), Err(ProgramError::RealTime { line: 2, byte: b'?' }));
        assert_eq!(lines(b"\x7fELF\x02\x01"), Err(ProgramError::Binary { line: 1, byte: 0x7f }));
        assert_eq!(lines(b"G21\nG0 X\x001"), Err(ProgramError::Binary { line: 2, byte: 0 }));
        assert_eq!(lines("G0 X1 µ".as_bytes()), Err(ProgramError::Binary { line: 1, byte: 0xc2 }));
        assert_eq!(lines(b"G0 X1 (done) !"), Err(ProgramError::RealTime { line: 1, byte: b'!' }));
    }
}
