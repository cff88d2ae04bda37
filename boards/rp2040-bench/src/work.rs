//! The timed pieces of work.

use core::fmt::Arguments;
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_rp::pac;
use isostep_profile::{SpeedProfile, SyncMove};
use rp2040_bench::{
    BLOCK_WORDS, Checksum, FIRST_STEPS, FLOAT_AMONG_DIVISION, FLOAT_CASES, FLOAT_DIVIDE, FLOW_CASES, PLAN_CASES, Peer,
    QUEUE_SEGMENTS, Stage, TICK_HZ, TIMED_MOVES, Timer, Visitor, first_segments, generators, phases, plan_checksum,
    ramp, segments_checksum, speed_profile_ramp,
};

use crate::report::{Figure, Report};
use crate::stopwatch::Stopwatch;

/// A bias of 0: the checksums are those of the intervals themselves.
const BIAS: u32 = 0;
const CONSTANTS_WORK: &str = "the limits are constants that work";

/// The buffer from which a port's DMA would read.
static BLOCK: [AtomicU32; BLOCK_WORDS] = [const { AtomicU32::new(0) }; BLOCK_WORDS];

/// Times the plans of moves of three axes, and their first segments.
pub fn plan(stopwatch: &Stopwatch, report: &mut Report) {
    for speed_profile in SpeedProfile::ALL {
        for case in &PLAN_CASES {
            let (plan, cycles) = stopwatch
                .time(speed_profile, |speed_profile| rp2040_bench::plan(speed_profile, case).expect(CONSTANTS_WORK));
            report.sum(format_args!("plan.{speed_profile}.{}", case.name), Figure::one(cycles), plan_checksum(&plan));
            let (segments, cycles) = stopwatch.time(&plan, first_segments);
            report.sum(
                format_args!("begin.{speed_profile}.{}", case.name),
                Figure::one(cycles),
                segments_checksum(segments),
            );
        }
    }
}

/// Times the segments of one axis through the ramp, then through those of every speed profile.
pub fn compile(stopwatch: &Stopwatch, report: &mut Report) {
    compile_ramp(stopwatch, report, &ramp().expect(CONSTANTS_WORK), format_args!("compile"));
    for speed_profile in SpeedProfile::ALL {
        let ramp = speed_profile_ramp(speed_profile).expect(CONSTANTS_WORK);
        compile_ramp(stopwatch, report, &ramp, format_args!("compile.{speed_profile}"));
        first(stopwatch, report, speed_profile, &ramp);
    }
}

/// Times the segments of the first few steps: at the beginning of a ramp, segments have the fewest steps.
fn first(stopwatch: &Stopwatch, report: &mut Report, speed_profile: SpeedProfile, ramp: &SyncMove<1>) {
    let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
    let mut steps = 0;
    let mut segments = ramp.segments(0, TICK_HZ);
    while steps < FIRST_STEPS {
        let (Some(segment), cycles) = stopwatch.time(&mut segments, Iterator::next) else { break };
        steps += segment.steps();
        figure.add(cycles, 1);
        checksum.add(segment.last_ticks() as u32);
    }
    report.sum(format_args!("compile.{speed_profile}.first"), figure, checksum);
}

/// Times segments, by the phase in which they begin.
fn compile_ramp(stopwatch: &Stopwatch, report: &mut Report, ramp: &SyncMove<1>, name: Arguments) {
    let mut segments = ramp.segments(0, TICK_HZ);
    let mut phases = phases(ramp).map(|(phase, steps)| (phase, steps, Figure::default(), Checksum::default()));
    let (mut lead, mut queue_lead) = (Lead::<1>::default(), Lead::<QUEUE_SEGMENTS>::default());
    let mut previous = None;
    for (_, steps, figure, checksum) in &mut phases {
        let mut left = *steps;
        while left > 0 {
            let (segment, cycles) = stopwatch.time(&mut segments, Iterator::next);
            let Some(segment) = segment else { break };
            left = left.saturating_sub(segment.steps());
            figure.add(cycles, 1);
            checksum.add(segment.steps());
            if let Some((first_ticks, cycles)) = previous.replace((segment.first_ticks(), cycles)) {
                let ticks = (segment.first_ticks() - first_ticks) as u32;
                lead.add(cycles, ticks);
                queue_lead.add(cycles, ticks);
            }
        }
    }
    for (phase, _, figure, checksum) in phases {
        report.sum(format_args!("{name}.{phase}"), figure, checksum);
        report.max(format_args!("{name}.{phase}"), figure, checksum);
    }
    lead.report(format_args!("{name}.lead"), report);
    queue_lead.report(format_args!("{name}.lead.queue"), report);
}

/// Finds the `N` segments in a row with the fewest ticks of motion per cycle of computing them.
struct Lead<const N: usize> {
    /// Cycles and ticks of the last `N` segments; the oldest are overwritten.
    last: [(u32, u32); N],
    seen: usize,
    worst: (u32, u32),
}

impl<const N: usize> Default for Lead<N> {
    fn default() -> Self {
        Self { last: [(0, 0); N], seen: 0, worst: (0, 0) }
    }
}

impl<const N: usize> Lead<N> {
    /// Adds a segment that took `cycles` to compute and lasts `ticks`, from its first step to that of the next segment.
    fn add(&mut self, cycles: u32, ticks: u32) {
        self.last[self.seen % N] = (cycles, ticks);
        self.seen += 1;
        let sum = self.last.iter().fold((0, 0), |sum, last| (sum.0 + last.0, sum.1 + last.1));
        let is_worse = u64::from(sum.1) * u64::from(self.worst.0) < u64::from(self.worst.1) * u64::from(sum.0);
        if self.seen >= N && (self.worst == (0, 0) || is_worse) {
            self.worst = sum;
        }
    }

    fn report(&self, name: Arguments, report: &mut Report) {
        let (cycles, ticks) = self.worst;
        let figure = Figure { cycles: cycles.into(), cycles_max: cycles, count: ticks };
        report.sum(name, figure, Checksum::default());
    }
}

/// Times short moves without stops, stage by stage.
pub fn flow(stopwatch: &Stopwatch, report: &mut Report) {
    for case in &FLOW_CASES {
        let mut timed = TimedStages { stopwatch, cycles: [0; Stage::ALL.len()] };
        let checksums = rp2040_bench::flow(case, &mut timed);
        for ((stage, cycles), checksum) in Stage::ALL.into_iter().zip(timed.cycles).zip(checksums) {
            let figure = Figure { cycles, cycles_max: 0, count: TIMED_MOVES };
            report.sum(format_args!("flow.{}.{}", case.name, stage.name()), figure, checksum);
        }
    }
}

struct TimedStages<'a> {
    stopwatch: &'a Stopwatch,
    cycles: [u64; Stage::ALL.len()],
}

impl Timer for TimedStages<'_> {
    fn time<I, R>(&mut self, stage: Stage, input: I, work: impl FnOnce(I) -> R) -> R {
        let (result, cycles) = self.stopwatch.time(input, work);
        self.cycles[stage as usize] += u64::from(cycles);
        result
    }
}

/// Times operations on floats.
pub fn floats(stopwatch: &Stopwatch, report: &mut Report) {
    for case in &FLOAT_CASES {
        let mut figure = Figure::default();
        let checksum = rp2040_bench::floats(case, |pair, work| {
            let (result, cycles) = stopwatch.time(pair, work);
            figure.add(cycles, case.operations);
            result
        });
        report.sum(format_args!("float.{}", case.name), figure, checksum);
    }
    let divide = &FLOAT_CASES[FLOAT_DIVIDE];
    let mut figure = Figure::default();
    let checksum = rp2040_bench::floats(divide, |pair, work| {
        let (result, cycles) = stopwatch.time(pair, |pair| among_division(|| work(pair)));
        figure.add(cycles, 1);
        result
    });
    report.sum(FLOAT_AMONG_DIVISION, figure, checksum);
}

/// Does `work` where an interrupt could do it: between the beginning of a division of whole numbers and its result.
/// Returns nothing if that result is lost.
fn among_division(work: impl FnOnce() -> u64) -> u64 {
    let divider = pac::SIO.div();
    divider.udividend().write_value(1_000_003);
    divider.udivisor().write_value(7);
    let result = work();
    let (remainder, quotient) = (divider.remainder().read(), divider.quotient().read());
    if (quotient, remainder) == (142_857, 4) { result } else { 0 }
}

/// Times the loop that runs per step, over the ramp and over those of every speed profile.
pub fn fill(stopwatch: &Stopwatch, report: &mut Report) {
    fill_ramp(stopwatch, report, &ramp().expect(CONSTANTS_WORK), format_args!("fill"));
    for speed_profile in SpeedProfile::ALL {
        fill_ramp(
            stopwatch,
            report,
            &speed_profile_ramp(speed_profile).expect(CONSTANTS_WORK),
            format_args!("fill.{speed_profile}"),
        );
    }
}

fn fill_ramp(stopwatch: &Stopwatch, report: &mut Report, ramp: &SyncMove<1>, name: Arguments) {
    let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
    for segment in ramp.segments(0, TICK_HZ) {
        let mut intervals = segment.intervals();
        while intervals.len() > 0 {
            let (count, cycles) = stopwatch.time(&mut intervals, |intervals| intervals.fill(&BLOCK, black_box(BIAS)));
            figure.add(cycles, count as u32);
            add_block(&mut checksum, count);
        }
    }
    report.sum(name, figure, checksum);
}

/// Times the generators of the literature.
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
    /// Times a block of intervals at once, as when they are generated ahead of a DMA channel.
    fn by_block<I: Iterator<Item = u32>>(&self, mut intervals: I) -> (Figure, Checksum) {
        let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
        loop {
            let (count, cycles) = self.stopwatch.time(&mut intervals, fill_from);
            figure.add(cycles, count as u32);
            add_block(&mut checksum, count);
            if count < BLOCK_WORDS {
                return (figure, checksum);
            }
        }
    }

    /// Times each interval, as when it is generated in the interrupt of each step.
    fn one_by_one<I: Iterator<Item = u32>>(&self, mut intervals: I) -> (Figure, Checksum) {
        let (mut figure, mut checksum) = (Figure::default(), Checksum::default());
        while let (Some(interval), cycles) = self.stopwatch.time(&mut intervals, Iterator::next) {
            figure.add(cycles, 1);
            checksum.add(interval);
        }
        (figure, checksum)
    }
}

/// Fills the block and returns the number of intervals written.
fn fill_from<I: Iterator<Item = u32>>(intervals: &mut I) -> usize {
    let words = BLOCK.iter().zip(intervals);
    words.map(|(word, interval)| word.store(interval, Ordering::Relaxed)).count()
}

fn add_block(checksum: &mut Checksum, count: usize) {
    for word in &BLOCK[..count] {
        checksum.add(word.load(Ordering::Relaxed));
    }
}
