//! A job of other people on the model: how far it is accepted, where it ends, and how far it reaches.

use super::arcs::{Reach, joined, reach_of};
use super::block::Refused;
use super::machine::{Model, Place};
use super::settings::SettingValues;
use super::words::{ONE, Word};

/// The result of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// The index of each line that is refused, and the number of its error.
    pub refused: Vec<(usize, Refused)>,
    /// The place at its end, mm in machine coordinates.
    pub end_mm: [f64; 3],
    /// The least and the greatest place of each axis, mm; that of the start if nothing moves.
    pub reach_mm: Reach,
    /// The largest difference of the radii of an arc, mm.
    pub misfit_mm: f64,
}

/// Follows the lines of a job on a machine with these settings that stands at its zero. A line that is refused changes nothing.
#[must_use]
pub fn follow(lines: &[Vec<u8>], settings: &[String]) -> Followed {
    let mut model = Model::new(SettingValues::from_listing(settings));
    let (mut reach, mut misfit) = (reach_of(&[model.position]), 0.0_f64);
    let mut refused = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        let begin = model.position;
        model.path.clear();
        if let Err(code) = read(line).and_then(|words| model.block(&words)) {
            refused.push((index, code));
            continue;
        }
        let moved = !model.path.is_empty();
        model.path.extend(moved.then_some(begin));
        if moved {
            reach = joined(reach, reach_of(&model.path));
        }
        if let Some((bent, by)) = model.bend {
            (reach, misfit) = (joined(reach, bent), misfit.max(by));
        }
    }
    let mm = |angstrom: f64| angstrom / ONE as f64;
    Followed {
        refused,
        end_mm: as_mm(model.position),
        reach_mm: reach.map(|(low, high)| (mm(low), mm(high))),
        misfit_mm: mm(misfit),
    }
}

fn as_mm(place: Place) -> [f64; 3] {
    place.map(|angstrom| angstrom as f64 / ONE as f64)
}

/// The words of a line as a person has written it.
///
/// # Errors
/// A letter is missing, or a number.
fn read(line: &[u8]) -> Result<Vec<Word>, Refused> {
    let text = bare(&String::from_utf8_lossy(line));
    let is_name = |text: &str| text.strip_prefix('O').is_some_and(|rest| rest.parse::<u32>().is_ok());
    if text.starts_with(['%', ':']) || is_name(&text) {
        return Ok(Vec::new());
    }
    let (mut words, mut rest) = (Vec::new(), text.as_str());
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_alphabetic() {
            return Err(1);
        }
        let number = &rest[1..];
        let length = number.find(|one: char| !matches!(one, '0'..='9' | '.' | '+' | '-')).unwrap_or(number.len());
        words.push(Word { letter, value: value(&number[..length]).ok_or(2)? });
        rest = &number[length..];
    }
    Ok(words)
}

/// A line without comments and spaces, in capitals.
fn bare(line: &str) -> String {
    let mut in_comment = false;
    let mut text = String::new();
    for one in line.chars() {
        match one {
            ';' if !in_comment => break,
            '(' => in_comment = true,
            ')' => in_comment = false,
            _ if in_comment || one.is_whitespace() || one == '/' => {}
            _ => text.push(one.to_ascii_uppercase()),
        }
    }
    text
}

/// A decimal number in ten-millionths, to the nearest.
fn value(text: &str) -> Option<i64> {
    let value: f64 = text.parse().ok()?;
    Some((value * ONE as f64).round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_as_it_is_written() {
        let words =
            |text: &str| read(text.as_bytes()).map(|words| words.iter().map(Word::to_string).collect::<String>());
        assert_eq!(words("n10 g01 x-1.50 (to; X5) /y.5 ; end"), Ok("N10G1X-1.5Y0.5".to_owned()));
        assert_eq!(["%1", "O1234 (a name)", " : 12"].map(words), [(); 3].map(|()| Ok(String::new())));
        assert_eq!(["5", "G", "X1-2"].map(words), [Err(1), Err(2), Err(2)]);
    }
}
