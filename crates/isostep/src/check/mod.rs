//! `isostep check`: what programs would do on a machine, without moving anything.

mod listings;
mod look;
mod print;

use std::path::PathBuf;

use anyhow::{Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use isostep_console::Settings;
use isostep_report::check::Stand;
use isostep_sim::plate::Plate;
use isostep_sim::{AXES, Config};

use self::look::{Checked, Machine};
use crate::files::{self, Files};
use crate::{parallel, sim};

const HELP: &str = "\
Each program is read as the controller reads it, once parameters, expressions, O-words and M98 have been carried out
(docs/programs.md), and then made in virtual time without its edges. Nothing moves and nothing is written.
Lines that would be refused are left out of extents and times; a program that waits for a person is resumed at once.

Extents are of its moves, from where it begins, or from zero if it homes. It fits if there is a place to begin at from which it
stays within the travel: the middle of the travel, or another that is given; with --start it must stay within it from there.
Times are from the start of the first move to the end of the last, with dwells and spin-ups before and behind, without homing.
Planning takes no time here; where more moves come than the board plans in a second, that is reported.

The exit status is 0 if every line of every program is accepted, each fits, and none ends in an alarm, on every machine.

Examples:
  isostep check my.nc                                      one program on the default machine, in detail
  isostep check my.nc --settings my.txt --start 5,5,20     on yours, from where it stands (isostep sim --help)
  isostep check parts/*.nc                                 many, a line each
  isostep check parts/*.nc --settings a.txt b.txt          how long they take on two machines
  isostep check my.nc --probe-plate Z,12.5,below           G38 finds a plate 12.5 mm above the switch of Z
  isostep check --settings grbl.txt --write my.txt         a $$ of Grbl, grblHAL or FluidNC, line by line: docs/from-grbl.md
  isostep check my.nc --all --json my.json                 more refused lines; every figure";

/// Say what would become of programs: refused lines, extents, times and what limits them; nothing moves
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// G-code programs
    #[arg(value_name = "FILE", required_unless_present = "settings")]
    programs: Vec<PathBuf>,
    /// Settings of machines: $n=v lines, a file for each [default: the parking gantry]. Without a program: what becomes of each line
    #[arg(long, value_name = "FILE", num_args = 1..)]
    settings: Vec<PathBuf>,
    /// Places of the carriages at first, in mm from their switches [default: where the program fits]
    #[arg(long, value_name = sim::PLACES, value_parser = sim::places, allow_hyphen_values = true)]
    start: Option<[f64; AXES]>,
    /// A plate that the probe touches, such as Z,12.5,below (isostep sim --help)
    #[arg(long, value_name = "AXIS,MM,SIDE", allow_hyphen_values = true)]
    probe_plate: Option<Plate>,
    /// Tell up to 1,000 refused lines, not the first ten; of one program
    #[arg(long)]
    all: bool,
    /// Programs that are looked at at a time
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..))]
    jobs: u8,
    /// Write every figure as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// Without a program: write the settings as they are taken
    #[arg(long, value_name = "OUT.txt", conflicts_with_all = ["programs", "json", "all", "start", "probe_plate"])]
    write: Option<PathBuf>,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    if args.programs.is_empty() {
        return listings::run(&args.settings, args.write.as_ref());
    }
    ensure!(
        !args.all || args.programs.len() == 1,
        "--all lists the refused lines of one program: name one, or leave it out"
    );
    let files = Files::default().read("FILE", &args.programs).read("--settings", &args.settings);
    files.written("--json", &args.json).check()?;
    let machines = machines(&args)?;
    let stand = Stand { start_mm: args.start, plate: args.probe_plate };
    let bar = bar();
    let checked: Vec<Checked> =
        parallel::map(&args.programs, args.jobs.into(), |path| look::check(path, &machines, stand, &bar));
    bar.finish_and_clear();
    match &checked[..] {
        [one] => print!("{}", print::detail(one, args.all)),
        _ => print!("{}", print::table(&checked, &machines)),
    }
    if let Some(path) = &args.json {
        files::write_by(path, |out| Ok(serde_json::to_writer_pretty(out, &checked)?))?;
    }
    let bad: Vec<_> = checked.iter().filter(|one| !one.is_good()).collect();
    ensure!(bad.is_empty(), "{}", verdict(bad.len(), checked.len()));
    Ok(())
}

/// Progress of all programs. It is drawn on a terminal only.
fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("  {bar:20} {human_pos} of {human_len} lines, {eta} left");
    ProgressBar::new(0).with_style(style.expect("a template of ours"))
}

fn verdict(bad: usize, of: usize) -> String {
    match of {
        1 => "it would not run as it is".to_owned(),
        _ => format!("{bad} of {of} programs would not run as they are"),
    }
}

fn machines(args: &Args) -> Result<Vec<Machine>> {
    if args.settings.is_empty() {
        return Ok(vec![Machine { name: "the default machine".to_owned(), settings: Settings::DEFAULT }]);
    }
    let read = args.settings.iter().map(|path| {
        let stem =
            path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned());
        Ok(Machine { name: stem, settings: sim::read_settings(path, &Config::default())? })
    });
    read.collect()
}

#[cfg(test)]
mod tests;
