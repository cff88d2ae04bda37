//! What a verb prints. The standard macros panic where it cannot be written; these note that, and the verb goes on: a reader
//! that has gone, as `head` goes, wants no more, and whatever else is in the way is told at the end.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

use anyhow::{Result, bail};

/// The first thing that was in the way.
static FAILURE: Mutex<Option<io::Error>> = Mutex::new(None);

/// As the standard one.
macro_rules! print {
    ($($words:tt)*) => { $crate::screen::show(format_args!($($words)*)) };
}

/// As the standard one.
macro_rules! println {
    ($($words:tt)*) => { $crate::screen::show(format_args!("{}\n", format_args!($($words)*))) };
}

/// As the standard one.
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
