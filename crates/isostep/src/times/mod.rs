//! `isostep times`: how long programs take, compared with a table of Grbl's times.

mod feed;
mod print;
mod ratios;
mod simulate;
mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use isostep_console::Settings;
use isostep_sim::Config;
use isostep_sim::program::Program;

use self::ratios::{Bounds, Report};
use self::simulate::Job;
use self::table::Table;
use crate::files::{self, Files};
use crate::{project, sim};

const HELP: &str = "\
TABLE.csv has a row for each program: its file's name in FOLDER in the column `program`, and Grbl's time in a column for each
machine: `A_s`, s, at the program's own feeds, and `A_max_feed_s` with F12000 for every F. Other columns are passed over, and so
are empty fields. The machine A is what programs/machines/a.txt sets, or the FILE of --machine A=FILE: $n=v lines, as senders
save them (`isostep sim --help`). What a machine's settings say of speed profiles and limits holds.

A time is from the start of the first move to the end of the last one's plan, pauses between moves included. The controller is
the firmware's, in virtual time: it plans in no time, and its console's wire takes none, so a program is sent as fast as moves
are taken, within Grbl's 128 unanswered bytes. No edge is made, so none is checked: `isostep sim --settings FILE` does that.
A corner's jump is the most by which the speed of an axis jumps where a move follows another, as planned.

exact       corners are taken exactly, as Grbl does, by $11. The bounds are for this column
one by one  corners are blends, $904 set by --blends, with each move by itself (Q0 in every G64)
blends      the same with short moves taken together, as they are without a word
fastest     the shortest time on the path of `one by one`: computed, with all moves known, no least time of a move, and speed that
            changes within blends as the axes allow. Standstills and probing take as long as they do, and a shaper is as long
            as it is at each stop. There is none (-) with a curved speed profile, in thirds ($900=1) or with a start speed.
            Moves taken together may be faster still: their path is another, within P
together    how many of the program's moves were taken together with others
beside      the farthest that a line made of several is from where one of them was to end
A program's own G61, G64 P and G61.1 hold in all of them, and its Q in `blends`.

The exit status is 0 if every ratio of the times is at most EACH, and their median, in each column and over all, at most MEDIAN.

Examples:
  isostep times programs grbl.csv                            what grbl.csv names of programs/
  isostep times parts grbl.csv --machine MILL=mill.txt       its columns MILL_s and MILL_max_feed_s too
  isostep times parts grbl.csv --only lid.nc --json t.json   one program; every figure as JSON
  isostep times parts grbl.csv --median 1 --each 1           nothing may take longer than with Grbl";

/// Time programs on simulated machines, beside Grbl's times for them
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// The folder of the programs
    folder: PathBuf,
    /// Grbl's times: see below
    #[arg(value_name = "TABLE.csv")]
    table: PathBuf,
    /// A machine of the table's columns, and its settings [default: programs/machines/NAME.txt, in small letters]
    #[arg(long, value_name = "NAME=FILE", value_parser = machine)]
    machine: Vec<(String, PathBuf)>,
    /// Of the table's programs, only this one; may be given again
    #[arg(long, value_name = "PROGRAM")]
    only: Vec<String>,
    /// The most that the median of the ratios may be, in each column and over all
    #[arg(long, value_name = "RATIO", default_value_t = 1.02)]
    median: f64,
    /// The most that each ratio may be
    #[arg(long, value_name = "RATIO", default_value_t = 1.05)]
    each: f64,
    /// Distance by which blends may leave a corner, mm
    #[arg(long, value_name = "MM", default_value_t = 0.01)]
    blends: f32,
    /// Programs that are simulated at a time
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..))]
    jobs: u8,
    /// Write every figure as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    let report = report(&args)?;
    print!("{}", print::text(&report));
    if let Some(path) = &args.json {
        files::write_by(path, |out| Ok(serde_json::to_writer_pretty(out, &report)?))?;
    }
    let broken = report.broken();
    ensure!(broken.is_empty(), "{}", broken.join("; "));
    Ok(())
}

fn report(args: &Args) -> Result<Report> {
    let table = Table::read(&args.table)?.only(&args.only)?;
    files(args, &table).check()?;
    let machines = table.machines().into_iter().map(|name| Ok((name.clone(), machine_settings(&name, &args.machine)?)));
    let machines: Vec<(String, Settings)> = machines.collect::<Result<_>>()?;
    unused(&args.machine, &machines)?;
    let jobs = jobs(args, &table, &machines)?;
    let made = simulate::all(&jobs, args.jobs.into());
    let timed = jobs.into_iter().zip(made).collect();
    Ok(Report::new(&table, machines, timed, Bounds { median: args.median, each: args.each }))
}

/// The files that are read and written.
fn files(args: &Args, table: &Table) -> Files {
    let programs: Vec<PathBuf> = table.rows.iter().map(|row| args.folder.join(&row.program)).collect();
    Files::default()
        .read("TABLE.csv", [&args.table])
        .read("the program", &programs)
        .read("--machine", args.machine.iter().map(|(_, path)| path))
        .written("--json", &args.json)
}

/// One run for each time in the table, column by column.
fn jobs(args: &Args, table: &Table, machines: &[(String, Settings)]) -> Result<Vec<Job>> {
    let programs: Vec<Result<Program, String>> =
        table.rows.iter().map(|row| program(&args.folder.join(&row.program))).collect::<Result<_>>()?;
    let mut jobs = Vec::new();
    for (index, column) in table.columns.iter().enumerate() {
        let (_, settings) =
            machines.iter().find(|(name, _)| *name == column.machine).context("a machine has settings")?;
        for (row, program) in table.rows.iter().zip(&programs) {
            let Some(grbl_s) = row.grbl_s[index] else { continue };
            let program = program.clone().map(|lines| if column.is_max_feed { at_max_feed(&lines) } else { lines });
            jobs.push(Job {
                column: index,
                name: row.program.clone(),
                label: column.name.clone(),
                program,
                settings: *settings,
                blend_mm: args.blends,
                grbl_s,
            });
        }
    }
    Ok(jobs)
}

/// The lines that are sent of a file, or why there are none.
fn program(path: &Path) -> Result<Result<Program, String>> {
    Ok(Program::read(&sim::read(path)?).map_err(|error| error.to_string()))
}

fn at_max_feed(program: &Program) -> Program {
    program.with_lines(program.iter().map(|line| feed::at_max(line)).collect())
}

fn machine_settings(name: &str, given: &[(String, PathBuf)]) -> Result<Settings> {
    let own = project::file(&format!("programs/machines/{}.txt", name.to_lowercase()));
    let path = given.iter().find(|(given, _)| given == name).map_or(&own, |(_, path)| path);
    sim::read_settings(path, &Config::default())
        .with_context(|| format!("machine {name}: name its file of settings with --machine {name}=FILE"))
}

/// Refuses a machine that no column uses: its name is probably misspelt.
fn unused(given: &[(String, PathBuf)], machines: &[(String, Settings)]) -> Result<()> {
    let Some((name, _)) = given.iter().find(|(name, _)| machines.iter().all(|(used, _)| used != name)) else {
        return Ok(());
    };
    let used: Vec<_> = machines.iter().map(|(name, _)| name.as_str()).collect();
    bail!(
        "--machine {name}: the table has no column {name}_s or {name}_max_feed_s; its machines are {}",
        used.join(", ")
    )
}

fn machine(text: &str) -> Result<(String, PathBuf), String> {
    let (name, file) = text.split_once('=').ok_or("a machine and its file of settings, such as A=a.txt")?;
    Ok((name.to_owned(), file.into()))
}

#[cfg(test)]
mod tests;
