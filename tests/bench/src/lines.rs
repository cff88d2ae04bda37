//! Parses the output of the benchmark firmware: a line for each figure, with a checksum of the results. The results are
//! computed here again to verify the checksum.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use isostep_profile::SyncMove;
use rp2040_bench::{Checksum, TICK_HZ};

/// Number of axes that step at once.
pub(super) const AXES: f64 = 3.0;

/// Cycles per segment.
#[derive(Clone, Copy, Debug)]
pub struct CompileFigures {
    pub phase: &'static str,
    pub segments: u32,
    pub cycles_mean: f64,
    pub cycles_max: u64,
}

/// A line printed by the firmware.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) cycles: u64,
    count: u32,
    checksum: u32,
}

impl Line {
    /// Parses `cycles,count,checksum`.
    fn parse(text: &str) -> Option<Self> {
        let mut numbers = text.split(',');
        let line = Self {
            cycles: numbers.next()?.parse().ok()?,
            count: numbers.next()?.parse().ok()?,
            checksum: numbers.next()?.parse().ok()?,
        };
        numbers.next().is_none().then_some(line)
    }

    pub(super) fn cycles_per_result(&self) -> f64 {
        self.cycles as f64 / f64::from(self.count)
    }

    pub(super) fn results_per_cycle(&self) -> f64 {
        f64::from(self.count) / self.cycles as f64
    }
}

/// The firmware's lines by name.
pub(super) struct Lines(BTreeMap<String, Line>);

impl Lines {
    /// Parses a transcript of the emulated board, whose lines are `<time> < <line>`.
    pub(super) fn parse(transcript: &str) -> Result<Self> {
        let said = transcript.lines().filter_map(|line| line.split_once(" < ")).map(|(_, said)| said);
        let figures = said.take_while(|said| *said != "end").map(|said| {
            let (name, figure) = said.split_once(',').unwrap_or((said, ""));
            let line =
                Line::parse(figure).with_context(|| format!("the firmware said `{said}`, which is no figure"))?;
            Ok((name.to_owned(), line))
        });
        figures.collect::<Result<_>>().map(Self)
    }

    pub(super) fn of(&self, name: &str) -> Result<&Line> {
        self.0.get(name).with_context(|| format!("the firmware said nothing of {name}"))
    }

    /// The line with this name, if its checksum matches that of the results computed here.
    pub(super) fn proven(&self, name: &str, checksum: Checksum) -> Result<&Line> {
        let line = self.of(name)?;
        ensure!(line.checksum == checksum.value(), "{name}: the chip's results are not this computer's");
        Ok(line)
    }

    /// The lead over a full queue of segments, in ticks per cycle. `name` is the prefix of the lines' names.
    pub(super) fn queue_lead(&self, name: &str) -> Result<f64> {
        Ok(self.of(&format!("{name}.lead.queue"))?.results_per_cycle() / AXES)
    }

    /// Cycles per step.
    pub(super) fn fill(&self, name: &str, ramp: &SyncMove<1>) -> Result<f64> {
        let mut checksum = Checksum::default();
        for interval in ramp.segments(0, TICK_HZ).flat_map(|segment| segment.intervals()) {
            checksum.add(interval);
        }
        Ok(self.proven(name, checksum)?.cycles_per_result())
    }

    /// The figures by phase. `name` is the prefix of the lines' names.
    pub(super) fn compile(&self, name: &str, ramp: &SyncMove<1>) -> Result<Vec<CompileFigures>> {
        let mut segments = ramp.segments(0, TICK_HZ);
        let phases = rp2040_bench::phases(ramp).into_iter().map(|(phase, steps)| {
            let mut checksum = Checksum::default();
            let mut left = steps;
            while left > 0 {
                let Some(segment) = segments.next() else { break };
                left = left.saturating_sub(segment.steps());
                checksum.add(segment.steps());
            }
            let sum = self.proven(&format!("{name}.{phase}"), checksum)?;
            let slowest = self.of(&format!("{name}.{phase}.max"))?;
            let cycles_mean = sum.cycles_per_result();
            Ok(CompileFigures { phase, segments: sum.count, cycles_mean, cycles_max: slowest.cycles })
        });
        phases.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_from_a_transcript_up_to_the_end() {
        let lines =
            Lines::parse("    0.0 # expect end\n    0.1 < fill,700,20,5\n    0.2 < end\n    0.3 < noise").unwrap();
        assert_eq!(*lines.of("fill").unwrap(), Line { cycles: 700, count: 20, checksum: 5 });
        assert!((lines.of("fill").unwrap().cycles_per_result() - 35.0).abs() < 1e-12);
        assert!(lines.of("avr446").is_err());
        assert!(Lines::parse("0.1 < panicked at").is_err());
        assert!(Lines::parse("0.1 < fill,1,2,3,4").is_err());
    }
}
