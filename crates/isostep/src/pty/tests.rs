//! Tests with a simulated machine on a pseudo-terminal and several kinds of clients.
#![expect(clippy::disallowed_methods, reason = "a client waits for a machine that is paced to the wall clock")]

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::{OpenOptionsExt, symlink};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use rustix::fs::OFlags;

use super::simulated::Simulated;
use super::{Closing, Pty, Tally};
use crate::stopwatch::Stopwatch;

const PATIENCE_S: f64 = 20.0;

/// Like the bridge's function, but for a client that panics when a check fails.
pub fn while_running(speed: f64, client: impl FnOnce(&Path)) -> (Tally, Closing) {
    let content = |path: &Path| {
        client(path);
        Ok(())
    };
    super::while_running(speed, || Ok(Simulated::default()), content).unwrap()
}

/// The sender's end of the port.
struct Client {
    file: File,
    heard: String,
}

impl Client {
    fn open(path: &Path) -> Self {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits() as i32;
        let file = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path).unwrap();
        Self { file, heard: String::new() }
    }

    /// Sends all of `text`. On a busy computer the machine may read later than this writes.
    fn say(&mut self, text: &str) {
        let stopwatch = Stopwatch::start();
        let mut left = text.as_bytes();
        while !left.is_empty() {
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "{} bytes of {text:?} are not read", left.len());
            match self.file.write(left) {
                Ok(count) => left = &left[count..],
                Err(error) => {
                    assert_eq!(error.kind(), ErrorKind::WouldBlock);
                    thread::sleep(Duration::from_millis(1));
                }
            }
        }
    }

    /// Asks for reports until one has these words.
    fn ask(&mut self, words: &str) {
        let stopwatch = Stopwatch::start();
        while !self.heard.contains(words) {
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {words:?} in {:?}", self.heard);
            self.say("?");
            thread::sleep(Duration::from_millis(5));
            self.read();
        }
    }

    /// Everything received up to and including `words`.
    fn hear(&mut self, words: &str) -> String {
        let stopwatch = Stopwatch::start();
        loop {
            if let Some(at) = self.heard.find(words) {
                let rest = self.heard.split_off(at + words.len());
                return std::mem::replace(&mut self.heard, rest);
            }
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {words:?} in {:?}", self.heard);
            self.read();
        }
    }

    fn read(&mut self) {
        let mut bytes = [0; 256];
        match self.file.read(&mut bytes) {
            Ok(count) => self.heard += std::str::from_utf8(&bytes[..count]).unwrap(),
            Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
        }
        thread::sleep(Duration::from_millis(1));
    }
}

const WELCOME: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";

#[test]
fn a_client_is_welcomed_and_answered_and_nothing_is_echoed() {
    let (tally, _) = while_running(1.0, |path| {
        let mut client = Client::open(path);
        assert_eq!(client.hear("\r\n").trim(), "");
        client.hear("help]\r\n");
        client.say("?");
        assert!(client.hear(">\r\n").starts_with("<Idle|MPos:0.000,0.000,0.000|"));
    });
    assert_eq!((tally.clients, tally.bytes_in, tally.dropped_bytes), (1, 1, 0));
    assert_eq!(tally.flight.most, 0);
}

#[cfg(target_os = "linux")]
#[test]
fn the_next_client_finds_the_machine_as_it_was_and_nothing_stale() {
    let (tally, closing) = while_running(20.0, |path| {
        let mut client = Client::open(path);
        client.hear(WELCOME);
        client.say("G0 X5\n");
        client.hear("ok\r\n");
        // It leaves without reading the answer.
        client.say("$I\n?");
        drop(client);
        thread::sleep(Duration::from_millis(200));
        let mut client = Client::open(path);
        assert_eq!(client.hear(WELCOME), WELCOME);
        client.say("?");
        assert!(client.hear(">\r\n").starts_with("<Idle|MPos:5.000,0.000,0.000|"));
    });
    assert_eq!((tally.clients, closing.position_steps, closing.steps), (2, [250, 0, 0], [250, 0, 0]));
    assert_eq!((closing.state.as_str(), closing.steps_lost), ("Idle", Some(0)));
}

#[test]
fn what_the_machine_does_at_the_end_is_reported_in_words() {
    let (_, closing) = while_running(20.0, |path| {
        let mut client = Client::open(path);
        client.hear(WELCOME);
        client.say("M0\n");
        client.ask("<Hold:0|");
    });
    assert_eq!(closing.state, "Hold:0");
}

#[test]
fn a_client_that_does_not_read_holds_nothing_up() {
    let (tally, closing) = while_running(50.0, |path| {
        let mut client = Client::open(path);
        client.hear(WELCOME);
        // More than the kernel buffers for a client.
        for _ in 0..150 {
            client.say("$$\n");
            thread::sleep(Duration::from_millis(5));
        }
        client.say("G0 X1\n");
        thread::sleep(Duration::from_millis(500));
        // First comes the rest of what was buffered, then whole lines again.
        client.ask("\r\n<Idle|MPos:1.000,0.000,0.000|");
    });
    assert!(tally.dropped_bytes > 0);
    assert_eq!(closing.position_steps, [50, 0, 0]);
}

#[test]
fn bytes_beyond_the_window_are_counted_and_none_is_lost() {
    let (tally, closing) = while_running(50.0, |path| {
        let mut client = Client::open(path);
        client.hear(WELCOME);
        client.say(&"G0 X1\nG0 X0\n".repeat(20));
        for _ in 0..40 {
            client.hear("ok\r\n");
        }
        client.say("G4 P0.01\n");
        client.hear("ok\r\n");
    });
    assert_eq!((tally.flight.most, tally.flight.times_over, tally.flight.answered), (240, 1, 41));
    assert_eq!((closing.steps, closing.position_steps), ([2000, 0, 0], [0; 3]));
}

/// A folder for this test alone.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("isostep-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn a_link_lives_as_long_as_the_port_and_takes_no_file_s_place() {
    let folder = folder("link");
    let link = folder.join("port");
    symlink("/dev/pts/gone", &link).unwrap();
    let pty = Pty::open(Some(&link)).unwrap();
    assert_eq!(fs::read_link(&link).unwrap(), pty.path());
    drop(pty);
    assert!(fs::symlink_metadata(&link).is_err());
    symlink("not-there", &link).unwrap();
    drop(Pty::open(Some(&link)).unwrap());
    fs::write(&link, "mine").unwrap();
    let refused = Pty::open(Some(&link)).err().unwrap().to_string();
    assert!(refused.contains("no symbolic link: choose another --link"), "{refused}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_link_of_a_machine_that_runs_is_its_own() {
    let folder = folder("second");
    let link = folder.join("port");
    let first = Pty::open(Some(&link)).unwrap();
    let refused = Pty::open(Some(&link)).err().unwrap().to_string();
    let reported =
        format!("{} is another's: it points to {}, which is there. ", link.display(), first.path().display());
    assert!(refused.starts_with(&reported), "{refused}");
    assert_eq!(fs::read_link(&link).unwrap(), first.path());
    drop(first);
    Pty::open(Some(&link)).unwrap();
    let mine = folder.join("mine");
    fs::write(&mine, "mine").unwrap();
    symlink(&mine, &link).unwrap();
    assert!(Pty::open(Some(&link)).is_err());
    assert_eq!(fs::read_to_string(&link).unwrap(), "mine");
    fs::remove_dir_all(folder).unwrap();
}
