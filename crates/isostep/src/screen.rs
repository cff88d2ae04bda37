//! Prints a verb's output. The standard macros panic when they cannot write. The macros here remember the error, and
//! the verb goes on: a closed pipe, as with `head`, is no error, and any other error is reported at the end.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

use anyhow::{Result, bail};

/// The first error that prevented printing.
static FAILURE: Mutex<Option<io::Error>> = Mutex::new(None);

/// Like `std::print!`, without its panic.
#[macro_export]
macro_rules! print {
    ($($words:tt)*) => { $crate::screen::show(format_args!($($words)*)) };
}

/// Like `std::println!`, without its panic.
#[macro_export]
macro_rules! println {
    ($($words:tt)*) => { $crate::screen::show(format_args!("{}\n", format_args!($($words)*))) };
}

/// Like `std::eprintln!`, without its panic.
#[macro_export]
macro_rules! eprintln {
    ($($words:tt)*) => { $crate::screen::tell(format_args!("{}\n", format_args!($($words)*))) };
}

/// Prints which step of a longer task begins.
pub fn announce(step: &str) {
    crate::eprintln!("==> {step}");
}

/// Writes to standard output.
pub fn show(words: Arguments) {
    if cfg!(test) {
        // The test harness captures this.
        return std::print!("{words}");
    }
    note(io::stdout().lock().write_fmt(words));
}

/// Writes to standard error. If that fails, there is nowhere to report it.
pub fn tell(words: Arguments) {
    if cfg!(test) {
        return std::eprint!("{words}");
    }
    let _ = io::stderr().lock().write_fmt(words);
}

/// Flushes the standard output.
///
/// # Errors
/// When something printed could not be written, except because the reader has gone.
pub fn finish() -> Result<()> {
    note(io::stdout().flush());
    match lock().take() {
        None => Ok(()),
        Some(failure) => bail!("what is printed here cannot be written to standard output: {failure}"),
    }
}

/// Remembers why something could not be printed, unless its reader has gone.
pub(crate) fn note(written: io::Result<()>) {
    if let Err(failure) = written
        && failure.kind() != ErrorKind::BrokenPipe
    {
        lock().get_or_insert(failure);
    }
}

fn lock() -> std::sync::MutexGuard<'static, Option<io::Error>> {
    FAILURE.lock().expect("nothing panics while it holds this")
}

/// A whole number with commas between the thousands.
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
