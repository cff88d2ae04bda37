//! O-words: a label, and what begins, ends or is called there.

use crate::Problem;
use crate::cursor::Cursor;
use crate::expression::{Reader, name};
use crate::glance::{behind_number, digits};
use crate::number::{shown, whole};
use crate::parameters::Parameters;

/// What stands behind a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keyword {
    Sub,
    EndSub,
    Return,
    Call,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// Nothing: the number of a program.
    Number,
}

impl Keyword {
    const ALL: [(&str, Self); 15] = [
        ("sub", Self::Sub),
        ("endsub", Self::EndSub),
        ("return", Self::Return),
        ("call", Self::Call),
        ("if", Self::If),
        ("elseif", Self::ElseIf),
        ("else", Self::Else),
        ("endif", Self::EndIf),
        ("while", Self::While),
        ("endwhile", Self::EndWhile),
        ("do", Self::Do),
        ("repeat", Self::Repeat),
        ("endrepeat", Self::EndRepeat),
        ("break", Self::Break),
        ("continue", Self::Continue),
    ];

    fn take(cursor: &mut Cursor<'_>) -> Option<Self> {
        if cursor.is_over() {
            return Some(Self::Number);
        }
        let behind = |word: &str| {
            let mut ahead = *cursor;
            let is_whole = ahead.take_word(word) && !ahead.peek().is_some_and(|byte| byte.is_ascii_alphabetic());
            is_whole.then_some(ahead)
        };
        let (ahead, keyword) = Self::ALL.into_iter().find_map(|(word, keyword)| Some((behind(word)?, keyword)))?;
        *cursor = ahead;
        Some(keyword)
    }

    /// It ends the line: no value comes behind it.
    pub fn stands_alone(self) -> bool {
        !matches!(self, Self::EndSub | Self::Return | Self::Call | Self::If | Self::ElseIf | Self::While | Self::Repeat)
    }

    pub fn word(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, keyword)| *keyword == self).map_or("", |(word, _)| word)
    }
}

/// A label as it is compared: a number without zeros before it, or a name in small letters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Label(pub String);

impl Label {
    pub fn of_number(number: u32) -> Self {
        Self(number.to_string())
    }

    /// The label with its O, and a word behind it.
    pub fn with(&self, keyword: Keyword) -> String {
        let is_number = self.0.bytes().all(|byte| byte.is_ascii_digit());
        let label = if is_number { format!("o{}", self.0) } else { format!("o<{}>", self.0) };
        format!("{label} {}", keyword.word()).trim_end().to_owned()
    }
}

/// A line that begins with a label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Labelled {
    /// `None` if it has to be computed.
    pub label: Option<Label>,
    pub keyword: Keyword,
    /// The index of the byte behind the keyword.
    pub behind: usize,
}

impl Labelled {
    /// Reads a line that [looks](crate::glance::Glance) like one. `None` if it is none of ours, so that it goes to the machine as it is.
    pub fn read(line: &[u8]) -> Result<Option<Self>, Problem> {
        let mut cursor = behind_number(line);
        cursor.next();
        let start = cursor;
        let label = match cursor.peek() {
            Some(b'<') => Some(Label(name(&mut cursor)?)),
            Some(b'0'..=b'9') => {
                let Some(number) = digits(cursor) else { return Ok(None) };
                while cursor.peek().is_some_and(|byte| byte.is_ascii_digit()) {
                    cursor.next();
                }
                Some(Label::of_number(number))
            }
            Some(b'#' | b'[') => {
                skip_value(&mut cursor);
                None
            }
            _ => return Ok(None),
        };
        let Some(keyword) = Keyword::take(&mut cursor) else {
            let has_values = line.iter().any(|byte| matches!(byte, b'[' | b'#'));
            return if has_values || label.is_none() { Err(Problem::NoKeyword(start.rest())) } else { Ok(None) };
        };
        if keyword.stands_alone() && !cursor.is_over() {
            return Err(Problem::Behind(cursor.rest()));
        }
        if label.is_none() && keyword != Keyword::Call {
            return Err(Problem::ComputedLabel(start.rest()));
        }
        Ok(Some(Self { label, keyword, behind: cursor.at() }))
    }
}

/// Goes behind a parameter or an expression, whose value is not known yet.
fn skip_value(cursor: &mut Cursor<'_>) {
    while cursor.take(b'#') {}
    match cursor.peek() {
        Some(b'<') => cursor.go_behind(b'>'),
        Some(b'[') => {
            let mut open = 0_usize;
            while let Some(byte) = cursor.next() {
                open += usize::from(byte == b'[');
                open -= usize::from(byte == b']');
                if open == 0 {
                    break;
                }
            }
        }
        _ => {
            while cursor.peek().is_some_and(|byte| byte.is_ascii_digit()) {
                cursor.next();
            }
        }
    }
}

/// Computes the label of a call; also returns the index of the byte behind the keyword.
pub(crate) fn computed(line: &[u8], parameters: &Parameters) -> Result<(Label, usize), Problem> {
    let mut cursor = behind_number(line);
    cursor.next();
    let mut reader = Reader::new(cursor, parameters);
    let value = reader.value()?;
    let number = whole(value).and_then(|number| u32::try_from(number).ok());
    let label = number.map(Label::of_number).ok_or_else(|| Problem::BadLabel(shown(value)))?;
    let mut cursor = reader.cursor;
    let _ = Keyword::take(&mut cursor);
    Ok((label, cursor.at()))
}
