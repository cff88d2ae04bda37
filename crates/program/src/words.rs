//! A line of words with parameters and expressions, made into a plain one.

use crate::Problem;
use crate::cursor::Cursor;
use crate::expression::{Reader, count, is_number};
use crate::number::text;
use crate::operation::Function;
use crate::parameters::{Parameter, Parameters};

/// The most times that L of M98 asks for.
const TIMES_MAX: u32 = 1_000_000;

/// What becomes of a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Words {
    /// The plain line; empty if nothing of it is for the machine.
    pub text: Vec<u8>,
    /// What it sets, in order.
    pub sets: Vec<(Parameter, f64)>,
    /// The program that it calls, and how often.
    pub call: Option<(u32, u32)>,
    /// M99: it ends a program that has been called.
    pub returns: bool,
    /// M2 or M30: it ends the program.
    pub ends: bool,
}

/// A part of a line, as it goes to the machine.
struct Piece {
    /// In upper case; 0 for a comment or what is no word.
    letter: u8,
    value: f64,
    text: Vec<u8>,
}

impl Piece {
    fn is(&self, letter: u8, value: f64) -> bool {
        self.letter == letter && self.value == value
    }

    /// A comment that is for the operator.
    fn is_message(&self) -> bool {
        let mut cursor = Cursor::new(&self.text, 0);
        cursor.take(b'(') && cursor.take_word("msg,")
    }
}

impl Words {
    /// Reads a line with the parameters as they are before it.
    pub fn read(line: &[u8], parameters: &Parameters) -> Result<Self, Problem> {
        let mut words = Self::default();
        let mut pieces = pieces(line, parameters, &mut words.sets)?;
        words.ends = pieces.iter().any(|piece| piece.is(b'M', 2.0) || piece.is(b'M', 30.0));
        words.take_call(&mut pieces)?;
        let is_changed = !words.sets.is_empty() || words.call.is_some() || words.returns;
        let is_empty = pieces.iter().all(|piece| matches!(piece.letter, 0 | b'N'));
        if is_changed && is_empty {
            pieces.retain(Piece::is_message);
        }
        let text: Vec<u8> = pieces.into_iter().flat_map(|piece| piece.text).collect();
        words.text = if is_changed { text.trim_ascii().to_vec() } else { text };
        Ok(words)
    }

    /// Takes the words of M98 and M99 out of a line.
    fn take_call(&mut self, pieces: &mut Vec<Piece>) -> Result<(), Problem> {
        let count_of = |value: f64| pieces.iter().filter(|piece| piece.is(b'M', value)).count();
        let (calls, returns) = (count_of(98.0), count_of(99.0));
        if calls + returns > 1 {
            return Err(Problem::TwoCalls);
        }
        if calls + returns == 0 {
            return Ok(());
        }
        let all = |letter: u8| pieces.iter().filter(move |piece| piece.letter == letter);
        if all(b'P').count() > 1 || all(b'L').count() > 1 {
            return Err(Problem::TwoCalls);
        }
        let of = |letter: u8| all(letter).next().map(|piece| piece.value);
        if returns == 1 {
            if let Some(line) = of(b'P') {
                return Err(Problem::ReturnToLine(crate::number::shown(line)));
            }
            self.returns = true;
        } else {
            let number = count(of(b'P').ok_or(Problem::CallWithoutNumber)?, "P", u32::MAX)?;
            self.call = Some((number, of(b'L').map_or(Ok(1), |times| count(times, "L", TIMES_MAX))?));
        }
        let is_call =
            |piece: &Piece| piece.is(b'M', 98.0) || piece.is(b'M', 99.0) || matches!(piece.letter, b'P' | b'L');
        pieces.retain(|piece| !is_call(piece));
        Ok(())
    }
}

fn pieces(line: &[u8], parameters: &Parameters, sets: &mut Vec<(Parameter, f64)>) -> Result<Vec<Piece>, Problem> {
    let mut reader = Reader::new(Cursor::new(line, 0), parameters);
    let mut pieces = Vec::new();
    loop {
        let start = reader.cursor.at();
        let Some(byte) = reader.cursor.peek() else { return Ok(pieces) };
        if byte == b'#' {
            sets.push(setting(&mut reader)?);
            continue;
        }
        if byte == b'[' {
            return Err(Problem::NoLetter(reader.cursor.rest()));
        }
        reader.cursor.next();
        let mut piece = Piece { letter: 0, value: f64::NAN, text: Vec::new() };
        match byte {
            b'(' => reader.cursor.go_behind(b')'),
            b';' => reader.cursor.go_behind(b'\n'),
            b'a'..=b'z' => piece = word(byte.to_ascii_uppercase(), start, &mut reader)?,
            _ => {}
        }
        if piece.text.is_empty() {
            piece.text = reader.cursor.since(start).to_vec();
        }
        pieces.push(piece);
    }
}

/// A word whose letter has been read. If its value is a plain number, it stays as it is written.
fn word(letter: u8, start: usize, reader: &mut Reader<'_, '_>) -> Result<Piece, Problem> {
    let before = reader.cursor;
    let is_plain = is_number(before);
    if !is_plain && !has_value(before) {
        return Ok(Piece { letter, value: f64::NAN, text: Vec::new() });
    }
    let value = match reader.value() {
        // The machine says what is wrong with it.
        Err(_) if is_plain => return Ok(Piece { letter, value: f64::NAN, text: Vec::new() }),
        value => value?,
    };
    let text = if is_plain { Vec::new() } else { [before.since(start), text(value)?.as_bytes()].concat() };
    Ok(Piece { letter, value, text })
}

/// True if a value comes that is no plain number.
fn has_value(mut cursor: Cursor<'_>) -> bool {
    while cursor.take(b'+') || cursor.take(b'-') {}
    matches!(cursor.peek(), Some(b'[' | b'#')) || Function::take(&mut cursor).is_some()
}

/// Reads `#1 = value`.
fn setting(reader: &mut Reader<'_, '_>) -> Result<(Parameter, f64), Problem> {
    let parameter = reader.parameter()?;
    if !reader.cursor.take(b'=') {
        return Err(Problem::NoEqualSign(reader.cursor.rest()));
    }
    Parameters::may_set(&parameter)?;
    Ok((parameter, reader.value()?))
}
