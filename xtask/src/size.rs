//! `cargo xtask size`: compares the firmware's flash and RAM with their budgets, and its code in RAM with what runs.

use anyhow::Result;

use crate::footprint::Footprint;
use crate::variant::{Board, Variant};
use crate::{build, hot};

/// Compare the firmware's flash and RAM with their budgets, and its code in RAM with what runs in motion
#[derive(clap::Args)]
#[command(after_help = "\
Flash is everything stored: boot loader, code, constants and initial values.
RAM is the code that runs from it with its tables (.hot: all that has a deadline), every static (.data, .bss, .uninit), and
what is reserved for the stack.
Then two programs run on the emulated board, and a second table shows how much of the code in RAM ran while the machine moved:
functions, and their instructions. What did not run may have a deadline all the same, or belong to another speed profile.
Exits with an error when a figure is over its budget.")]
pub struct Args {
    /// The board
    #[arg(long, value_enum, default_value_t)]
    board: Board,
}

pub fn run(Args { board }: Args) -> Result<()> {
    let variant = Variant { board, ..Variant::default() };
    let footprint = Footprint::new(&build::firmware(variant)?, variant);
    print!("{}", footprint.table());
    footprint.check()?;
    print!("\n{}", hot::table(variant)?);
    Ok(())
}
