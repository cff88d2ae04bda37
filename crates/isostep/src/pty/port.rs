//! The pseudo-terminal: a serial port without a wire.
//!
//! # Design
//! A sender opens the other end, the slave, by its path. This process keeps the slave open too, because otherwise the
//! port would end with its first client. A fresh pseudo-terminal echoes and waits for whole lines, so it is set to raw
//! mode, and set again whenever a client has left. Nothing here blocks: what a client does not take within
//! [`PATIENCE_S`] is dropped, as the firmware does with a USB host that has ceased to read.

use std::collections::VecDeque;
use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{OpenOptionsExt, symlink};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use rustix::fs::OFlags;
use rustix::pty::{self, OpenptFlags};
use rustix::termios::{self, OptionalActions, QueueSelector};

use super::presence::{Change, Presence};
use crate::stopwatch::Stopwatch;

/// The same value as the firmware's for a USB host.
const PATIENCE_S: f64 = 0.2;
const CHUNK_BYTES: usize = 4096;

/// This process's end of a pseudo-terminal. Senders open the other end.
pub struct Pty {
    master: File,
    slave: File,
    path: PathBuf,
    presence: Presence,
    /// Bytes that the client has not taken yet.
    pending: VecDeque<u8>,
    /// Running since the client stopped taking bytes.
    blocked: Option<Stopwatch>,
    /// Set when bytes were dropped; cleared when the client takes bytes again.
    stalled: bool,
    dropped_bytes: u64,
    _link: Option<Link>,
}

impl Pty {
    /// Opens a pseudo-terminal in raw mode, and creates a symbolic link to it if one is requested.
    pub fn open(link: Option<&Path>) -> Result<Self> {
        let master = pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)
            .context("the system gives no pseudo-terminal: are all in use?")?;
        pty::grantpt(&master)?;
        pty::unlockpt(&master)?;
        rustix::io::ioctl_fionbio(&master, true)?;
        let path = PathBuf::from(OsStr::from_bytes(pty::ptsname(&master, Vec::new())?.as_bytes()));
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits() as i32;
        let slave = OpenOptions::new().read(true).write(true).custom_flags(flags).open(&path);
        let slave = slave.with_context(|| format!("{} cannot be opened", path.display()))?;
        make_raw(&slave)?;
        Ok(Self {
            master: master.into(),
            slave,
            presence: Presence::watch(&path)?,
            _link: link.map(|link| Link::new(link, &path)).transpose()?,
            path,
            pending: VecDeque::new(),
            blocked: None,
            stalled: false,
            dropped_bytes: 0,
        })
    }

    /// The path that senders open.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A client has it open.
    pub fn is_open(&self) -> bool {
        self.presence.is_open()
    }

    /// Number of bytes that clients did not take in time.
    pub fn dropped_bytes(&self) -> u64 {
        self.dropped_bytes
    }

    /// Returns who opened and closed the port since the last call. Old bytes are discarded, so the first client that
    /// comes does not receive them.
    pub fn look(&mut self) -> Result<Change> {
        let change = self.presence.look()?;
        if change.came || change.left {
            self.pending.clear();
            (self.blocked, self.stalled) = (None, false);
        }
        if change.came {
            termios::tcflush(&self.slave, QueueSelector::IFlush)?;
        }
        if !self.presence.is_open() {
            if change.left {
                // A client that was killed leaves its lock and its terminal modes behind.
                termios::ioctl_tiocnxcl(&self.slave)?;
                make_raw(&self.slave)?;
            }
            self.drain();
        }
        Ok(change)
    }

    /// Discards what the last client has not read. It needs repeated calls because the kernel passes the bytes on in
    /// parts.
    fn drain(&mut self) {
        while self.slave.read(&mut [0; CHUNK_BYTES]).is_ok_and(|count| count > 0) {}
    }

    /// The bytes that clients have sent.
    pub fn read(&mut self) -> Result<Vec<u8>> {
        let mut bytes = vec![0; CHUNK_BYTES];
        match self.master.read(&mut bytes) {
            Ok(count) => bytes.truncate(count),
            Err(error) if is_not_ready(&error) => bytes.clear(),
            Err(error) => return Err(error).context("the pseudo-terminal cannot be read"),
        }
        Ok(bytes)
    }

    /// Queues `bytes` for the client behind those that it has not taken yet.
    pub fn write(&mut self, bytes: &[u8]) -> Result<()> {
        if !self.presence.is_open() {
            return Ok(());
        }
        if self.stalled && !bytes.is_empty() {
            // A client that reads again may have received half a line. The line is ended here so that the next one is
            // whole.
            self.stalled = !self.take(b"\r\n")?;
        }
        if self.stalled {
            self.dropped_bytes += bytes.len() as u64;
            return Ok(());
        }
        self.pending.extend(bytes);
        self.pump()
    }

    fn pump(&mut self) -> Result<()> {
        while !self.pending.is_empty() {
            match self.master.write(self.pending.make_contiguous()) {
                Ok(count) => {
                    self.pending.drain(..count);
                    self.blocked = None;
                }
                Err(error) if is_not_ready(&error) => {
                    self.drop_what_is_late();
                    break;
                }
                Err(error) => return Err(error).context("the pseudo-terminal cannot be written"),
            }
        }
        Ok(())
    }

    fn drop_what_is_late(&mut self) {
        if self.blocked.get_or_insert_with(Stopwatch::start).elapsed_s() >= PATIENCE_S {
            self.dropped_bytes += self.pending.len() as u64;
            self.pending.clear();
            (self.blocked, self.stalled) = (None, true);
        }
    }

    /// Offers `bytes` to the client. True if it takes all of them at once.
    fn take(&mut self, bytes: &[u8]) -> Result<bool> {
        match self.master.write(bytes) {
            Ok(count) => Ok(count == bytes.len()),
            Err(error) if is_not_ready(&error) => Ok(false),
            Err(error) => Err(error).context("the pseudo-terminal cannot be written"),
        }
    }
}

fn is_not_ready(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn make_raw(terminal: impl AsFd) -> Result<()> {
    let mut modes = termios::tcgetattr(&terminal)?;
    modes.make_raw();
    termios::tcsetattr(&terminal, OptionalActions::Now, &modes).context("the pseudo-terminal cannot be made raw")
}

/// A symbolic link with a fixed name. It exists as long as this value.
struct Link {
    link: PathBuf,
    path: PathBuf,
}

impl Link {
    fn new(link: &Path, path: &Path) -> Result<Self> {
        if let Ok(there) = fs::symlink_metadata(link) {
            make_way(link, &there, path)?;
        }
        symlink(path, link).with_context(|| format!("{} cannot be made", link.display()))?;
        Ok(Self { link: link.to_owned(), path: path.to_owned() })
    }
}

/// Removes a link that a killed run has left: its target no longer exists, or is this terminal, because the numbers of
/// terminals are reused.
fn make_way(link: &Path, there: &fs::Metadata, path: &Path) -> Result<()> {
    let shown = link.display();
    ensure!(there.file_type().is_symlink(), "{shown} is there already and is no symbolic link: choose another --link");
    let end = fs::read_link(link).with_context(|| format!("{shown} cannot be read"))?;
    ensure!(
        end == path || !link.exists(),
        "{shown} is another's: it points to {}, which is there. Choose another --link, or end the machine behind it; remove the \
         link if there is none",
        end.display()
    );
    fs::remove_file(link).with_context(|| format!("{shown} cannot be replaced"))
}

impl Drop for Link {
    fn drop(&mut self) {
        if fs::read_link(&self.link).is_ok_and(|path| path == self.path) {
            let _ = fs::remove_file(&self.link);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run was killed, and the next one gets a terminal with the same number.
    #[test]
    fn a_stale_link_to_this_very_terminal_is_replaced() {
        let pty = Pty::open(None).unwrap();
        let link = std::env::temp_dir().join(format!("isostep-stale-{}", std::process::id()));
        symlink(pty.path(), &link).unwrap();
        drop(Link::new(&link, pty.path()).unwrap());
        assert!(fs::symlink_metadata(&link).is_err());
    }
}
