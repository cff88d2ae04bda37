//! The cost of a short move in a sequence of moves without stops, from the bytes of its line to the segments of its
//! axes. All computations for the move are timed, stage by stage, with a chain as long as the firmware's.
//!
//! Not included: the tasks that pass a move on, its queue, the conversion of millimetres to steps, and the steps
//! themselves.

use core::fmt::{self, Write};

use isostep_console::{Block, Command, Interpreter, LineAssembler, ReportedState, Settings, length};
use isostep_profile::chain::{Chain, ChainConfig, Chunk, Plan, Request};
use isostep_profile::shaper::{Shaper, ShaperKind};
use isostep_profile::{AxisCompiler, CountedPhase, IntervalSplit, Limits, OFFSET_PARTS, SpeedProfile, TimedPlan};

use crate::shaped::ShapedAxes;
use crate::{AXES, Checksum, TICK_HZ};

/// Capacity of the chain, in moves.
const CHAIN_MOVES: usize = 64;
/// Number of timed moves. They are timed once the chain is full.
pub const TIMED_MOVES: u32 = 192;
/// Length of a move.
pub const MOVE_MM: f64 = 0.2;
/// The place where the moves begin, on every axis. It is large enough to keep all coordinates above 0.
pub const START_MM: f64 = 500.0;
/// So long that every chunk is all the rest of its plan.
const CHUNK_MAX_S: f64 = 1.0;

/// This constant and the next ones are those of machine C of `programs/machines`.
pub const STEPS_PER_MM: f64 = 80.0;
const CORNER_DEVIATION_MM: f64 = 0.01;
const FEED_MM_S: f64 = 200.0;
/// The deviation of blends from their corners, and the feed then: the curve could be taken at 130 mm/s.
const BLEND_DEVIATION_MM: f32 = 0.05;
const BLEND_FEED_MM_S: f64 = 100.0;
const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: FEED_MM_S * STEPS_PER_MM,
    accel_steps_s2: 2_000.0 * STEPS_PER_MM,
    decel_steps_s2: 2_000.0 * STEPS_PER_MM,
    jerk_steps_s3: 100_000.0 * STEPS_PER_MM,
};

/// The stages of the work for a move, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Interpret the bytes of the line.
    Read,
    /// Push the move into the chain, which updates the speeds at its corners.
    Push,
    /// Plan the move when its turn has come, and hand out a chunk.
    Advance,
    /// Add up what a shaper makes of it, for all axes; nothing without one.
    Shape,
    /// Compile the segments of all axes.
    Compile,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 5] = [Self::Read, Self::Push, Self::Advance, Self::Shape, Self::Compile];

    /// The name in the firmware's output lines.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Push => "push",
            Self::Advance => "advance",
            Self::Shape => "shape",
            Self::Compile => "compile",
        }
    }
}

/// A sequence of moves of 0.2 mm without stops.
#[derive(Clone, Copy, Debug)]
pub struct FlowCase {
    /// The name in the firmware's output lines.
    pub name: &'static str,
    /// The speed profile of its ramps.
    pub speed_profile: SpeedProfile,
    /// After how many moves the path turns by a right angle; otherwise it is a curve.
    corner_moves: u32,
    /// True if its corners are blends.
    has_blends: bool,
    /// The shaper of every axis.
    shaper: Option<Shaper>,
}

impl FlowCase {
    const fn exact(name: &'static str, speed_profile: SpeedProfile, corner_moves: u32) -> Self {
        Self { name, speed_profile, corner_moves, has_blends: false, shaper: None }
    }

    const fn blended(name: &'static str, corner_moves: u32) -> Self {
        Self { has_blends: true, ..Self::exact(name, SpeedProfile::Trapezoid, corner_moves) }
    }

    const fn shaped(name: &'static str, kind: ShaperKind, natural_hz: f64) -> Self {
        Self { shaper: Some(Shaper { kind, natural_hz, damping_ratio: 0.05 }), ..Self::blended(name, u32::MAX) }
    }

    /// True if a shaper makes several pieces of a move.
    #[must_use]
    pub const fn is_shaped(&self) -> bool {
        self.shaper.is_some()
    }
}

/// The first case is at full speed, the second always on ramps. The next two have blends instead, and the two after them
/// shapers as well. A curved speed profile has its ramps within a move. With a corner after each move it has two in every move,
/// which costs most.
pub const FLOW_CASES: [FlowCase; 13] = [
    FlowCase::exact("trapezoid.curve", SpeedProfile::Trapezoid, u32::MAX),
    FlowCase::exact("trapezoid.corners", SpeedProfile::Trapezoid, 24),
    FlowCase::blended("blends.curve", u32::MAX),
    FlowCase::blended("blends.corners", 24),
    FlowCase::shaped("zv.curve", ShaperKind::Zv, 40.0),
    FlowCase::shaped("box.curve", ShaperKind::Box, 100.0),
    FlowCase::exact("s-curve.curve", SpeedProfile::SCurve, u32::MAX),
    FlowCase::exact("s-curve.turns", SpeedProfile::SCurve, 1),
    FlowCase::exact("sine.turns", SpeedProfile::Sine, 1),
    FlowCase::exact("linear.turns", SpeedProfile::Linear, 1),
    FlowCase::exact("quadratic.turns", SpeedProfile::Quadratic, 1),
    FlowCase::exact("sinusoidal.turns", SpeedProfile::Sinusoidal, 1),
    FlowCase::exact("logarithmic.turns", SpeedProfile::Logarithmic, 1),
];

/// Times the stages, or only runs them.
pub trait Timer {
    /// Runs `work` on `input` and returns its result. The work is `stage` of a move, or a part of that stage.
    fn time<I, R>(&mut self, stage: Stage, input: I, work: impl FnOnce(I) -> R) -> R;
}

/// The checksum of each stage's results, in order.
pub type Checksums = [Checksum; Stage::ALL.len()];

/// Streams the moves of `case` through all stages. Only moves that meet a full chain are timed.
pub fn flow(case: &FlowCase, timer: &mut impl Timer) -> Checksums {
    let mm_per_step = [1.0 / STEPS_PER_MM; AXES];
    // The speed profiles over displacement cannot start from standstill.
    let start_speed_steps_s = if case.speed_profile.is_over_displacement() { STEPS_PER_MM } else { 0.0 };
    let limits = Limits { start_speed_steps_s, ..LIMITS };
    let config =
        ChainConfig::new([limits; AXES], mm_per_step, CORNER_DEVIATION_MM, IntervalSplit::Fastest, case.speed_profile);
    let mut flow = Flow {
        feed_mm_s: if case.has_blends { BLEND_FEED_MM_S } else { FEED_MM_S },
        deviation_mm: if case.has_blends { BLEND_DEVIATION_MM } else { 0.0 },
        shaped: case.shaper.map(|shaper| ShapedAxes::new(&shaper, limits.top_speed_steps_s)),
        path: Path::new(case),
        interpreter: Interpreter::new(),
        chain: Chain::new(config),
        steps: [whole_steps(START_MM); AXES],
        timed_plan: TimedPlan::empty(),
        checksums: Checksums::default(),
    };
    flow.interpreter.set_position_pm([length::from_mm(START_MM); AXES]);
    let _ = read(&mut flow.interpreter, b"G90F12000\n");
    for _ in 0..CHAIN_MOVES {
        flow.enter(&mut Untimed);
    }
    // Let the machine accelerate from rest.
    for _ in 0..CHAIN_MOVES {
        flow.leave(&mut Untimed);
        flow.enter(&mut Untimed);
    }
    flow.checksums = Checksums::default();
    for _ in 0..TIMED_MOVES {
        flow.leave(timer);
        flow.enter(timer);
    }
    flow.checksums
}

/// A timer that only runs the work.
pub struct Untimed;

impl Timer for Untimed {
    fn time<I, R>(&mut self, _: Stage, input: I, work: impl FnOnce(I) -> R) -> R {
        work(input)
    }
}

struct Flow {
    feed_mm_s: f64,
    /// The distance by which the path may leave corners.
    deviation_mm: f32,
    shaped: Option<ShapedAxes>,
    path: Path,
    interpreter: Interpreter,
    chain: Chain<AXES, CHAIN_MOVES>,
    /// End position of the last move.
    steps: [i32; AXES],
    /// The timed plan of the last compiled chunk.
    timed_plan: TimedPlan,
    checksums: Checksums,
}

impl Flow {
    /// Reads the line of the next move and pushes the move to the end of the chain.
    fn enter(&mut self, timer: &mut impl Timer) {
        let line = self.path.next_line();
        let interpreter = &mut self.interpreter;
        let block =
            timer.time(Stage::Read, (interpreter, line.bytes()), |(interpreter, bytes)| read(interpreter, bytes));
        let Some(target_pm) = block.and_then(|block| block.motion).map(|motion| motion.target_pm) else { return };
        target_pm.iter().for_each(|&pm| self.note(Stage::Read, pm as u32));
        let target_mm = target_pm.map(length::to_mm);
        let target_steps = target_mm.map(whole_steps);
        let beside_steps = |axis: usize| target_mm[axis] * STEPS_PER_MM - f64::from(target_steps[axis]);
        let offset = |axis: usize| (beside_steps(axis) * f64::from(OFFSET_PARTS)) as i8;
        let offsets = [0, 1, 2].map(|axis| if self.deviation_mm > 0.0 { offset(axis) } else { 0 });
        let steps = [0, 1, 2].map(|axis| target_steps[axis] - self.steps[axis]);
        self.steps = target_steps;
        let request = Request {
            steps,
            offsets,
            feed_mm_s: Some(self.feed_mm_s),
            stops: false,
            deviation_mm: self.deviation_mm,
            reach_mm: 0.0,
            least_s: 0.0,
            tag: 0,
        };
        let pushed = timer.time(Stage::Push, (&mut self.chain, request), |(chain, request)| chain.push(request));
        self.note(Stage::Push, u32::from(pushed.is_ok()));
    }

    /// Hands out the first move of the chain to its end, and compiles it.
    fn leave(&mut self, timer: &mut impl Timer) {
        let before = self.chain.len();
        while self.chain.len() == before {
            let chunk = timer.time(Stage::Advance, &mut self.chain, |chain| chain.advance(CHUNK_MAX_S));
            let Some(chunk) = chunk else { return };
            self.note(Stage::Advance, (chunk.until_s * f64::from(TICK_HZ)) as u64 as u32);
            if self.shaped.is_some() {
                self.shape(chunk, timer);
                continue;
            }
            let mut compiled = Checksum::default();
            let stage = (&chunk, &mut self.timed_plan, &mut compiled);
            timer.time(Stage::Compile, stage, |(chunk, timed_plan, compiled)| compile(chunk, timed_plan, compiled));
            self.note(Stage::Compile, compiled.value());
        }
    }

    /// Adds up what the shapers make of a chunk, and compiles it.
    fn shape(&mut self, chunk: Chunk<AXES>, timer: &mut impl Timer) {
        let Some(shaped) = &mut self.shaped else { return };
        let (mut summed, mut compiled) = (Checksum::default(), Checksum::default());
        for axis in 0..AXES {
            let input = (&mut *shaped, &chunk);
            timer.time(Stage::Shape, input, |(shaped, chunk)| shaped.read(axis, chunk));
            while let Some(phase) = timer.time(Stage::Shape, &mut *shaped, |shaped| shaped.next_phase(axis)) {
                summed.add(phase.step_counts().0);
                if phase.step_counts().0 > 0 {
                    let input = (&phase, &mut compiled);
                    timer.time(Stage::Compile, input, |(phase, compiled)| compile_phase(phase, compiled));
                }
            }
        }
        shaped.have_read(chunk);
        self.note(Stage::Shape, summed.value());
        self.note(Stage::Compile, compiled.value());
    }

    fn note(&mut self, stage: Stage, word: u32) {
        self.checksums[stage as usize].add(word);
    }
}

/// Reads a line byte by byte, as it comes from a console.
fn read(interpreter: &mut Interpreter, bytes: &[u8]) -> Option<Block> {
    let mut assembler = LineAssembler::new();
    let (end, text) = bytes.split_last()?;
    for byte in text {
        let _ = assembler.push(*byte);
    }
    let line = assembler.push(*end)?.ok()?;
    match interpreter.interpret(line, ReportedState::Run, &Settings::DEFAULT) {
        Ok(Command::Block(block)) => Some(block),
        _ => None,
    }
}

fn compile(chunk: &Chunk<AXES>, timed_plan: &mut TimedPlan, compiled: &mut Checksum) {
    let line = match &chunk.plan {
        Plan::Line(line) => line,
        Plan::Blend(blend) => {
            let phases = |axis| [0, 1].into_iter().filter_map(move |index| blend.counted_phase(axis, index));
            let phases = (0..AXES).flat_map(phases).filter(|phase| phase.step_counts().0 > 0);
            return phases.for_each(|phase| compile_phase(&phase, compiled));
        }
    };
    line.convert_to_ticks(timed_plan, TICK_HZ);
    let mut compilers = [0, 1, 2].map(|axis| line.compiler(axis, timed_plan));
    let mut fed_ticks = [Some(0); AXES];
    // The axis with the least motion compiled is next, as in the firmware.
    while let Some(axis) = (0..AXES).filter(|axis| fed_ticks[*axis].is_some()).min_by_key(|axis| fed_ticks[*axis]) {
        let segment = compilers[axis].next(timed_plan);
        if let Some(segment) = segment {
            compiled.add(segment.steps());
            compiled.add(segment.last_ticks() as u32);
        }
        fed_ticks[axis] = segment.map(|segment| segment.last_ticks());
    }
}

fn compile_phase(phase: &CountedPhase, compiled: &mut Checksum) {
    let mut compiler = AxisCompiler::empty();
    compiler.begin_phase(phase, TICK_HZ);
    while let Some(segment) = compiler.next_of_phase() {
        compiled.add(segment.steps());
        compiled.add(segment.last_ticks() as u32);
    }
}

/// Rounds a value above 0 to the nearest step.
fn whole_steps(mm: f64) -> i32 {
    (mm * STEPS_PER_MM + 0.5) as i32
}

/// The moves of a case, in order.
pub struct Path {
    corner_moves: u32,
    made: u32,
    place_mm: [f64; AXES],
    /// Direction in X and Y, and the angle by which Z leans; both are unit vectors that turn slowly.
    heading: [f64; 2],
    lean: [f64; 2],
}

impl Path {
    /// A path that begins at [`START_MM`] on every axis.
    #[must_use]
    pub fn new(case: &FlowCase) -> Self {
        let corner_moves = case.corner_moves;
        Self { corner_moves, made: 0, place_mm: [START_MM; AXES], heading: [1.0, 0.0], lean: [1.0, 0.0] }
    }

    /// End position of the last move whose line was made, in steps of [`STEPS_PER_MM`].
    #[must_use]
    pub fn place_steps(&self) -> [i32; AXES] {
        self.place_mm.map(|mm| whole_steps(f64::from(thousandths(mm)) / 1_000.0))
    }

    /// The line of the next move, whose length is [`MOVE_MM`].
    pub fn next_line(&mut self) -> Text {
        self.made += 1;
        self.heading = turned(self.heading, [0.9998, 0.02]);
        self.lean = turned(self.lean, [0.9996, 0.028]);
        if self.made.is_multiple_of(self.corner_moves) {
            self.heading = turned(self.heading, [0.0, 1.0]);
        }
        let ([x, y], [lean, _]) = (self.heading, self.lean);
        let way = [0.9 * x, 0.9 * y, 0.4 * lean];
        self.place_mm = [0, 1, 2].map(|axis| self.place_mm[axis] + MOVE_MM * way[axis]);
        Text::of(self.place_mm)
    }
}

/// Rotates a vector by the angle with this cosine and sine.
fn turned([x, y]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 2] {
    [x * cos - y * sin, x * sin + y * cos]
}

/// Whole thousandths of a millimetre, the resolution of a line.
fn thousandths(mm: f64) -> u32 {
    (mm * 1_000.0 + 0.5) as u32
}

/// A line of a program, including its line end.
pub struct Text {
    bytes: [u8; 48],
    len: usize,
}

impl Text {
    fn of(place_mm: [f64; AXES]) -> Self {
        let mut line = Self { bytes: [0; 48], len: 0 };
        for (axis, mm) in ["G1X", "Y", "Z"].into_iter().zip(place_mm) {
            let thousandths = thousandths(mm);
            // The line always fits into the buffer.
            let _ = write!(line, "{axis}{}.{:03}", thousandths / 1_000, thousandths % 1_000);
        }
        let _ = line.write_str("\n");
        line
    }

    /// The bytes of the line, including its line end.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = self.bytes.get_mut(self.len..self.len + text.len()).ok_or(fmt::Error)?;
        room.copy_from_slice(text.as_bytes());
        self.len += text.len();
        Ok(())
    }
}
