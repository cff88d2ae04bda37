//! `isostep console`: a terminal for a board, or for anything else that speaks Grbl's dialect.
//!
//! ```text
//! port (board, or pseudo-terminal) -- reader thread --+
//!                                                     +-- Session: counts bytes, polls the status
//! prompt thread, where a person types ----------------+      |
//!                                             interactive, piped or stream: what is sent next
//! ```

mod interactive;
mod meaning;
mod piped;
pub mod port;
mod prompt;
mod session;
mod status;
mod stream;
mod talk;
#[cfg(all(test, unix))]
mod tests;
mod tool_wait;

pub use meaning::explained;
pub use status::Status;

use std::io::{self, IsTerminal};
use std::path::PathBuf;

use anyhow::Result;

use self::session::Session;
use self::stream::How;
use self::talk::Typist;
use crate::name::as_called;

/// Talk to the board, or stream a program to it
#[derive(clap::Args)]
#[command(after_help = "\
Lines go to the machine as they are; what it says is printed, errors and alarms with their meaning. While you type, these
act at once: Ctrl-X resets; on an empty line ! holds, ~ resumes, ? reports. Arrow keys bring back earlier lines; Ctrl-D ends.

Examples:
  isostep console                                   the board: the one USB device 2e8a:000a or 2e8a:0009
  isostep console --list                            what ports there are
  isostep console /dev/ttyACM0                      this port
  isostep console COM5 --stream programs/square.nc  a whole program, with its progress; Ctrl-C ends it
  isostep console /tmp/isostep                      the machine of `isostep sim --pty --link /tmp/isostep`
  echo '$$' | isostep console                       each line of stdin sent and answered
  printf '$H\\nG0 X10\\n' | isostep console           exit code 1 if an error or an alarm came

A line of stdin that is ! or ~ or ? alone acts at once there too. Where the machine waits for somebody (M0, M6, a hold), the
console says so, for M6 with the tool and the program's comment about it, and ~ goes on; also while a program is streamed. While the
machine waits in the state Tool ($341), typed lines are by hand: jogs, $TPW, G10 L20. A ~ in a pipe waits until the machine does. Without a
terminal, and with --stream, it ends once the machine is at rest.

Parameters, expressions, O-words and M98 of a streamed program are carried out here, all of them before the first line is sent
(docs/programs.md). When a line of it is refused, the machine is held, and the lines behind it that it already has are listed. At a
terminal you are asked whether to go on; otherwise it is reset, and the exit code is 1. --keep-going asks nothing.")]
pub struct Args {
    /// The port: a device, or what it is called on Windows [default: the board on USB]
    #[arg(value_name = "PORT")]
    port: Option<String>,
    /// Stream this program, and end
    #[arg(long, value_name = "FILE.nc")]
    stream: Option<PathBuf>,
    /// With --stream: pass over refused lines, as most senders do; without it the machine holds at the first
    #[arg(long, requires = "stream")]
    keep_going: bool,
    /// Bits a second; a USB port has its own
    #[arg(long, value_name = "N", default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    baud: u32,
    /// List the ports, and end
    #[arg(long, exclusive = true)]
    list: bool,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    if args.list {
        print!("{}", as_called(&port::listed(&port::all()?)));
        return Ok(());
    }
    let program = args.stream.as_deref().map(stream::Program::read).transpose()?;
    let name = args.port.map_or_else(port::find_board, Ok)?;
    let mut session = Session::open(&name, args.baud)?;
    for line in session.greet()? {
        println!("{}", meaning::explained(&line));
    }
    let (input, show) = (io::BufReader::new(io::stdin()), |line: &str| println!("{line}"));
    let is_person = io::stdin().is_terminal() && io::stdout().is_terminal();
    match program {
        Some(program) => {
            let may_read = !io::stdin().is_terminal() || is_in_foreground();
            let typist = if is_person && may_read { Typist::Person } else { Typist::Pipe };
            let how = How { typist, keep_going: args.keep_going };
            let input: Box<dyn io::BufRead + Send> = if may_read { Box::new(input) } else { Box::new(io::empty()) };
            stream::run(&mut session, &program, how, input, show)
        }
        None if is_person => interactive::run(session, &name),
        None => piped::run(&mut session, input, show),
    }
}

/// The terminal's input is ours. A job in the background that reads from it would be stopped, in the middle of a
/// cut.
#[cfg(unix)]
fn is_in_foreground() -> bool {
    rustix::termios::tcgetpgrp(io::stdin()).is_ok_and(|foreground| foreground == rustix::process::getpgrp())
}

#[cfg(not(unix))]
fn is_in_foreground() -> bool {
    true
}
