//! Runs other programs. Their output is shown as it comes, and failures are explained.

use std::ffi::OsStr;
use std::io::{self, ErrorKind, Write};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail};

/// Prints which step of a longer task begins.
pub fn announce(step: &str) {
    tell(&format!("==> {step}"));
}

/// Writes a line to standard error. If that fails, there is nowhere to report it.
pub fn tell(words: &str) {
    let _ = writeln!(io::stderr().lock(), "{words}");
}

/// Runs `command` with its output passed through.
///
/// # Errors
/// If it cannot be started, or fails.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command.status().map_err(|error| explain(command, &error, "install it, and have it on PATH"))?;
    if !status.success() {
        bail!("`{}` failed ({status})", line(command));
    }
    Ok(())
}

/// The trimmed output of `command`. `remedy` says what to do if the program is missing.
pub fn output(command: &mut Command, remedy: &str) -> Result<String> {
    let output = command.stderr(Stdio::piped()).output().map_err(|error| explain(command, &error, remedy))?;
    if !output.status.success() {
        bail!("`{}` failed ({}): {}", line(command), output.status, String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// The trimmed output of `command`; `None` if it cannot be started or fails.
pub fn printed(command: &mut Command) -> Option<String> {
    output(command, "").ok()
}

/// Runs `command` with its output passed through, and kills it if it takes longer than `limit`.
pub fn run_within(command: &mut Command, limit: Duration) -> Result<()> {
    let mut child = command.spawn().with_context(|| format!("cannot start `{}`", line(command)))?;
    let pid = child.id();
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || sender.send(child.wait()));
    match receiver.recv_timeout(limit) {
        Ok(status) if status.as_ref().is_ok_and(|status| status.success()) => Ok(()),
        Ok(status) => bail!("`{}` failed ({})", line(command), status?),
        Err(_) => {
            let _ = Command::new("kill").arg(pid.to_string()).status();
            bail!("`{}` gave no result within {} s", line(command), limit.as_secs())
        }
    }
}

fn explain(command: &Command, error: &std::io::Error, remedy: &str) -> anyhow::Error {
    let program = command.get_program().to_string_lossy();
    match error.kind() {
        ErrorKind::NotFound => anyhow::anyhow!("`{program}` is not installed: {remedy}"),
        _ => anyhow::anyhow!("cannot start `{program}`: {error}"),
    }
}

fn line(command: &Command) -> String {
    let words: Vec<_> =
        std::iter::once(command.get_program()).chain(command.get_args()).map(OsStr::to_string_lossy).collect();
    words.join(" ")
}
