//! The cost of a short move that flows, stage by stage, and the number of moves per second that this cost allows.

use anyhow::Result;
use rp2040_bench::{FLOW_CASES, FlowCase, Stage, Untimed};
use serde::Serialize;

use super::board::CLOCK_HZ;
use super::lines::Lines;
use isostep::screen::grouped;

/// The cost of one of the [`FLOW_CASES`], in emulated cycles of the core per move.
#[derive(Clone, Debug, Serialize)]
pub struct FlowFigures {
    pub case: &'static str,
    pub stages: [StageFigures; Stage::ALL.len()],
}

/// The cost of one stage.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StageFigures {
    pub stage: &'static str,
    pub cycles_mean: f64,
}

/// The columns of [`FlowFigures::cells`].
pub const HEAD: [&str; 7] = ["read", "push", "advance", "shape 3 axes", "compile 3 axes", "all", "moves/s"];

impl FlowFigures {
    fn cycles(&self) -> f64 {
        self.stages.iter().map(|stage| stage.cycles_mean).sum()
    }

    /// Cycles per move of each stage and of all stages, and the number of moves per second if the core does nothing
    /// else.
    pub fn cells(&self) -> [String; 7] {
        let whole = |value: f64| grouped(value.round() as u64);
        let [read, push, advance, shape, compile] = self.stages.map(|stage| whole(stage.cycles_mean));
        [read, push, advance, shape, compile, whole(self.cycles()), whole(f64::from(CLOCK_HZ) / self.cycles())]
    }
}

/// The figures of every case. The checksum of each result is verified.
pub fn all(lines: &Lines) -> Result<Vec<FlowFigures>> {
    FLOW_CASES.iter().map(|case| of(lines, case)).collect()
}

fn of(lines: &Lines, case: &FlowCase) -> Result<FlowFigures> {
    let checksums = rp2040_bench::flow(case, &mut Untimed);
    let mut stages = [StageFigures { stage: "", cycles_mean: 0.0 }; Stage::ALL.len()];
    for ((stage, checksum), figures) in Stage::ALL.into_iter().zip(checksums).zip(&mut stages) {
        let line = lines.proven(&format!("flow.{}.{}", case.name, stage.name()), checksum)?;
        *figures = StageFigures { stage: stage.name(), cycles_mean: line.cycles_per_result() };
    }
    Ok(FlowFigures { case: case.name, stages })
}

#[cfg(test)]
mod tests {
    use rp2040_bench::Timer;

    use super::*;

    #[test]
    fn what_all_stages_cost_leaves_room_for_so_many_moves() {
        let stages = Stage::ALL.map(|stage| StageFigures { stage: stage.name(), cycles_mean: 25_000.0 });
        let cells = FlowFigures { case: "any", stages }.cells();
        assert_eq!(cells[5..], ["125,000", "1,000"]);
    }

    /// How often each stage was done.
    #[derive(Debug)]
    struct Counted([u32; Stage::ALL.len()]);

    impl Timer for Counted {
        fn time<I, R>(&mut self, stage: Stage, input: I, work: impl FnOnce(I) -> R) -> R {
            self.0[stage as usize] += 1;
            work(input)
        }
    }

    #[test]
    fn every_stage_is_done_for_every_move_and_few_moves_are_of_several_parts() {
        for case in &FLOW_CASES {
            let mut counted = Counted([0; Stage::ALL.len()]);
            rp2040_bench::flow(case, &mut counted);
            let ([read, push, advance, shape, compile], moves) = (counted.0, rp2040_bench::TIMED_MOVES);
            assert_eq!((read, push), (moves, moves), "{}", case.name);
            // Each axis of a shaped move has some bends.
            let all = if case.is_shaped() { 3 * advance..36 * advance } else { advance..advance + 1 };
            assert!(all.contains(&compile) && (shape > compile) == case.is_shaped(), "{}: {counted:?}", case.name);
            assert!((moves..moves * 2).contains(&advance), "{}: {advance} chunks", case.name);
        }
    }
}
