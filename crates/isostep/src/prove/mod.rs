//! `isostep prove`: measures on a board what the project says of it, without an oscilloscope.
//!
//! ```text
//! serial port, or a machine in virtual time -- link -- session: a line of the proving image, and its replies
//!                                                        |
//!     stamps, judge: which step, how far off -- stamped: a board for the measurements of `measure`, and for `parts`
//!                                                        |
//!                                                proof: figures, errors, faults -- tables, page
//! ```

mod how;
mod judge;
mod link;
mod page;
mod parts;
mod progress;
mod proof;
mod session;
mod stamped;
mod stamps;
mod tables;
#[cfg(test)]
mod tests;

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, ensure};

pub use self::how::{Effort, How, Jumper, Part};
#[cfg(unix)]
pub use self::link::Virtual;
pub use self::link::{Link, Serial};
pub use self::progress::Progress;
pub use self::proof::Proof;
pub use self::stamps::Stamps;

use self::session::Session;
use self::stamped::Stamped;
use crate::boot_loader;
use crate::chip::Chip;
use crate::console::port;
use crate::files::{self, Files};
use crate::name::as_called;
use crate::project;

/// The figures of the emulated board with a chip by the same verb, which `cargo xtask prove --emulated --laser --board ...` writes.
const fn emulated_figures(chip: Chip) -> &'static str {
    match chip {
        Chip::Rp2040 => include_str!("emulated.json"),
        Chip::Rp2350 => include_str!("emulated-rp2350.json"),
    }
}

/// Measure this very board: every figure beside the emulated one
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = "\
The board runs the proving image: the gantry's firmware, which stamps its own edges to two cycles of its clock (to one in pairs:
8 ns, of an RP2350 6.7 ns), never enables its motors, and keeps settings of its own. Nothing needs to be wired; unplug drivers that move without their ENABLE. A wire
from GP28 to GP9 (X's limit switch) or GP12 (the emergency stop) adds how soon a move stops.

It writes proof.json, a page (index.html) and a letter (proof.txt) that can be sent to the project, and prints each figure,
emulated and measured, with a verdict. The exit code is 1 if a promise is broken.

Examples:
  isostep prove                                  a board that has the proving image
  isostep prove --quick                          in less time: a part of the edges
  isostep prove --jumper limit                   with a wire from GP28 to GP9
  isostep prove --image rp2040-prove.uf2 --restore pico-gantry.uf2      puts the image on it first, and the other one back
  isostep prove --compare a/proof.json b/proof.json

With the sources `cargo xtask prove` builds both images and puts them on the board.")]
pub struct Args {
    /// The port [default: the board on USB]
    #[arg(long, value_name = "PORT")]
    pub port: Option<String>,
    /// Put this image on the board first
    #[arg(long, value_name = "UF2")]
    pub image: Option<PathBuf>,
    /// Offer to put this image on the board at the end
    #[arg(long, value_name = "UF2")]
    pub restore: Option<PathBuf>,
    /// A wire from GP28 goes to this input; may be given again
    #[arg(long, value_enum, value_name = "INPUT")]
    pub jumper: Vec<Jumper>,
    /// Look at a part of the edges only
    #[arg(long)]
    pub quick: bool,
    /// Make this measurement only; may be given again
    #[arg(long, value_enum, value_name = "WHAT")]
    pub only: Vec<Part>,
    /// Switch the laser's pin on too: nothing may be connected to it
    #[arg(long)]
    pub laser: bool,
    /// The folder that the proof is written into
    #[arg(long, value_name = "FOLDER", default_value = "proof")]
    pub out: PathBuf,
    /// Answer no question: put the image of --restore on the board without asking
    #[arg(long)]
    pub yes: bool,
    /// The board that the images are built for (of `cargo xtask prove` only)
    #[arg(long, value_enum, default_value_t)]
    pub board: Chip,
    /// Prove the emulated board instead (of `cargo xtask prove` only)
    #[arg(long, conflicts_with_all = ["port", "restore", "yes"])]
    pub emulated: bool,
    /// On the emulated board a word that is not in flash's cache costs so many times the reckoned cycles
    #[arg(long, value_name = "N", requires = "emulated")]
    pub miss_factor: Option<f64>,
    /// Compare two proofs, and end
    #[arg(long, num_args = 2, value_names = ["A.json", "B.json"], exclusive = true)]
    pub compare: Vec<PathBuf>,
}

impl Args {
    /// The measurements to make.
    pub fn how(&self) -> How {
        let effort = if self.quick { Effort::quick() } else { Effort::full() };
        How { jumpers: self.jumper.clone(), effort, laser: self.laser, only: self.only.clone() }
    }
}

/// Runs the verb.
///
/// # Errors
/// When the board cannot be measured, or a promise is broken.
pub fn run(args: Args) -> Result<()> {
    if let [one, other] = args.compare.as_slice() {
        print!("{}", tables::compared(&Proof::read(one)?, &Proof::read(other)?));
        return Ok(());
    }
    Files::default()
        .page("--out", [&args.out])
        .read("--image", &args.image)
        .read("--restore", &args.restore)
        .check()?;
    let port = match &args.image {
        Some(image) => boot_loader::put(image, args.port.as_deref())?,
        None => args.port.clone().map_or_else(port::find_board, Ok)?,
    };
    let proof = {
        let mut link = Serial::open(&port)?;
        on(&mut link, &args.how(), &interrupt()?, &Progress::begin())?
    };
    let judged = conclude(&proof, args.quick, &args.out);
    if let Some(restore) = &args.restore
        && (args.yes || is_wanted(restore))
    {
        boot_loader::put(restore, Some(&port))?;
    }
    judged
}

/// Makes all measurements on the board at the other end of `link`. If it has the proving image, the machine is reset at
/// the end, whatever happens.
///
/// # Errors
/// When it is not the proving image, or goes away, or `interrupted` is set.
pub fn on(link: &mut dyn Link, how: &How, interrupted: &Arc<AtomicBool>, progress: &Progress) -> Result<Proof> {
    let mut session = Session::new(link, interrupted.clone());
    let mut proof = Proof { version: proof::VERSION, tool: env!("CARGO_PKG_VERSION").to_owned(), ..Proof::default() };
    proof.board = session.greet()?;
    let measured = measured(&mut session, how, &mut proof, progress);
    session.calm();
    measured.map(|()| proof)
}

fn measured(session: &mut Session, how: &How, proof: &mut Proof, progress: &Progress) -> Result<()> {
    let settings = settings(session)?;
    let identity = proof.board.clone();
    let chip = identity.known_chip()?;
    let mut board = Stamped { session: &mut *session, identity, chip, how, progress, faults: Vec::new() };
    let measured = parts::all(&mut board, &mut proof.found);
    put_back(session, &settings);
    measured
}

/// The settings of the machine as lines, as `$$` lists them.
fn settings(session: &mut Session) -> Result<Vec<String>> {
    let said = session.ask("$$")?;
    Ok(said.into_iter().filter(|line| line.starts_with('$') && line.contains('=')).collect())
}

/// Sends settings again. Errors do not count: the image begins with its defaults at every start.
fn put_back(session: &mut Session, settings: &[String]) {
    for line in settings {
        if session.tell(line).is_err() {
            return;
        }
    }
}

/// Writes the proof into `folder`, and prints it.
///
/// # Errors
/// When it cannot be written, or a promise is broken.
pub fn conclude(proof: &Proof, is_quick: bool, folder: &Path) -> Result<()> {
    let proof = Proof { is_quick, ..proof.clone() };
    let emulated = emulated(proof.board.known_chip()?)?;
    print!("{}", tables::shown(&proof, emulated.as_ref()));
    files::write_page(folder, &page::page(&proof, emulated.as_ref()))?;
    files::write(&folder.join("proof.json"), (serde_json::to_string_pretty(&proof)? + "\n").as_bytes())?;
    files::write(&folder.join("proof.txt"), tables::letter(&proof, emulated.as_ref()).as_bytes())?;
    let broken = proof.found.broken();
    ensure!(broken.is_empty(), "{} promises are broken: {}", broken.len(), broken.join("; "));
    Ok(())
}

/// The proof of the emulated board with this chip, once there is one.
fn emulated(chip: Chip) -> Result<Option<Proof>> {
    let figures = emulated_figures(chip);
    if figures.trim() == "null" {
        return Ok(None);
    }
    Proof::parse(figures).with_context(|| format!("the emulated proof of an {} in this tool", chip.name())).map(Some)
}

/// Asks whether the old image is to be put back. Nobody is asked without a terminal.
fn is_wanted(image: &Path) -> bool {
    if !io::stdin().is_terminal() {
        println!("{}", as_called("the board keeps the proving image: with --yes the one of --restore is put on it"));
        return false;
    }
    println!("put {} on the board? [Y/n]", project::shown(image));
    let mut answer = String::new();
    io::stdin().read_line(&mut answer).is_ok() && !answer.trim().to_lowercase().starts_with('n')
}

/// Set by Ctrl-C, from the first time on; the second ends the process at once.
///
/// # Errors
/// When the system does not say so.
pub fn interrupt() -> Result<Arc<AtomicBool>> {
    let interrupted = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    {
        use signal_hook::consts::SIGINT;
        signal_hook::flag::register_conditional_shutdown(SIGINT, 128 + SIGINT, interrupted.clone())?;
        signal_hook::flag::register(SIGINT, interrupted.clone())?;
    }
    Ok(interrupted)
}
