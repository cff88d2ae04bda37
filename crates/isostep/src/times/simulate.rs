//! Runs programs in virtual time, only for their times.

use isostep_console::Settings;
use isostep_report::{again, fastest, timing};
use isostep_sim::program::Program;
use isostep_sim::verify::Together;
use isostep_sim::{Config, Outcome, corners};

use crate::parallel;
use crate::stopwatch::Stopwatch;

/// A program to run on a machine.
pub struct Job {
    /// Index of the table's column.
    pub column: usize,
    /// The program's name.
    pub name: String,
    /// The column's label.
    pub label: String,
    /// Its lines, or why there are none.
    pub program: Result<Program, String>,
    pub settings: Settings,
    /// The distance by which blends may leave the corners, mm.
    pub blend_mm: f32,
    pub grbl_s: f64,
}

/// A run from the program's beginning to its end.
#[derive(Clone, Copy)]
pub struct Made {
    /// Its duration, s.
    pub s: f64,
    /// Its duration if corners are blends and short moves are taken together, as they are without a word, s.
    pub blends_s: f64,
    /// Its duration if corners are blends and each move is made by itself, s.
    pub one_by_one_s: f64,
    /// The shortest duration on that path, s.
    pub fastest_s: Option<f64>,
    /// The moves that were taken together, and the number of all.
    pub together: Together,
    pub moves: usize,
    /// The largest jump of an axis's speed at a corner, without blends.
    pub jump_mm_s: f64,
}

/// Runs all jobs, several at once, and prints a line as each ends. The results are in the order of the jobs: the completed run, or
/// why the program did not reach its end.
pub fn all(jobs: &[Job], at_a_time: usize) -> Vec<Result<Made, String>> {
    parallel::map(jobs, at_a_time, |job| one(job, jobs.len()))
}

fn one(job: &Job, of: usize) -> Result<Made, String> {
    let stopwatch = Stopwatch::start();
    let made = job.program.clone().and_then(|program| make(program, job.settings, job.blend_mm));
    let reported = made.as_ref().map_or_else(Clone::clone, |made| {
        let Made { s, blends_s, .. } = made;
        format!("{s:.3} s, {:.3} of Grbl's, and {blends_s:.3} s with blends", s / job.grbl_s)
    });
    eprintln!("    {} of {of} on {}: {reported} ({:.1} s)", job.name, job.label, stopwatch.elapsed_s());
    made
}

/// Runs `program` on a machine with these settings, with corners by Grbl's rule and with blends.
fn make(program: Program, settings: Settings, blend_mm: f32) -> Result<Made, String> {
    let outcome = run(program.clone(), Settings { blend_deviation_mm: 0.0, ..settings })?;
    let jumps = corners::largest_jumps(&outcome).into_iter().flatten();
    let jump_mm_s = jumps.map(|jump| jump.mm_s).fold(0.0, f64::max);
    let settings = Settings { blend_deviation_mm: blend_mm, ..settings };
    let blended = run(program.clone(), settings)?;
    let together = Together::of_several(&blended);
    let one_by_one_s = match together.moves {
        0 => blended.motion_s,
        _ => run(again::one_by_one(&program, blend_mm), settings)?.motion_s,
    };
    Ok(Made {
        s: outcome.motion_s,
        blends_s: blended.motion_s,
        one_by_one_s,
        fastest_s: fastest::motion_s(&blended),
        together,
        moves: blended.program_moves().map(|record| record.asked.len()).sum(),
        jump_mm_s,
    })
}

fn run(program: Program, settings: Settings) -> Result<Outcome, String> {
    let config = Config { settings, start_mm: timing::middle_mm(&settings), only_time: true, ..Config::default() };
    timing::made(program, &config)
}
