//! Programs in virtual time, for their times alone.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use isostep_console::Settings;
use isostep_sim::{Config, ConsoleError, Outcome, State};

use crate::stopwatch::Stopwatch;

/// A program on a machine.
pub struct Job {
    /// Index of the table's column.
    pub column: usize,
    /// The program's.
    pub name: String,
    /// The column's.
    pub label: String,
    pub program: Vec<u8>,
    pub settings: Settings,
    pub grbl_s: f64,
}

/// What came of it.
pub struct Timed {
    pub column: usize,
    pub program: String,
    pub grbl_s: f64,
    /// How long it takes, s; or why it did not come to its end.
    pub isostep_s: Result<f64, String>,
}

/// Runs all of them, several at a time, and tells of each that has ended. In the order of the jobs.
pub fn all(jobs: &[Job], at_a_time: usize) -> Vec<Timed> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..at_a_time.min(jobs.len()) {
            scope.spawn(|| {
                while let Some((index, job)) = take(jobs, &next) {
                    let timed = one(job, jobs.len());
                    done.lock().expect("no run panics while it holds this").push((index, timed));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no run panics while it holds this");
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, timed)| timed).collect()
}

fn take<'j>(jobs: &'j [Job], next: &AtomicUsize) -> Option<(usize, &'j Job)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(index).map(|job| (index, job))
}

fn one(job: &Job, of: usize) -> Timed {
    let stopwatch = Stopwatch::start();
    let isostep_s = seconds(&job.program, job.settings);
    let told = isostep_s.as_ref().map_or_else(Clone::clone, |s| format!("{s:.3} s, {:.3} of Grbl's", s / job.grbl_s));
    eprintln!("    {} of {of} on {}: {told} ({:.1} s)", job.name, job.label, stopwatch.elapsed_s());
    Timed { column: job.column, program: job.name.clone(), grbl_s: job.grbl_s, isostep_s }
}

/// How long `program` takes on the machine of these settings, s.
pub fn seconds(program: &[u8], settings: Settings) -> Result<f64, String> {
    let config =
        Config { settings, start_mm: middle_mm(&settings), only_time: true, keep_record: false, ..Config::default() };
    let outcome = isostep_sim::run(program, &config).map_err(|error| error.to_string())?;
    ended_well(&outcome)?;
    Ok(outcome.motion_s)
}

/// Nothing moves there, so a switch is never met.
fn middle_mm(settings: &Settings) -> [f64; 3] {
    settings.travel_mm.map(|travel_mm| f64::from(travel_mm) / 2.0)
}

fn ended_well(outcome: &Outcome) -> Result<(), String> {
    if let State::Alarm(alarm) = outcome.state {
        return Err(format!("ended in alarm: {alarm}"));
    }
    let Some(refusal) = outcome.refusals.first() else { return Ok(()) };
    let words = ConsoleError::from_code(refusal.code).map_or(String::new(), |error| error.to_string());
    Err(format!("line {} `{}` was refused: error:{} {words}", refusal.line, refusal.text, refusal.code))
}
