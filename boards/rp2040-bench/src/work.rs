//! The pieces of work, timed.

use core::sync::atomic::{AtomicU32, Ordering};

use isostep_profile::{IntervalLaw, Segment};
use rp2040_bench::{BLOCK_WORDS, Checksum, Peer, TICK_HZ, Visitor, generators, plan_checksum, ramp};

use crate::hot;
use crate::report::{Figure, Report};
use crate::stopwatch::Stopwatch;

const CONSTANTS_WORK: &str = "the limits are constants that work";

/// Where a port's DMA would read.
static BLOCK: [AtomicU32; BLOCK_WORDS] = [const { AtomicU32::new(0) }; BLOCK_WORDS];

/// A move of three axes, and their segments begun.
pub fn plan(stopwatch: &Stopwatch, report: &mut Report) {
    for (name, law) in [("plan.fastest", IntervalLaw::Fastest), ("plan.thirds", IntervalLaw::Thirds)] {
        let ((plan, segments), cycles) = stopwatch.time(law, |law| {
            let plan = rp2040_bench::plan(law).expect(CONSTANTS_WORK);
            (plan, [0, 1, 2].map(|axis| plan.segments(axis, TICK_HZ)))
        });
        let mut figure = Figure::default();
        figure.add(cycles, 1);
        report.sum(name, figure, plan_checksum(&plan, segments));
    }
}

/// Segments of one axis through the ramp, by the phase they begin in.
pub fn compile(stopwatch: &Stopwatch, report: &mut Report) {
    let ramp = ramp().expect(CONSTANTS_WORK);
    let counts = ramp.profile.step_counts();
    let mut segments = ramp.segments(0, TICK_HZ);
    let mut phases =
        [("compile.accel", counts.accel), ("compile.cruise", counts.cruise), ("compile.decel", counts.decel)]
            .map(|(name, steps)| (name, steps, Figure::default(), Checksum::default()));
    let mut lead = Lead::default();
    for (_, steps, figure, checksum) in &mut phases {
        let mut left = *steps;
        while left > 0 {
            let (segment, cycles) = stopwatch.time(&mut segments, Iterator::next);
            let Some(segment) = segment else { break };
            left = left.saturating_sub(segment.steps());
            figure.add(cycles, 1);
            checksum.add(segment.steps());
            lead.add(segment, cycles);
        }
    }
    for (name, _, figure, checksum) in phases {
        report.sum(name, figure, checksum.value());
        report.max(name, figure, checksum.value());
    }
    lead.report(report);
}

/// The segment whose motion is over soonest for the cycles it took.
#[derive(Default)]
struct Lead {
    cycles: u32,
    ticks: u32,
}

impl Lead {
    fn add(&mut self, segment: Segment, cycles: u32) {
        let ticks = (segment.last_ticks() - segment.first_ticks()) as u32;
        // A lone step lasts as long as its neighbours' interval: another segment's affair.
        let is_run = segment.steps() > 1;
        let is_worse = u64::from(ticks) * u64::from(self.cycles) < u64::from(self.ticks) * u64::from(cycles);
        if is_run && (self.cycles == 0 || is_worse) {
            *self = Self { cycles, ticks };
        }
    }

    fn report(&self, report: &mut Report) {
        let figure = Figure { cycles: self.cycles.into(), cycles_max: self.cycles, count: self.ticks };
        report.sum("compile.lead", figure, 0);
    }
}

/// The loop that runs per step.
pub fn fill(stopwatch: &Stopwatch, report: &mut Report) {
    let ramp = ramp().expect(CONSTANTS_WORK);
    let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
    for segment in ramp.segments(0, TICK_HZ) {
        let mut intervals = segment.intervals();
        while intervals.len() > 0 {
            let (count, cycles) = stopwatch.time(&mut intervals, |intervals| hot::fill(intervals, &BLOCK));
            figure.add(cycles, count as u32);
            add_block(&mut checksum, count);
        }
    }
    report.sum("fill", figure, checksum.value());
}

/// The generators of the literature.
pub fn peers(stopwatch: &Stopwatch, report: &mut Report) {
    generators(&mut Timed { stopwatch, report }).expect(CONSTANTS_WORK);
}

struct Timed<'a> {
    stopwatch: &'a Stopwatch,
    report: &'a mut Report,
}

impl Visitor for Timed<'_> {
    fn visit<I: Iterator<Item = u32> + Clone>(&mut self, peer: Peer, intervals: I) {
        let (figure, checksum) = self.by_block(intervals.clone());
        self.report.sum(peer.name, figure, checksum);
        let (figure, checksum) = self.one_by_one(intervals);
        self.report.max(peer.name, figure, checksum);
    }
}

impl Timed<'_> {
    /// As they would be generated ahead of a DMA channel.
    fn by_block<I: Iterator<Item = u32>>(&self, mut intervals: I) -> (Figure, u32) {
        let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
        loop {
            let (count, cycles) = self.stopwatch.time(&mut intervals, fill_from);
            figure.add(cycles, count as u32);
            add_block(&mut checksum, count);
            if count < BLOCK_WORDS {
                return (figure, checksum.value());
            }
        }
    }

    /// As they would be generated in each step's interrupt.
    fn one_by_one<I: Iterator<Item = u32>>(&self, mut intervals: I) -> (Figure, u32) {
        let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
        while let (Some(interval), cycles) = self.stopwatch.time(&mut intervals, Iterator::next) {
            figure.add(cycles, 1);
            checksum.add(interval);
        }
        (figure, checksum.value())
    }
}

/// How many intervals there were for the block.
fn fill_from<I: Iterator<Item = u32>>(intervals: &mut I) -> usize {
    let words = BLOCK.iter().zip(intervals);
    words.map(|(word, interval)| word.store(interval, Ordering::Relaxed)).count()
}

fn add_block(checksum: &mut Checksum, count: usize) {
    for word in &BLOCK[..count] {
        checksum.add(word.load(Ordering::Relaxed));
    }
}
