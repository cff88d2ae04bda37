//! Detects whether a client has the pseudo-terminal open. A real port has a DTR line for this; a pseudo-terminal has
//! none.

/// The changes since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// The first client came.
    pub came: bool,
    /// The last client left.
    pub left: bool,
}

#[cfg(target_os = "linux")]
pub use linux::Presence;

#[cfg(target_os = "linux")]
mod linux {
    use std::mem::MaybeUninit;
    use std::os::fd::OwnedFd;
    use std::path::Path;

    use anyhow::{Context, Result};
    use rustix::fs::inotify::{self, CreateFlags, ReadFlags, Reader, WatchFlags};
    use rustix::io::Errno;

    use super::Change;

    /// Counts openings and closings of a file by others, as the kernel reports them.
    pub struct Presence {
        inotify: OwnedFd,
        clients: u32,
    }

    impl Presence {
        /// Watches from now on. Processes that have the file open already do not count.
        pub fn watch(path: &Path) -> Result<Self> {
            let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)
                .context("the kernel gives no inotify instance: is fs.inotify.max_user_instances used up?")?;
            let events = WatchFlags::OPEN | WatchFlags::CLOSE_WRITE | WatchFlags::CLOSE_NOWRITE;
            inotify::add_watch(&inotify, path, events)
                .with_context(|| format!("{} cannot be watched", path.display()))?;
            Ok(Self { inotify, clients: 0 })
        }

        /// Another process has the file open.
        pub fn is_open(&self) -> bool {
            self.clients > 0
        }

        /// The changes since the last look.
        pub fn look(&mut self) -> Result<Change> {
            let mut change = Change::default();
            let mut buffer = [MaybeUninit::uninit(); 1024];
            let mut reader = Reader::new(&self.inotify, &mut buffer);
            loop {
                match reader.next() {
                    Ok(event) if event.events().contains(ReadFlags::OPEN) => {
                        change.came |= self.clients == 0;
                        self.clients += 1;
                    }
                    Ok(event) if event.events().intersects(ReadFlags::CLOSE_WRITE | ReadFlags::CLOSE_NOWRITE) => {
                        self.clients = self.clients.saturating_sub(1);
                        change.left |= self.clients == 0;
                    }
                    Ok(_) | Err(Errno::INTR) => {}
                    Err(Errno::AGAIN) => return Ok(change),
                    Err(error) => return Err(error).context("the clients of the pseudo-terminal cannot be counted"),
                }
            }
        }
    }
}

#[cfg(all(unix, not(target_os = "linux")))]
pub use elsewhere::Presence;

#[cfg(all(unix, not(target_os = "linux")))]
mod elsewhere {
    use std::path::Path;

    use anyhow::Result;

    use super::Change;

    /// This system does not report openings, so the port always counts as open.
    pub struct Presence;

    impl Presence {
        pub fn watch(_path: &Path) -> Result<Self> {
            Ok(Self)
        }

        pub fn is_open(&self) -> bool {
            true
        }

        pub fn look(&mut self) -> Result<Change> {
            Ok(Change::default())
        }
    }
}
