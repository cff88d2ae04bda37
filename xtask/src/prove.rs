//! `cargo xtask prove`: builds the proving image and the usual one, and runs the tool's verb with them; or runs it on the
//! emulated board.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use isostep::chip::Chip;
use isostep::prove::{self, Args};

use crate::build;
use crate::process::announce;
use crate::variant::{Board, Port, Variant};

/// The names under which both images are kept.
const PROVING: &str = "prove";
const USUAL: &str = "usual";

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    if !args.compare.is_empty() {
        return prove::run(args);
    }
    if args.emulated {
        return emulated::run(&args);
    }
    // An image says for which board it is.
    let board_of = args.image.as_deref().map(Chip::of_image).transpose()?;
    let args = Args { board: board_of.unwrap_or(args.board), ..args };
    // Both images take minutes.
    isostep::boot_loader::find(args.port.as_deref(), args.board)?;
    let usual = Variant { board: board(&args), ..Variant::default() };
    let restore = args.restore.clone().map_or_else(|| kept(usual, USUAL), Ok)?;
    let image = args.image.clone().map_or_else(|| kept(proving(&args), PROVING), Ok)?;
    announce("the image for afterwards has the default drivers and contacts: name another with --restore");
    prove::run(Args { image: Some(image), restore: Some(restore), ..args })
}

/// The board that has this chip and the pins of a Pico.
fn board(args: &Args) -> Board {
    match args.board {
        Chip::Rp2040 => Board::Pico,
        Chip::Rp2350 => Board::Pico2,
    }
}

/// The image that measures it.
fn proving(args: &Args) -> Variant {
    Variant::proving(board(args), Port::Pio)
}

/// Builds a variant and keeps its UF2 file under this name: each build overwrites the one before.
fn kept(variant: Variant, name: &str) -> Result<PathBuf> {
    let kept = build::kept_firmware(variant, name)?.with_extension("uf2");
    let built = variant.uf2();
    fs::copy(&built, &kept).with_context(|| format!("cannot copy {} to {}", built.display(), kept.display()))?;
    Ok(kept)
}

#[cfg(unix)]
mod emulated {
    use std::path::Path;
    use std::process::Command;

    use anyhow::Result;
    use isostep::prove::{self, Args, How, Jumper, Part, Progress, Proof, Virtual};
    use isostep::pty::{Emulated, Machine};

    use super::{PROVING, board, proving};
    use crate::{build, node, workspace};

    /// Proves the emulated board. With --image it has this ELF file, otherwise one that is built. Without --jumper it is
    /// measured with each wire too, one after the other.
    pub fn run(args: &Args) -> Result<()> {
        node::prepare()?;
        let elf = match &args.image {
            Some(elf) => elf.clone(),
            None => build::kept_firmware(proving(args), PROVING)?,
        };
        let mut proof = on_board(&elf, args, &args.how())?;
        let has_stops = args.only.is_empty() || args.only.contains(&Part::Stops);
        for jumper in Jumper::ALL.into_iter().filter(|_| args.jumper.is_empty() && has_stops) {
            let how = How { jumpers: vec![jumper], only: vec![Part::Stops], ..args.how() };
            proof.found.fill(on_board(&elf, args, &how)?.found);
        }
        prove::conclude(&Proof { is_emulated: true, ..proof }, args.quick, &args.out)
    }

    /// Proves a board at power-up, with a wire to each of the jumpers.
    fn on_board(elf: &Path, args: &Args, how: &How) -> Result<Proof> {
        let mut command = Command::new("node");
        command.arg(workspace::emulator_dir().join("run.mjs")).arg("--elf").arg(elf);
        // Beside an image that keeps ENABLE off the emulated drivers would make no step.
        command.args(["--driver", "tmc2209", "--enable", "open"]);
        // A carriage that moves beyond its switch presses it.
        command.args(["--start", "900,900,900"]);
        command.args(["--board", board(args).name()]);
        command.args(args.miss_factor.map(|factor| format!("--miss-factor={factor}")));
        command.args(how.jumpers.iter().flat_map(|jumper| ["--jumper".to_owned(), format!("28:{}", jumper.pad())]));
        let mut board = Emulated::start(&mut command, true, &[])?;
        board.set_open(true)?;
        let proof = {
            let mut link = Virtual::new(&mut board);
            prove::on(&mut link, how, &prove::interrupt()?, &Progress::begin())?
        };
        board.close()?;
        Ok(proof)
    }
}

#[cfg(not(unix))]
mod emulated {
    use anyhow::{Result, bail};

    pub fn run(_args: &isostep::prove::Args) -> Result<()> {
        bail!("Windows cannot run the emulated board by pipes: use --emulated in WSL")
    }
}
