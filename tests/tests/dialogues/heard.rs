//! The lines received in answer to something that was sent. A failure prints what was sent and all lines that came.

use std::fmt;
use std::ops::{Deref, DerefMut, Index};
use std::slice::SliceIndex;

/// The lines in order. They are compared, indexed and searched like a vector.
#[derive(Clone)]
pub struct Heard {
    sent: String,
    lines: Vec<String>,
}

impl Heard {
    /// The answer to these bytes.
    pub fn new(sent: &[u8], lines: Vec<String>) -> Self {
        Self { sent: sent.escape_ascii().to_string(), lines }
    }

    /// The last line.
    #[track_caller]
    pub fn last_line(&self) -> &str {
        self.lines.last().unwrap_or_else(|| panic!("{self:?}, where a line was expected"))
    }

    /// Checks that one of the lines begins with `begins`.
    #[track_caller]
    pub fn expect(&self, begins: &str) {
        assert!(self.lines.iter().any(|line| line.starts_with(begins)), "{self:?}, where `{begins}` was expected");
    }
}

impl Deref for Heard {
    type Target = Vec<String>;

    fn deref(&self) -> &Vec<String> {
        &self.lines
    }
}

impl DerefMut for Heard {
    fn deref_mut(&mut self) -> &mut Vec<String> {
        &mut self.lines
    }
}

impl<I: SliceIndex<[String]> + fmt::Debug + Clone> Index<I> for Heard {
    type Output = I::Output;

    #[track_caller]
    fn index(&self, index: I) -> &I::Output {
        let lines = self.lines.get(index.clone());
        lines.unwrap_or_else(|| panic!("{self:?}, where line {index:?} was expected"))
    }
}

impl<T, const N: usize> PartialEq<[T; N]> for Heard
where
    String: PartialEq<T>,
{
    fn eq(&self, lines: &[T; N]) -> bool {
        self.lines == *lines
    }
}

impl PartialEq<Vec<String>> for Heard {
    fn eq(&self, lines: &Vec<String>) -> bool {
        self.lines == *lines
    }
}

impl PartialEq for Heard {
    fn eq(&self, other: &Self) -> bool {
        self.lines == other.lines
    }
}

impl IntoIterator for Heard {
    type Item = String;
    type IntoIter = std::vec::IntoIter<String>;

    fn into_iter(self) -> Self::IntoIter {
        self.lines.into_iter()
    }
}

impl fmt::Debug for Heard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` was answered with {:?}", self.sent, self.lines)
    }
}

#[test]
#[should_panic(expected = "`$X\\n` was answered with [], where line 0 was expected")]
fn a_missing_line_is_reported_with_what_was_sent() {
    let _ = &Heard::new(b"$X\n", Vec::new())[0];
}

#[test]
#[should_panic(expected = "`$X` was answered with [\"ok\"], where `[MSG:` was expected")]
fn a_line_that_did_not_come_is_reported_with_those_that_did() {
    Heard::new(b"$X", vec!["ok".to_owned()]).expect("[MSG:");
}
