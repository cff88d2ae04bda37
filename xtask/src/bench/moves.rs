//! How many short moves a second the firmware carries, from the bytes of their lines to their edges: a sender that counts
//! characters offers them faster than the core could take them.

use anyhow::Result;
use rp2040_bench::{FLOW_CASES, MOVE_MM, Path, START_MM, STEPS_PER_MM};
use serde::Serialize;

use super::board::{Board, Summary};
use super::edges::{Edge, NS_PER_CYCLE};
use super::effort::Effort;
use super::measured::Measured;
use isostep::screen::grouped;

use super::progress::Case;
use super::trial::AXES;
use crate::variant::Port;

/// So much and so wide that neither limits the moves.
const ACCEL_MM_S2: f64 = 10_000.0;
const CORNER_DEVIATION_MM: f64 = 1.0;
/// A core that makes fewer than this is not waited for.
const SLOWEST_MOVES_S: f64 = 100.0;

/// A stream of moves of three axes.
#[derive(Clone, Debug, Serialize)]
pub struct MoveFigures {
    /// How long each is, mm.
    pub move_mm: f64,
    /// How fast they are to be, mm/min.
    pub feed_mm_min: f64,
    /// How many.
    pub moves: usize,
    pub carried: Measured<Carried>,
}

/// How the stream went.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Carried {
    /// In the middle half of the stream.
    pub rate_moves_s: f64,
    /// Share of the time that the core was awake.
    pub load: f64,
}

impl Carried {
    pub fn words(&self) -> String {
        format!("{} moves/s, core {:.1} % awake", grouped(self.rate_moves_s as u64), self.load * 100.0)
    }
}

/// The lines of a stream.
struct Program {
    text: String,
    /// Steps of all axes when each of its moves has been made.
    steps: Vec<usize>,
}

impl Program {
    fn new(moves: usize, feed_mm_min: f64) -> Self {
        let settings = [(100, STEPS_PER_MM), (110, feed_mm_min), (120, ACCEL_MM_S2), (11, CORNER_DEVIATION_MM)];
        let settings = settings.into_iter().flat_map(|(number, value)| {
            let axes = if number < 100 { 0..1 } else { 0..3 };
            axes.map(move |axis| format!("${}={value}\n", number + axis))
        });
        let place = ["X", "Y", "Z"].map(|axis| format!("{axis}{START_MM}")).concat();
        let mut text = settings.collect::<String>() + &format!("G92{place}\nG90G1F{feed_mm_min}\n");
        let mut path = Path::new(&FLOW_CASES[0]);
        let (mut steps, mut made) = (Vec::new(), 0);
        for _ in 0..moves {
            let from = path.place_steps();
            text += &String::from_utf8_lossy(path.next_line().bytes());
            made += from.iter().zip(path.place_steps()).map(|(&from, to)| to.abs_diff(from) as usize).sum::<usize>();
            steps.push(made);
        }
        Self { text, steps }
    }

    /// Of the middle half; `None` if `edges` are not those of its steps.
    fn rate_moves_s(&self, edges: &[Edge]) -> Option<f64> {
        let middle = [self.steps.len() / 4, self.steps.len() * 3 / 4];
        let is_all = self.steps.last() == Some(&edges.len());
        // The first edge after the move.
        let cycles = middle.map(|index| edges.get(*self.steps.get(index)?).map(|edge| edge.cycle));
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

/// Streams them once.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<MoveFigures> {
    let (moves, feed_mm_min) = (effort.moves, port.moves_feed_mm_min());
    let what = format!("{} moves of {MOVE_MM} mm at F{feed_mm_min}", grouped(moves as u64));
    let case = Case::named(board.chip, port, &what);
    let program = Program::new(moves, feed_mm_min);
    let ran = board.stream_for_edges(&program.text, moves as f64 / SLOWEST_MOVES_S)?;
    let carried = ran.and_then(|ran| program.judge(&ran));
    case.end(&carried.words(Carried::words));
    Ok(MoveFigures { move_mm: MOVE_MM, feed_mm_min, moves, carried })
}

/// `0.2 mm, 3 axes, F12000`.
pub fn name(figures: &MoveFigures) -> String {
    format!("{} mm, {AXES} axes, F{}", figures.move_mm, figures.feed_mm_min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge of a program's every ten cycles.
    fn edges(count: usize) -> Vec<Edge> {
        (0..count as u64).map(|edge| Edge { cycle: edge * 10, axis: 0, direction: 1 }).collect()
    }

    #[test]
    fn a_rate_is_that_of_the_middle_half() {
        let program = Program::new(40, 60_000.0);
        let steps = *program.steps.last().unwrap();
        let cycles = (program.steps[30] - program.steps[10]) * 10;
        let rate_moves_s = program.rate_moves_s(&edges(steps)).unwrap();
        assert!((rate_moves_s * cycles as f64 / 125e6 - 20.0).abs() < 1e-9, "{rate_moves_s}");
        assert!(program.rate_moves_s(&edges(steps - 1)).is_none(), "a step is missing");
    }

    #[test]
    fn a_program_has_its_settings_and_its_moves() {
        let program = Program::new(8, 60_000.0);
        let lines: Vec<&str> = program.text.lines().collect();
        assert_eq!(lines[..4], ["$100=80", "$101=80", "$102=80", "$110=60000"]);
        assert_eq!(lines[9..13], ["$11=1", "G92X500Y500Z500", "G90G1F60000", "G1X500.180Y500.004Z500.080"]);
        // 0.2 mm are 14.4, 0.3 and 6.4 steps.
        assert_eq!(program.steps[0], 14 + 6);
    }
}
