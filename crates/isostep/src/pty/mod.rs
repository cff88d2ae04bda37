//! A machine behind a pseudo-terminal, paced to the wall clock. Any sender of G-code can open it as if it were a board.
//! `sim` and `emulate` share these options.
//!
//! ```text
//! sender -- /dev/pts/N -- port -- bridge -- Machine: simulated, or emulated in a Node process
//!                                   |
//!                       pace (wall clock), flight (unanswered bytes), ending (Ctrl-C)
//! ```

#[cfg(unix)]
mod bridge;
#[cfg(unix)]
mod emulated;
#[cfg(unix)]
mod ending;
#[cfg(unix)]
mod machine;
#[cfg(unix)]
mod pace;
#[cfg(unix)]
mod port;
#[cfg(unix)]
mod presence;
#[cfg(unix)]
mod serving;
#[cfg(unix)]
pub mod simulated;
#[cfg(unix)]
mod summary;
#[cfg(all(test, unix))]
pub mod tests;

use std::path::PathBuf;

use anyhow::{Result, bail};

#[cfg(unix)]
pub use bridge::{Drive, Tally};
#[cfg(unix)]
pub use emulated::Emulated;
#[cfg(unix)]
pub use ending::Ending;
#[cfg(unix)]
pub use machine::{Closing, Machine};
#[cfg(unix)]
pub use port::Pty;
#[cfg(unix)]
pub use serving::while_running;

/// The options of a machine on a pseudo-terminal.
#[derive(clap::Args, Debug)]
pub struct Live {
    /// Run in real time behind a pseudo-terminal, for any sender, until Ctrl-C
    #[arg(long)]
    pub pty: bool,
    /// With --pty: a symbolic link to the pseudo-terminal, removed at the end
    #[arg(long, value_name = "PATH")]
    pub link: Option<PathBuf>,
    /// With --pty: end after N seconds of machine time
    #[arg(long, value_name = "N", value_parser = seconds)]
    for_s: Option<f64>,
    /// With --pty: seconds of the machine in a second [default: 1]
    #[arg(long, value_name = "N", value_parser = speed)]
    speed: Option<f64>,
}

impl Live {
    /// Refuses these options without --pty. clap's `requires` is not used, because it says nothing where a program is
    /// named, since a program excludes --pty.
    ///
    /// # Errors
    /// When an option of a pseudo-terminal is given without --pty.
    pub fn check(&self) -> Result<()> {
        let given =
            [("--link", self.link.is_some()), ("--for-s", self.for_s.is_some()), ("--speed", self.speed.is_some())];
        let Some((option, _)) = given.iter().find(|(_, is_given)| *is_given && !self.pty) else { return Ok(()) };
        bail!(
            "{option} goes with --pty, a machine in real time that a sender feeds: add --pty and leave the program out, or leave \
             {option} out, as a program runs without a port and as fast as it can"
        )
    }
}

/// The part of the help of `sim` and `emulate` about the pseudo-terminal.
pub const HELP: &str = "\
With --pty any sender can use the machine as if it were a board. The first line printed is its port; senders that list
ports do not find it, so give them the path, or one of your choice by --link:
  isostep sim --pty --link /tmp/isostep
  isostep console /tmp/isostep                                  a terminal
  python3 -m serial.tools.miniterm --eol LF /tmp/isostep 115200     another
  python3 -c \"p = open('/tmp/isostep', 'r+b', 0); p.write(b'$$\\n'); print(*iter(p.readline, b'ok\\r\\n'))\"
  python3 -m bCNC -s /tmp/isostep -b 115200                         bCNC
  cncjs     in ~/.cncrc: { \"ports\": [{ \"path\": \"/tmp/isostep\" }] }; then this port, Grbl, 115200
  UGS       Grbl, 115200, the path typed into the port's box
On the command line of this verb: Ctrl-C ends it, and it says what the machine and the sender did.";

#[cfg(unix)]
pub use run::{open, serve};

#[cfg(unix)]
mod run {
    use anyhow::{Result, ensure};

    use super::{Drive, Ending, Live, Machine, Pty, bridge, summary};
    use crate::name::as_called;
    use crate::screen;

    /// Opens the pseudo-terminal and prints its path.
    pub fn open(args: &Live) -> Result<Pty> {
        let pty = Pty::open(args.link.as_deref())?;
        println!("console: {}", pty.path().display());
        print!("{}", as_called(&summary::hints(args.link.as_deref().unwrap_or(pty.path()))));
        // If the path cannot be printed, nobody can use the port.
        screen::finish()?;
        Ok(pty)
    }

    /// Runs the machine on the pseudo-terminal until it ends, and prints a summary.
    pub fn serve(args: &Live, mut pty: Pty, machine: &mut impl Machine) -> Result<()> {
        let end_ns = args.for_s.map_or(u64::MAX, |for_s| (for_s * 1e9) as u64);
        let drive = Drive { speed: args.speed.unwrap_or(1.0), end_ns };
        let tally = bridge::run(machine, &mut pty, drive, &Ending::by_signal()?)?;
        let duration_ns = machine.now_ns();
        let closing = machine.close()?;
        print!("{}", summary::text(duration_ns, &tally, &closing));
        ensure!(closing.timing_violations == 0, "{} edges broke the driver's timing", closing.timing_violations);
        Ok(())
    }
}

/// Refuses --pty on a system without pseudo-terminals.
#[cfg(not(unix))]
pub fn refuse() -> anyhow::Result<()> {
    anyhow::bail!("Windows has no pseudo-terminals: use --pty in WSL, or run a program with `isostep sim FILE.nc`")
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, 0.001, 1e6)
}

fn speed(text: &str) -> Result<f64, String> {
    number(text, 0.01, 1000.0)
}

fn number(text: &str, min: f64, max: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (min..=max).contains(number));
    number.ok_or_else(|| format!("a number from {min} to {max}"))
}
