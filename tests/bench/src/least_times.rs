//! `cargo xtask bench --least-times`: the times that moves have to last for the board to keep up with them, beside those of its image.
//!
//! # Design
//! The least times are words of the image, so others are tried without building it again. A trial streams a curve of short moves, at a
//! feed at which each lasts as long as the words say, and simulates the same with these times. The board keeps up if moves come as fast
//! as in virtual time, where planning takes none, and the core sleeps for some of it. If moves run out, each is planned from rest
//! anew, so that they come much more slowly. The shortest times with which it keeps up are found by bisection.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use isostep::measure::moves::{Carried, Corners, Curve, Stream};
use isostep::measure::planned_move::PROVED;
use isostep::measure::search::{Found, highest};
use isostep::measure::{Board, Measured, table};
use isostep::parallel;
use isostep::screen::grouped;
use isostep_motion::LeastTimes;

use super::board::{Emulated, carried_s, leaving_out};
use super::candidate::Candidate;
use super::chip::Chip;
use super::edges::Edge;
use super::port::Port;
use super::runs::{POLL_HZ, Runs};
use super::{Images, candidate, curve};

/// The number of moves in a trial.
const MOVES: usize = 1_500;
/// How fast moves may come beside those that the image has, %.
const SPEEDS_PERCENT: std::ops::RangeInclusive<u32> = 50..=300;
const STEP_PERCENT: usize = 2;
/// The acceleration of each axis with an RP2350, mm/s2: that of other measurements makes moves slower than its least times do.
const FAST_ACCEL_MM_S2: u32 = 60_000;
/// The core is awake for no more of the time than this.
const AWAKE_MAX: f64 = 0.95;
/// Moves come as fast as planned if they are no slower than this.
const AS_PLANNED: f64 = 0.98;
/// Crossed belts, whose Y rings at another frequency than X.
const UNLIKE_BELTS: [&str; 3] = ["$907=1", "$960=70", "$961=55"];
/// The emulated boards that run at once.
const AT_ONCE: usize = 2;
/// The chips, in the order of the columns.
const CHIPS: [Chip; 2] = [Chip::AsItIs, Chip::CostlyMiss];

/// What reads the least times of an image, and what writes it with others to another file.
pub struct Words {
    /// Reads.
    pub read: fn(&Path) -> Result<LeastTimes>,
    /// Writes.
    pub write: fn(&Path, &LeastTimes, &Path) -> Result<()>,
}

/// What short moves are made as.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Straight,
    Blend,
    Together,
    Shaped,
    Box,
    Belts,
    BoxedBelts,
}

impl Kind {
    const ALL: [Self; 7] =
        [Self::Straight, Self::Blend, Self::Together, Self::Shaped, Self::Box, Self::Belts, Self::BoxedBelts];

    fn name(self) -> &'static str {
        match self {
            Self::Straight => "a move without a blend (G61)",
            Self::Blend => "a move with a blend (G64 Q0)",
            Self::Together => "each but the first of moves taken together; all of them beside that (G64)",
            Self::Shaped => "a move in a shaped run (ZV)",
            Self::Box => "a move in a run with a box; instead, if it is more, times the root of its steps",
            Self::Belts => "as the ZV, on crossed belts whose axes have unlike ones, where it takes more of that",
            Self::BoxedBelts => "as the box, on crossed belts whose axes have unlike ones, where it takes more of that",
        }
    }

    fn corners(self) -> Corners {
        match self {
            Self::Straight => Corners::Exact,
            Self::Blend => Corners::Blends,
            Self::Together => Corners::Together,
            Self::Shaped | Self::Belts => Corners::Zv,
            Self::Box | Self::BoxedBelts => Corners::Box,
        }
    }

    /// Moves of this kind for such a chip.
    fn stream(self, curve: &Curve, chip: isostep::chip::Chip) -> Stream {
        let mut stream = Stream::new(curve, self.corners());
        if matches!(self, Self::Belts | Self::BoxedBelts) {
            let begin = stream.before.len() - 1;
            stream.before.splice(begin..begin, UNLIKE_BELTS.map(str::to_owned));
        }
        if chip == isostep::chip::Chip::Rp2040 {
            return stream;
        }
        let begin = stream.before.len() - 1;
        stream.before.splice(begin..begin, (120..).take(PROVED).map(|number| format!("${number}={FAST_ACCEL_MM_S2}")));
        stream
    }

    /// Its own of the least times, s.
    fn own(self, times: &mut LeastTimes) -> Vec<&mut f64> {
        match self {
            Self::Straight => vec![&mut times.straight_s],
            Self::Blend => vec![&mut times.blend_s],
            Self::Together => vec![&mut times.join_s, &mut times.together_s],
            Self::Shaped | Self::Belts => vec![&mut times.shaped_s],
            Self::Box | Self::BoxedBelts => vec![&mut times.box_s, &mut times.box_root_step_s],
        }
    }

    /// The times with which such moves are so much as fast as with `times`.
    fn at(self, mut times: LeastTimes, speed_percent: u32) -> LeastTimes {
        self.own(&mut times).into_iter().for_each(|s| *s *= 100.0 / f64::from(speed_percent));
        times
    }

    /// Its own of the least times in words.
    fn words(self, mut times: LeastTimes) -> String {
        let own: Vec<_> = self.own(&mut times).into_iter().map(|s| format!("{:.2}", *s * 1e3)).collect();
        own.join("; ") + " ms"
    }
}

/// Moves that were carried with some times.
#[derive(Clone, Copy, Debug)]
struct Trial {
    /// On the emulated board, and in virtual time.
    per_s: f64,
    planned_per_s: f64,
    awake_ratio: f64,
}

impl Trial {
    fn keeps_up(&self) -> bool {
        self.per_s >= AS_PLANNED * self.planned_per_s && self.awake_ratio <= AWAKE_MAX
    }
}

/// Runs the verb. `folder` is for the files of the runs.
///
/// # Errors
/// A run that cannot be made, or an image without words.
pub fn run(images: &Images, words: &Words, folder: &Path) -> Result<()> {
    let candidate = &images.candidates[0];
    let configured = (words.read)(&candidate.elf)?;
    let miss_cycles = Runs::new(candidate, Chip::AsItIs, folder).miss_cycles()?;
    let jobs: Vec<_> = Kind::ALL.into_iter().flat_map(|kind| CHIPS.map(|chip| (kind, chip))).collect();
    let found = parallel::map(&jobs, AT_ONCE, |&(kind, chip)| {
        let folder = folder.join(format!("least-{kind:?}-{}", chip.slug()));
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        Search { kind, chip, candidate, words, configured, folder }.run()
    });
    let speeds = found.into_iter().collect::<Result<Vec<_>>>()?;
    println!(
        "Emulated: {}, {}, a word of flash that the cache does not hold takes {miss_cycles} cycles, {}; {} moves of 0.2 mm of three axes \
         over USB, status polled at {POLL_HZ} Hz. Needed: the shortest time, in steps of {STEP_PERCENT} %, with which no move runs out and the \
         core is awake for {:.0} % at most. Margin: by how much faster than configured that is.",
        candidate.model.name(),
        candidate.model.clocked(),
        candidate::build_options(),
        grouped(MOVES as u64),
        AWAKE_MAX * 100.0,
    );
    let rows = Kind::ALL.into_iter().zip(speeds.as_chunks().0).map(|(kind, speeds)| row(kind, configured, speeds));
    print!("\n{}", table::text(HEAD, rows.collect()));
    println!(
        "\nMoves without a blend come no faster than they are read, but after a hold or a longer move: what is known ahead then is made faster \
         than others are planned. Those in a shaped run may last longer than their time says: there has to be room for what the shaper keeps of them."
    );
    Ok(())
}

const HEAD: [&str; 6] = ["at least", "configured", "needed", "margin", "a miss twice as dear", "margin"];

/// A row of the table, for the highest speeds on [`CHIPS`], %.
fn row(kind: Kind, configured: LeastTimes, speeds_percent: &[Option<u32>; 2]) -> [String; 6] {
    let cells = |speed_percent: &Option<u32>| match *speed_percent {
        None => [format!("more than {}", kind.words(kind.at(configured, *SPEEDS_PERCENT.start()))), "-".to_owned()],
        Some(percent) => [kind.words(kind.at(configured, percent)), format!("{:+} %", i64::from(percent) - 100)],
    };
    let [[needed, margin], [dear, dear_margin]] = speeds_percent.each_ref().map(cells);
    [kind.name().to_owned(), kind.words(configured), needed, margin, dear, dear_margin]
}

/// The search for the shortest times of a kind of moves on a chip.
struct Search<'a> {
    kind: Kind,
    chip: Chip,
    candidate: &'a Candidate,
    words: &'a Words,
    configured: LeastTimes,
    folder: PathBuf,
}

impl Search<'_> {
    /// The highest speed, beside that of the image, at which the board keeps up, %; `None` if there is none.
    fn run(&self) -> Result<Option<u32>> {
        let curve = curve(MOVES, Port::Pio.moves_feed_mm_min());
        let speeds: Vec<_> = SPEEDS_PERCENT.step_by(STEP_PERCENT).collect();
        let found: Found<(), ()> = highest(&speeds, |speed_percent| self.keeps_up(&curve, speed_percent))?;
        Ok(found.highest.map(|(speed_percent, ())| speed_percent))
    }

    fn keeps_up(&self, curve: &Curve, speed_percent: u32) -> Result<Result<(), ()>> {
        let Self { kind, chip, .. } = *self;
        let times = kind.at(self.configured, speed_percent);
        let tried = self.trial(&kind.stream(curve, self.candidate.model.chip()), &times)?;
        let keeps_up = tried.as_ref().is_ok_and(Trial::keeps_up);
        let verdict = if keeps_up { "keeps up" } else { "does not keep up" };
        let words = match tried {
            Ok(Trial { per_s, planned_per_s, awake_ratio }) => {
                format!("{per_s:.0} of {planned_per_s:.0} moves/s, core awake {:.1} %: {verdict}", awake_ratio * 100.0)
            }
            Err(why_not) => why_not,
        };
        eprintln!("    {}: {}, {}: {words}", chip.name(), kind.name(), kind.words(times));
        Ok(if keeps_up { Ok(()) } else { Err(()) })
    }

    fn trial(&self, stream: &Stream, times: &LeastTimes) -> Result<Measured<Trial>> {
        let candidate = Candidate { elf: self.folder.join("trial.elf"), ..self.candidate.clone() };
        (self.words.write)(&self.candidate.elf, times, &candidate.elf)?;
        let runs = Runs::new(&candidate, self.chip, &self.folder);
        let carried = match (Emulated { runs, port: Port::Pio, load_s: 0.0 }).stream(stream)? {
            Ok(carried) => carried,
            Err(why_not) => return Ok(Err(why_not)),
        };
        let planned = match simulated(&leaving_out(stream, self.candidate.model.chip()), times)? {
            Ok(planned) => planned,
            Err(why_not) => return Ok(Err(format!("simulated: {why_not}"))),
        };
        let rate = |carried: &Carried| carried.rate_per_s().context("all moves came at one instant");
        let awake_ratio = carried.awake_ratio.context("the emulator tells the load")?;
        Ok(Ok(Trial { per_s: rate(&carried)?, planned_per_s: rate(&planned)?, awake_ratio }))
    }
}

/// The stream as it is planned: in virtual time, where nothing takes time but the moves.
fn simulated(stream: &Stream, least_times: &LeastTimes) -> Result<Measured<Carried>> {
    let program = stream.before.iter().chain(&stream.lines).map(|line| format!("{line}\n")).collect::<String>();
    let config = isostep_sim::Config { least_times: *least_times, keep_waves: false, ..isostep_sim::Config::default() };
    let outcome = isostep_sim::run(program.as_bytes(), &config)?;
    let edges =
        outcome.edges.iter().map(|edge| Edge { t_ns: edge.t_ns as f64, axis: edge.axis, direction: edge.direction });
    let at_s = carried_s(stream, &edges.collect::<Vec<_>>());
    Ok(at_s.map(|at_s| Carried { at_s, by: "the edges", awake_ratio: None }))
}

#[cfg(test)]
mod tests {
    use isostep::chip::Chip::{Rp2040, Rp2350};

    use super::*;

    const TIMES: LeastTimes =
        LeastTimes { straight_s: 1e-3, join_s: 0.2e-3, together_s: 0.8e-3, ..isostep_controller::least_times::RP2040 };

    #[test]
    fn moves_that_are_so_much_as_fast_have_their_own_times_so_much_shorter() {
        let faster = Kind::Together.at(TIMES, 160);
        assert_eq!((faster.join_s, faster.together_s), (0.125e-3, 0.5e-3));
        assert_eq!(LeastTimes { join_s: 0.2e-3, together_s: 0.8e-3, ..faster }, TIMES);
        assert_eq!(Kind::Straight.at(TIMES, 50), LeastTimes { straight_s: 2e-3, ..TIMES });
    }

    #[test]
    fn a_board_keeps_up_if_moves_come_as_planned_and_it_has_time_left() {
        let keeps_up = |per_s, awake_ratio| Trial { per_s, planned_per_s: 1_000.0, awake_ratio }.keeps_up();
        assert!(keeps_up(1_000.0, 0.95) && keeps_up(980.0, 0.5) && keeps_up(1_003.0, 0.5));
        assert!(!keeps_up(979.0, 0.5), "moves run out");
        assert!(!keeps_up(1_000.0, 0.951), "nothing is left for the consoles");
    }

    #[test]
    fn a_row_has_the_shortest_times_and_how_much_faster_they_are() {
        let words = |speeds: [Option<u32>; 2]| row(Kind::Together, TIMES, &speeds)[1..].join(" | ");
        assert_eq!(words([Some(160), Some(80)]), "0.20; 0.80 ms | 0.12; 0.50 ms | +60 % | 0.25; 1.00 ms | -20 %");
        assert_eq!(words([Some(100), None]), "0.20; 0.80 ms | 0.20; 0.80 ms | +0 % | more than 0.40; 1.60 ms | -");
    }

    /// In virtual time each move lasts as long as it has to, and so on the emulated board, too, if that keeps up. Exactly taken, a curve
    /// has moves of unequal length, and the shortest of them lasts so long.
    #[test]
    fn simulated_moves_come_as_fast_as_their_times_allow() {
        // What bounds moves without a blend bounds all others, too; and what a shaper keeps of moves bounds those that are shaped.
        let short =
            |kind| LeastTimes { straight_s: if kind == Kind::Straight { TIMES.straight_s } else { 0.1e-3 }, ..TIMES };
        let curve = curve(400, 60_000.0);
        for (kind, least_s) in
            [(Kind::Straight, TIMES.straight_s), (Kind::Blend, TIMES.blend_s), (Kind::Shaped, TIMES.shaped_s)]
        {
            for (chip, speed_percent) in [(Rp2040, 50), (Rp2040, 100), (Rp2350, 100), (Rp2350, 240)] {
                let (times, least_s) =
                    (kind.at(short(kind), speed_percent), least_s * 100.0 / f64::from(speed_percent));
                let stream = leaving_out(&kind.stream(&curve, chip), chip);
                let carried = simulated(&stream, &times).unwrap().unwrap();
                let each_s = carried.rate_per_s().unwrap().recip();
                assert!((each_s / least_s - 1.0).abs() < 0.02, "{kind:?}: {each_s} s for {least_s}");
            }
        }
    }
}
