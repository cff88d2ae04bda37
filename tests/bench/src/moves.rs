//! Measures how many short moves per second the firmware sustains, from the bytes of their lines to their edges. The
//! sender counts characters and offers moves faster than the core can handle them.

use anyhow::Result;
use rp2040_bench::{FLOW_CASES, MOVE_MM, Path, START_MM, STEPS_PER_MM};
use serde::Serialize;

use super::board::{Board, Summary};
use super::chip::Chip;
use super::edges::{Edge, NS_PER_CYCLE};
use super::effort::Effort;
use super::measured::Measured;
use isostep::screen::grouped;

use super::port::Port;
use super::progress::Case;
use super::trial::AXES;

/// The acceleration and the corner deviation are so large that neither limits the moves.
const ACCEL_MM_S2: f64 = 10_000.0;
const CORNER_DEVIATION_MM: f64 = 1.0;
/// How far blends may leave the corners, mm: much more than they need, so that they meet in the middle of each move.
const BLEND_DEVIATION_MM: f64 = 0.05;
/// The run does not wait for a core that makes fewer moves per second than this.
const SLOWEST_MOVES_S: f64 = 100.0;

/// A stream of moves of three axes.
#[derive(Clone, Debug, Serialize)]
pub struct MoveFigures {
    /// Length of each move, mm.
    pub move_mm: f64,
    /// Requested speed of the moves, mm/min.
    pub feed_mm_min: f64,
    /// Number of moves.
    pub moves: usize,
    /// With exact corners.
    pub carried: Measured<Carried>,
    /// With blends.
    pub blended: Measured<Carried>,
    /// With blends, and a ZV shaper of the default frequency on every axis.
    pub shaped: Measured<Carried>,
    /// With blends, and a box of 10 ms on every axis.
    pub boxed: Measured<Carried>,
}

/// The result of a stream.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Carried {
    /// The rate in the middle half of the stream.
    pub rate_moves_s: f64,
    /// Fraction of the time during which the core was awake.
    pub load: f64,
}

impl Carried {
    pub fn words(&self) -> String {
        format!("{} moves/s, core {:.1} % awake", grouped(self.rate_moves_s as u64), self.load * 100.0)
    }
}

/// How the corners between the moves are taken.
#[derive(Clone, Copy)]
enum Corners {
    Exact,
    Blended,
    Shaped,
    Boxed,
}

impl Corners {
    fn word(self) -> String {
        match self {
            Self::Exact => "G61".to_owned(),
            Self::Blended | Self::Shaped | Self::Boxed => format!("G64P{BLEND_DEVIATION_MM}"),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::Blended => ", with blends",
            Self::Shaped => ", with blends and ZV",
            Self::Boxed => ", with blends and a box",
        }
    }
}

/// The lines of a stream, and the steps that they make.
struct Program {
    text: String,
    /// For each move, the number of steps of all axes up to its end.
    steps: Vec<usize>,
    /// Some of them may be left out.
    leaves_out: bool,
}

impl Program {
    fn new(moves: usize, feed_mm_min: f64, corners: Corners) -> Self {
        let settings = [(100, STEPS_PER_MM), (110, feed_mm_min), (120, ACCEL_MM_S2), (11, CORNER_DEVIATION_MM)];
        let shaper: &[(u16, f64)] = match corners {
            Corners::Exact | Corners::Blended => &[],
            Corners::Shaped => &[(950, 1.0)],
            Corners::Boxed => &[(950, 5.0), (960, 100.0)],
        };
        let settings = settings.into_iter().chain(shaper.iter().copied()).flat_map(|(number, value)| {
            let axes = if number < 100 { 0..1 } else { 0..3 };
            axes.map(move |axis| format!("${}={value}\n", number + axis))
        });
        let place = ["X", "Y", "Z"].map(|axis| format!("{axis}{START_MM}")).concat();
        let mut text = settings.collect::<String>() + &format!("G92{place}\nG90G1F{feed_mm_min}{}\n", corners.word());
        let mut path = Path::new(&FLOW_CASES[0]);
        let (mut steps, mut made) = (Vec::new(), 0);
        for _ in 0..moves {
            let from = path.place_steps();
            text += &String::from_utf8_lossy(path.next_line().bytes());
            made += from.iter().zip(path.place_steps()).map(|(&from, to)| to.abs_diff(from) as usize).sum::<usize>();
            steps.push(made);
        }
        Self { text, steps, leaves_out: matches!(corners, Corners::Shaped | Corners::Boxed) }
    }

    /// The rate in the middle half, moves/s; `None` if `edges` does not have as many edges as the program has steps.
    fn rate_moves_s(&self, edges: &[Edge]) -> Option<f64> {
        let middle = [self.steps.len() / 4, self.steps.len() * 3 / 4];
        let all = *self.steps.last()?;
        // Where an axis turns within a few steps, shaped motion leaves some of them out.
        let is_all = if self.leaves_out { edges.len() * 100 > all * 99 } else { edges.len() == all };
        // The first edge after this move.
        let first = |index: usize| edges.get(*self.steps.get(index)? * edges.len() / all);
        let cycles = middle.map(|index| first(index).map(|edge| edge.cycle));
        let [from, to] = if is_all { [cycles[0]?, cycles[1]?] } else { return None };
        Some((middle[1] - middle[0]) as f64 / ((to - from) as f64 * NS_PER_CYCLE * 1e-9))
    }

    fn judge(&self, (summary, edges): &(Summary, Vec<Edge>)) -> Measured<Carried> {
        let rate_moves_s = self.rate_moves_s(edges);
        rate_moves_s
            .map(|rate_moves_s| Carried { rate_moves_s, load: summary.moving.load })
            .ok_or_else(|| format!("{} edges of {:?} steps", edges.len(), self.steps.last()))
            .into()
    }
}

/// Streams the moves, once with each kind of corners.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<MoveFigures> {
    let (moves, feed_mm_min) = (count(board, port, effort), port.moves_feed_mm_min());
    let carried = |corners| carried(board, port, Program::new(moves, feed_mm_min, corners), feed_mm_min, corners);
    Ok(MoveFigures {
        move_mm: MOVE_MM,
        feed_mm_min,
        moves,
        carried: carried(Corners::Exact)?,
        blended: carried(Corners::Blended)?,
        shaped: carried(Corners::Shaped)?,
        boxed: carried(Corners::Boxed)?,
    })
}

/// Number of moves. Those of the slower port take the longest of all, and a third of them shows the rate too.
fn count(board: &Board, port: Port, effort: &Effort) -> usize {
    let is_figure = port == Port::Pio || (board.chip == Chip::AsItIs && !board.has_second);
    if is_figure { effort.moves } else { effort.moves / 3 }
}

fn carried(
    board: &Board,
    port: Port,
    program: Program,
    feed_mm_min: f64,
    corners: Corners,
) -> Result<Measured<Carried>> {
    let moves = program.steps.len();
    let what = format!("{} moves of {MOVE_MM} mm at F{feed_mm_min}{}", grouped(moves as u64), corners.words());
    let case = Case::named(board.chip, port, &board.named(&what));
    let ran = board.stream_for_edges(&program.text, moves as f64 / SLOWEST_MOVES_S)?;
    let carried = ran.and_then(|ran| program.judge(&ran));
    case.end(&carried.words(Carried::words));
    Ok(carried)
}

impl MoveFigures {
    /// For each kind of corners, a name such as `0.2 mm, 3 axes, F12000, with blends`, and how many moves were carried.
    pub fn rows(&self) -> [[String; 2]; 4] {
        let row = |corners: Corners, carried: &Measured<Carried>| {
            [name(self) + corners.words(), carried.words(Carried::words)]
        };
        [
            row(Corners::Exact, &self.carried),
            row(Corners::Blended, &self.blended),
            row(Corners::Shaped, &self.shaped),
            row(Corners::Boxed, &self.boxed),
        ]
    }
}

/// A name such as `0.2 mm, 3 axes, F12000`.
pub fn name(figures: &MoveFigures) -> String {
    format!("{} mm, {AXES} axes, F{}", figures.move_mm, figures.feed_mm_min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge every ten cycles.
    fn edges(count: usize) -> Vec<Edge> {
        (0..count as u64).map(|edge| Edge { cycle: edge * 10, axis: 0, direction: 1 }).collect()
    }

    #[test]
    fn a_rate_is_that_of_the_middle_half() {
        let program = Program::new(40, 60_000.0, Corners::Exact);
        let steps = *program.steps.last().unwrap();
        let cycles = (program.steps[30] - program.steps[10]) * 10;
        let rate_moves_s = program.rate_moves_s(&edges(steps)).unwrap();
        assert!((rate_moves_s * cycles as f64 / 125e6 - 20.0).abs() < 1e-9, "{rate_moves_s}");
        assert!(program.rate_moves_s(&edges(steps - 1)).is_none(), "a step is missing");
    }

    #[test]
    fn a_program_has_its_settings_and_its_moves() {
        let program = Program::new(8, 60_000.0, Corners::Blended);
        let lines: Vec<&str> = program.text.lines().collect();
        assert_eq!(lines[..4], ["$100=80", "$101=80", "$102=80", "$110=60000"]);
        assert_eq!(lines[9..13], ["$11=1", "G92X500Y500Z500", "G90G1F60000G64P0.05", "G1X500.180Y500.004Z500.080"]);
        // A move of 0.2 mm has 14.4, 0.3 and 6.4 steps.
        assert_eq!(program.steps[0], 14 + 6);
    }
}
