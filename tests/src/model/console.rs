//! The console alone beside the model: each place to which a line leads, in order. That is fast, so lines may be many.

use isostep_console::{Block, Command, CyclePart, Interpreter, ReportedState, Settings, report};
use isostep_motion::AXES;
use oorandom::Rand64;

use crate::axes::xyz_a;

use super::bench::Difference;
use super::machine::{Model, Place};
use super::program::{Author, Room};
use super::settings::SettingValues;
use super::words::{ONE, Word, written};

/// Lines of a random program.
const LINES: usize = 80;
/// The room in which the program is about to be, angstroms.
const ROOM: Room = [(0, 100 * ONE), (0, 100 * ONE), (-20 * ONE, 20 * ONE)];
/// Lines before a difference that are shown.
const SHOWN: usize = 30;
/// An angstrom, pm.
const ANGSTROM_PM: i64 = 100;

/// Compares random lines of holes with what the console makes of them. Returns how many lines drilled.
///
/// # Errors
/// The difference, with the line.
pub fn run_holes(seed: u64) -> Result<usize, Difference> {
    let (mut author, mut pair) = (Author::new(Rand64::new(seed.into()), false), Pair::new(!seed));
    for _ in 0..LINES {
        let words = author.of_holes(&pair.model, &ROOM);
        pair.compare(&words)?;
    }
    Ok(pair.drilled)
}

/// Compares random lines of tool lengths with what the console makes of them. Returns how many tools the table has at the end.
///
/// # Errors
/// The difference, with the line.
pub fn run_lengths(seed: u64) -> Result<usize, Difference> {
    let (mut author, mut pair) = (Author::new(Rand64::new(seed.into()), false), Pair::new(!seed));
    for _ in 0..2 * LINES {
        let words = author.of_lengths(&pair.model, &ROOM);
        pair.compare(&words)?;
    }
    Ok(pair.model.tools.len())
}

/// A console and the model of it.
struct Pair {
    random: Rand64,
    model: Model,
    interpreter: Interpreter,
    settings: Settings,
    drilled: usize,
    said: Vec<String>,
}

impl Pair {
    fn new(seed: u64) -> Self {
        let (settings, mut listing) = (Settings::DEFAULT, String::new());
        report::settings(&mut listing, &settings).expect("a text takes all");
        let lines: Vec<String> = listing.lines().map(str::to_owned).collect();
        let (model, interpreter) = (Model::new(SettingValues::from_listing(&lines)), Interpreter::new());
        Self { random: Rand64::new(seed.into()), model, interpreter, settings, drilled: 0, said: Vec::new() }
    }

    fn compare(&mut self, words: &[Word]) -> Result<(), Difference> {
        self.compare_line(words).map_err(|difference| {
            let before = &self.said[self.said.len().saturating_sub(SHOWN)..];
            format!("{}\n{difference}", before.join("\n"))
        })
    }

    fn compare_line(&mut self, words: &[Word]) -> Result<(), Difference> {
        let line = written(words, &mut self.random).replace(' ', "").to_uppercase();
        let line = line.split(['(', ';']).next().unwrap_or_default();
        self.said.push(line.to_owned());
        self.model.path.clear();
        let expected = self.model.block(words).map(|()| self.model.path.clone());
        let made = match self.interpreter.interpret(line, ReportedState::Idle, &self.settings) {
            Ok(Command::Block(block)) => {
                let arc = block.motion.as_ref().and_then(|motion| motion.arc.as_ref());
                if let Some(arc) = arc {
                    compare_reach(line, &arc.bounds_mm(), &self.model)?;
                }
                self.drilled += usize::from(block.drills);
                Ok(places_pm(&block, &self.interpreter))
            }
            Ok(other) => return Err(format!("{line}: {other:?}")),
            Err(error) => Err(error.code()),
        };
        let in_pm = |places: Vec<Place>| places.into_iter().map(place_pm).collect();
        let expected: Result<Vec<_>, _> = expected.map(in_pm);
        if made != expected {
            return Err(format!("{line}: {made:?}, {expected:?} expected"));
        }
        let (end_pm, end) = (self.interpreter.position_pm(), self.model.position);
        if end_pm != place_pm(end) {
            return Err(format!("{line}: ends at {end_pm:?}, {end:?} expected"));
        }
        Ok(())
    }
}

/// A place of the model, which knows nothing of A.
fn place_pm(place: Place) -> [i64; AXES] {
    xyz_a(place.map(|one| one * ANGSTROM_PM), 0)
}

/// The places to which a block leads, in order.
fn places_pm(block: &Block, interpreter: &Interpreter) -> Vec<[i64; AXES]> {
    let parts = interpreter.cycle().parts().filter(|_| block.drills);
    let holes = parts.filter_map(|part| match part {
        CyclePart::Move(one) => Some(one.target_pm),
        _ => None,
    });
    let motion = block.motion.as_ref().map(|motion| motion.target_pm);
    block.via_pm.into_iter().chain(motion).chain(holes).collect()
}

/// Compares how far an arc reaches. Radii that differ leave it open by as much.
fn compare_reach(line: &str, bounds_mm: &[[f64; 2]], model: &Model) -> Result<(), Difference> {
    let Some((reach, misfit)) = model.bend else { return Err(format!("{line}: no arc expected")) };
    let near = |mm: f64, angstrom: f64| (mm * ONE as f64 - angstrom).abs() <= misfit + 20.0;
    let is_same = bounds_mm.iter().zip(reach).all(|(made, (low, high))| near(made[0], low) && near(made[1], high));
    if is_same { Ok(()) } else { Err(format!("{line}: reaches {bounds_mm:?}, {reach:?} expected")) }
}
