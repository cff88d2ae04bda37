//! The console at a simulated machine, as processes: Ctrl-C while a program is streamed, what it does, and what is said
//! then; a pipe that resumes a machine that waits.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// A process that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn verb(arguments: &[&str]) -> Command {
    let mut verb = Command::new(env!("CARGO_BIN_EXE_isostep"));
    verb.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    verb
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Streams `program` to a machine. Presses Ctrl-C whenever a line with one of `words` is printed. Returns the status and
/// what was printed, errors included.
fn interrupted(name: &str, program: &str, words: &[&str]) -> (Option<i32>, String) {
    let folder = std::env::temp_dir().join(format!("isostep-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    std::fs::write(path("a.nc"), program).unwrap();
    let mut machine = Running(verb(&["sim", "--pty", "--link", &path("port")]).spawn().unwrap());
    let mut first = String::new();
    BufReader::new(machine.0.stdout.take().unwrap()).read_line(&mut first).unwrap();
    let mut console = Running(verb(&["console", &path("port"), "--stream", &path("a.nc")]).spawn().unwrap());
    let mut printed = String::new();
    for line in BufReader::new(console.0.stdout.take().unwrap()).lines() {
        let line = line.unwrap();
        if words.iter().any(|words| line.contains(words)) {
            interrupt(&console.0);
        }
        printed += &format!("{line}\n");
    }
    printed += &std::io::read_to_string(console.0.stderr.take().unwrap()).unwrap();
    let code = console.0.wait().unwrap().code();
    std::fs::remove_dir_all(folder).unwrap();
    (code, printed)
}

#[test]
fn two_at_m0_reset_a_machine_whose_position_is_kept() {
    let both = ["the machine waits (Hold:0) at", "no further line is sent"];
    let (code, printed) = interrupted("m0", "G0 X5\nM0\nG0 X6\n", &both);
    assert_eq!(code, Some(1), "{printed}");
    assert!(printed.contains("~ resumes what was sent; Ctrl-C again resets"), "{printed}");
    let expected = "error: reset by Ctrl-C after line 3 of 3: it stands still with its outputs off, and its position is \
                    kept: Idle   X    5.000 Y    0.000 Z    0.000\n";
    assert!(printed.ends_with(expected), "{printed}");
    assert!(!printed.contains("not trusted"), "{printed}");
}

/// `printf 'M0\n~\n' | isostep console PORT`. A console that does not send the `~` waits as long as the machine.
#[test]
fn a_pipe_resumes_the_machine_where_it_waits() {
    let link = std::env::temp_dir().join(format!("isostep-pipe-{}", std::process::id()));
    let port = link.to_str().unwrap();
    let mut machine = Running(verb(&["sim", "--pty", "--link", port]).spawn().unwrap());
    BufReader::new(machine.0.stdout.take().unwrap()).read_line(&mut String::new()).unwrap();
    for typed in ["M0\n~\n", "M6 T1\n~\n"] {
        let mut console = Running(verb(&["console", port]).stdin(Stdio::piped()).spawn().unwrap());
        console.0.stdin.take().unwrap().write_all(typed.as_bytes()).unwrap();
        let (mut stdout, (printed, heard)) = (console.0.stdout.take().unwrap(), mpsc::channel());
        thread::spawn(move || printed.send(std::io::read_to_string(&mut stdout).unwrap()));
        let printed = heard.recv_timeout(Duration::from_secs(20));
        assert!(printed.as_ref().is_ok_and(|printed| printed.ends_with("ok\n")), "{typed:?}: {printed:?}");
        assert!(console.0.wait().unwrap().success(), "{typed:?}");
    }
}
