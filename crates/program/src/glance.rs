//! What a line is, at a glance: most lines are plain, and nothing else is asked of them.

use crate::cursor::Cursor;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Glance {
    /// It goes to the machine as it is.
    Plain,
    /// A plain line that ends the program (M2, M30).
    Ends,
    /// Words with parameters or expressions, or M98 or M99.
    Words,
    /// It begins with an O-word or a program number.
    Label,
    /// It begins with an O-word that nobody can read.
    Unread,
    /// A comment that ends the program with a message: `(ABORT, ...)`.
    Aborts,
}

impl Glance {
    pub fn of(line: &[u8]) -> Self {
        let cursor = behind_number(line);
        match cursor.peek() {
            Some(b'$') => return Self::Plain,
            Some(b'o' | b':') => return Self::Label,
            _ => {}
        }
        let mut glance = Self::Plain;
        let mut at = cursor.at();
        while let Some(byte) = line.get(at) {
            at += 1;
            match byte {
                b'#' | b'[' => return Self::Words,
                b';' => break,
                b'(' => {
                    let mut comment = Cursor::new(line, at);
                    if comment.take_word("abort,") {
                        return Self::Aborts;
                    }
                    comment.go_behind(b')');
                    at = comment.at();
                }
                b'M' | b'm' => match digits(Cursor::new(line, at)) {
                    Some(98 | 99) => return Self::Words,
                    Some(2 | 30) => glance = Self::Ends,
                    _ => {}
                },
                _ => {}
            }
        }
        glance
    }
}

/// Behind what may stand before the first word: `/` and a line number.
pub(crate) fn behind_number(line: &[u8]) -> Cursor<'_> {
    let mut cursor = Cursor::new(line, 0);
    while cursor.take(b'/') {}
    if cursor.take(b'n') {
        while cursor.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            cursor.next();
        }
    }
    cursor
}

/// The whole number that comes; `None` if none comes, or one with decimals, or a long one.
pub(crate) fn digits(mut cursor: Cursor<'_>) -> Option<u32> {
    let mut number: Option<u32> = None;
    while let Some(digit @ b'0'..=b'9') = cursor.peek() {
        number = Some(number.unwrap_or(0).checked_mul(10)?.checked_add(u32::from(digit - b'0'))?);
        cursor.next();
    }
    number.filter(|_| cursor.peek() != Some(b'.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_is_what_it_looks_like() {
        for (line, glance) in [
            ("G1 X1 (#1 [2] o3 M98) ; #4 M2", Glance::Plain),
            ("", Glance::Plain),
            ("$#", Glance::Plain),
            (" $N0=G0 [", Glance::Plain),
            ("% TOOL 5", Glance::Plain),
            ("G1 X1 M02", Glance::Ends),
            ("m 3 0", Glance::Ends),
            ("M2.5 M3 M20 M300", Glance::Plain),
            ("X#1", Glance::Words),
            ("x[1]", Glance::Words),
            ("N10 m098 P1", Glance::Words),
            ("M99", Glance::Words),
            ("/N10 o100 sub", Glance::Label),
            (":1234", Glance::Label),
            ("G0 X1 O5", Glance::Plain),
            ("( Abort , no tool)", Glance::Aborts),
            ("(aborted)", Glance::Plain),
        ] {
            assert_eq!(Glance::of(line.as_bytes()), glance, "{line}");
        }
    }
}
