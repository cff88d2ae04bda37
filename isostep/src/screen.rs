//! What a verb prints. The standard macros panic where it cannot be written; these note that, and the verb goes on: a reader
//! that has gone, as `head` goes, wants no more, and whatever else is in the way is told at the end.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

use anyhow::{Result, bail};

/// The first thing that was in the way.
static FAILURE: Mutex<Option<io::Error>> = Mutex::new(None);

/// As the standard one.
#[macro_export]
macro_rules! print {
    ($($words:tt)*) => { $crate::screen::show(format_args!($($words)*)) };
}

/// As the standard one.
#[macro_export]
macro_rules! println {
    ($($words:tt)*) => { $crate::screen::show(format_args!("{}\n", format_args!($($words)*))) };
}

/// As the standard one.
#[macro_export]
macro_rules! eprintln {
    ($($words:tt)*) => { $crate::screen::tell(format_args!("{}\n", format_args!($($words)*))) };
}

/// Writes to standard output.
pub fn show(words: Arguments) {
    if cfg!(test) {
        // Which the tests' harness captures.
        return std::print!("{words}");
    }
    note(io::stdout().lock().write_fmt(words));
}

/// Writes to standard error. If that cannot be written, there is nobody to be told.
pub fn tell(words: Arguments) {
    if cfg!(test) {
        return std::eprint!("{words}");
    }
    let _ = io::stderr().lock().write_fmt(words);
}

/// Writes what is still kept back.
///
/// # Errors
/// What was printed could not be written, though somebody was there to read it.
pub fn finish() -> Result<()> {
    note(io::stdout().flush());
    match lock().take() {
        None => Ok(()),
        Some(failure) => bail!("what is printed here cannot be written to standard output: {failure}"),
    }
}

fn note(written: io::Result<()>) {
    if let Err(failure) = written
        && failure.kind() != ErrorKind::BrokenPipe
    {
        lock().get_or_insert(failure);
    }
}

fn lock() -> std::sync::MutexGuard<'static, Option<io::Error>> {
    FAILURE.lock().expect("nothing panics while it holds this")
}

/// A whole number with its thousands apart.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let first = (digits.len() + 2) % 3 + 1;
    let (head, tail) = digits.split_at(first.min(digits.len()));
    let groups = tail.as_bytes().chunks(3).map(|group| format!(",{}", String::from_utf8_lossy(group)));
    head.to_owned() + &groups.collect::<String>()
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_set_apart() {
        for (number, text) in [(0, "0"), (999, "999"), (1_000, "1,000"), (30_000, "30,000"), (1_200_000, "1,200,000")] {
            assert_eq!(grouped(number), text);
        }
    }
}
