//! Figures of what the tool did in a run.

mod beginnings;
pub(crate) mod spells;

use serde::Serialize;

use self::beginnings::Beginnings;
use self::spells::Spell;
use crate::pace::phases::{Phase, phases};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;
use isostep_sim::tool::ToolOutput;

/// The tool's work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ToolFigures {
    /// True if the tool is a laser at the end of the run.
    pub laser: bool,
    /// The time that the spindle was enabled, or the laser on, s.
    pub on_s: f64,
    /// The duty of the PWM output during that time; null if it was never on.
    pub duty: Option<DutyFigures>,
    /// Number of changes of the duty.
    pub duty_changes: usize,
    /// Figures of a laser's beam; null for a spindle.
    pub beam: Option<BeamFigures>,
    /// The time that flood coolant was on, s.
    pub flood_s: f64,
    /// The time that mist coolant was on, s.
    pub mist_s: f64,
}

/// A duty over some time, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DutyFigures {
    /// The least.
    pub least: f64,
    /// The most.
    pub most: f64,
    /// The mean over the time.
    pub mean: f64,
}

/// The work of a laser's beam.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BeamFigures {
    /// Length of the path with the beam on, mm.
    pub path_mm: f64,
    /// Time on this path, s.
    pub path_s: f64,
    /// The time that the beam was on while no axis moved, s.
    pub still_s: f64,
    /// Distances of the changes of level from the beginnings of their moves; null if there were none.
    pub beginnings: Option<Beginnings>,
}

impl ToolFigures {
    /// The figures of a run whose moves have these `sources`; `None` if the tool was not used.
    pub fn of(outcome: &Outcome, sources: &[Option<Source>]) -> Option<Self> {
        if outcome.tool.is_empty() {
            return None;
        }
        let laser = outcome.tool_config.laser;
        let spells = spells::of_spindle(&outcome.tool, laser, outcome.duration_ns);
        let coolant_s = |output| spells::on_s(&outcome.tool, output, outcome.duration_ns);
        Some(Self {
            laser,
            on_s: spells.iter().map(Spell::span_s).sum(),
            duty: DutyFigures::of(&spells),
            duty_changes: outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm).count(),
            beam: laser.then(|| BeamFigures::of(outcome, sources, &spells)),
            flood_s: coolant_s(ToolOutput::Flood),
            mist_s: coolant_s(ToolOutput::Mist),
        })
    }
}

impl DutyFigures {
    fn of(spells: &[Spell]) -> Option<Self> {
        let duty_ratios = || spells.iter().map(|spell| spell.duty_ratio);
        let whole_s: f64 = spells.iter().map(Spell::span_s).sum();
        Some(Self {
            least: duty_ratios().reduce(f64::min)?,
            most: duty_ratios().reduce(f64::max)?,
            mean: spells.iter().map(|spell| spell.duty_ratio * spell.span_s()).sum::<f64>() / whole_s,
        })
    }
}

impl BeamFigures {
    fn of(outcome: &Outcome, sources: &[Option<Source>], spells: &[Spell]) -> Self {
        let (mut path_mm, mut path_s) = (0.0, 0.0);
        for (spell, phase) in together(outcome, sources, spells) {
            let (begin_s, end_s) = (spell.0.max(phase.begin_s), spell.1.min(phase.end_s()));
            path_s += end_s - begin_s;
            path_mm += phase.made_mm(end_s) - phase.made_mm(begin_s);
        }
        let on_s: f64 = spells.iter().map(Spell::span_s).sum();
        let beginnings = beginnings::of(outcome);
        Self { path_mm, path_s, still_s: (on_s - path_s).max(0.0), beginnings }
    }
}

/// For each spell its start and end, s from the start of the first move, with each phase of the program that overlaps
/// it. In a shaped run the spells are late as the axes are: that is left out here.
fn together<'a>(
    outcome: &'a Outcome,
    sources: &'a [Option<Source>],
    spells: &'a [Spell],
) -> impl Iterator<Item = ((f64, f64), Phase<'a>)> {
    let first = outcome.moves.iter().find(|record| !record.homing);
    let (start_ns, begin_s) = first.map_or((0, 0.0), |first| (first.start_ns, first.begin_s()));
    let since_start_s = move |t_ns: u64| (t_ns as f64 - start_ns as f64) * 1e-9 - begin_s;
    let mut passed = 0;
    phases(outcome, sources).flat_map(move |phase| {
        let late_s = outcome.moves[phase.index].delay_s();
        let on_path_s = move |t_ns: u64| since_start_s(t_ns) - late_s;
        passed += spells[passed..].partition_point(|spell| on_path_s(spell.end_ns) <= phase.begin_s);
        let spans_s = spells[passed..].iter().map(move |spell| (on_path_s(spell.begin_ns), on_path_s(spell.end_ns)));
        spans_s.take_while(move |span_s| span_s.0 < phase.end_s()).map(move |span_s| (span_s, phase))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, lines_of_moves, run};

    fn figures(program: &str) -> Option<ToolFigures> {
        let outcome = run(program.as_bytes(), &Config::default()).unwrap();
        assert!(outcome.refusals.is_empty(), "{:?}", outcome.refusals);
        ToolFigures::of(&outcome, &lines_of_moves::of_moves(&outcome))
    }

    #[test]
    fn a_program_without_a_tool_has_no_figures_of_one() {
        assert_eq!(figures("G91 G1 F600 X10\n"), None);
    }

    #[test]
    fn a_spindle_is_on_while_it_is_enabled() {
        let tool = figures("$394=0.5\nG91 G1 F600 M3 S250\nX10\nG4 P1\nM8\nG4 P0.5\nM9 M5\n").unwrap();
        let duty = tool.duty.unwrap();
        assert!(!tool.laser && tool.beam.is_none() && (duty.most - 0.25).abs() < 1e-4 && duty.least == duty.most);
        assert!((3.0..3.3).contains(&tool.on_s) && (tool.flood_s - 0.5).abs() < 0.01, "{tool:?}");
        assert_eq!((tool.duty_changes, tool.mist_s), (2, 0.0));
    }

    #[test]
    fn a_beam_shines_on_the_path_alone() {
        let program = "$32=1\nG91 G1 F600 M3 S500\nX5\nG4 P1\nG0 X5\nG1 S1000\nX5\nY5\nM5\n";
        let tool = figures(program).unwrap();
        let (beam, duty) = (tool.beam.unwrap(), tool.duty.unwrap());
        assert!((beam.path_mm - 15.0).abs() < 1e-3 && beam.still_s < 1e-5, "{beam:?}");
        assert!((tool.on_s - beam.path_s).abs() < 1e-5 && (1.5..2.0).contains(&beam.path_s), "{tool:?}");
        assert!((duty.least - 0.5).abs() < 1e-4 && duty.most == 1.0 && (0.5..1.0).contains(&duty.mean));
        let beginnings = beam.beginnings.unwrap();
        assert!(beginnings.total == 2 && beginnings.most_us < 1.0, "{beginnings:?}");
    }
}
