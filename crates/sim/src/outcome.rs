//! The result of a run.

use isostep_motion::{AXES, Axis, Capabilities, Event, Kinematics, Machine, State, ToolConfig};
use isostep_profile::{Blend, Limits, SpeedProfile};

use crate::config::Config;
use crate::driver::Violation;
pub use crate::moves::MoveRecord;
use crate::program::Program;
use crate::record::{Edge, Loss, Record, Wave};
use crate::stream::{Dialogue, Pause, Refusal, Said};
use crate::tool::ToolChange;
use crate::world::World;

/// The result of a run: everything recorded, and the final state.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// The configuration that was simulated.
    pub config: Config,
    /// Every step, in order.
    pub edges: Vec<Edge>,
    /// Every change of every wire, in order.
    pub waves: Vec<Wave>,
    /// Every change of the tool's outputs, in order.
    pub tool: Vec<ToolChange>,
    /// Configuration of the tool at the end.
    pub tool_config: ToolConfig,
    /// The levels of the limit inputs at power-up.
    pub limits_high_at_start: [bool; AXES],
    /// Every move that ended, in order.
    pub moves: Vec<MoveRecord>,
    /// The capabilities of the port of each axis.
    pub capabilities: [Option<Capabilities>; AXES],
    /// Configurations that the moves were planned with; each applies from the run with that number on.
    pub configs: Vec<(usize, isostep_motion::Config)>,
    /// Every event except those about moves, with its instant in ns since power-up.
    pub events: Vec<(u64, Event)>,
    /// The lines of the program.
    pub program: Program,
    /// Number of lines sent.
    pub lines_sent: usize,
    /// Everything that the controller sent to the sender except `ok` and `error:N`.
    pub said: Vec<Said>,
    /// The lines that the controller refused.
    pub refusals: Vec<Refusal>,
    /// The lines that waited for the operator and were resumed.
    pub pauses: Vec<Pause>,
    /// The number after `ALARM:`, if the console reported one.
    pub alarm_code: Option<u8>,
    /// True if sending stopped before the program's end.
    pub cut_short: bool,
    /// Every edge that a driver may misread.
    pub violations: Vec<Violation>,
    /// Every step that a carriage did not make.
    pub losses: Vec<Loss>,
    /// What the motors do for the axes to move. Where an axis does not have a motor of its own, what is said here of the edges, the plans
    /// and the limits of an axis is said of the motor with its name.
    pub kinematics: Kinematics,
    /// Each axis's position according to the controller, steps.
    pub position_steps: [i32; AXES],
    /// The same of the motors.
    pub motor_steps: [i32; AXES],
    /// The number of edges per motor, from power-up or since its axis was homed.
    pub counted_steps: [i32; AXES],
    /// The controller's position in mm.
    pub position_mm: [f64; AXES],
    /// True position of each carriage, steps from where its limit switch closes.
    pub places_steps: [i32; AXES],
    /// Distance of each carriage from its position by the count of edges, steps.
    pub drift_steps: [i32; AXES],
    /// The distance of the field of each motor beyond an end stop that blocks the carriage, steps: they are not lost yet. Only
    /// where the drivers have a UART.
    pub ahead_steps: [i32; AXES],
    /// The second motor of an axis.
    pub second: Option<SecondAtEnd>,
    /// The machine's final state.
    pub state: State,
    /// Its resolution at the end, steps/mm along a path in the direction of each motor.
    pub steps_per_mm: [f64; AXES],
    /// The resolution of its axes at the end, steps/mm.
    pub axis_steps_per_mm: [f64; AXES],
    /// The limits of its axes at the end, steps of the axes. With crossed belts and unlike shapers they are lower than what is set.
    pub axis_limits: [Limits; AXES],
    /// Its travel at the end, mm.
    pub travel_mm: [f64; AXES],
    /// The limits of its motors at the end.
    pub limits: [Limits; AXES],
    /// `$11` at the end: the deviation of the circle that determines the speed at a corner, mm.
    pub junction_deviation_mm: f64,
    /// Its speed profile at the end.
    pub speed_profile: SpeedProfile,
    /// Virtual time from power-up to rest.
    pub duration_ns: u64,
    /// Time from the start of the first move to the end of the last one's plan, including pauses and homing, s; 0
    /// without a move.
    pub motion_s: f64,
}

/// The second motor of an axis at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SecondAtEnd {
    /// The axis that has the motor.
    pub axis: Axis,
    /// Distance of the ganged motor from its position by the count of edges, steps.
    pub drift_steps: i32,
    /// The distance that it is farther from its switch than the first motor, beyond the offset, steps.
    pub off_square_steps: i32,
}

/// The limits of the axes in a program.
fn axis_limits(config: &isostep_motion::Config) -> [Limits; AXES] {
    let mut limits = config.limits;
    if config.kinematics == Kinematics::CoreXy {
        limits[..2].copy_from_slice(&config.crossed_limits(config.shaping().as_ref()));
    }
    limits
}

fn second_at_end(world: &World, config: &isostep_motion::Config) -> Option<SecondAtEnd> {
    let (axis, squared) = (world.second_axis()?, config.squared);
    let offset_mm =
        squared.filter(|squared| Some(squared.axis) == world.second_axis()).map(|squared| squared.offset_mm);
    let farther_steps = world.second_place_steps()? - world.places_steps()[axis as usize];
    let off_square_steps = farther_steps - offset_mm.map_or(farther_steps, |mm| config.steps(axis, mm));
    Some(SecondAtEnd { axis, drift_steps: world.second_drift_steps()?, off_square_steps })
}

impl Outcome {
    /// The alarm at the end, in the console's words, with the remedy.
    #[must_use]
    pub fn alarm(&self) -> Option<String> {
        let State::Alarm(alarm) = self.state else { return None };
        let (code, what) = isostep_controller::alarm_code(alarm);
        Some(code.about(what).to_string())
    }

    /// The final state in words.
    #[must_use]
    pub fn state_words(&self) -> String {
        self.alarm().map_or(self.state.to_string(), |alarm| format!("{}: {alarm}", self.state))
    }

    pub(crate) fn new(
        config: &Config,
        world: &World,
        mut record: Record,
        machine: &Machine,
        (program, dialogue): (Program, Dialogue),
        duration_ns: u64,
    ) -> Self {
        // With its blocking delay, a task runs ahead of the tasks polled after it, so waves may be out of order. They
        // are usually in order, and sorting would take memory.
        if !record.waves.is_sorted_by_key(|wave| wave.t_ns) {
            record.waves.sort_by_key(|wave| wave.t_ns);
        }
        sort_edges(&mut record.edges);
        let axes_config = machine.config();
        let machine_config = axes_config.of_motors();
        let (moves, configs) = record.moves.into_records();
        let position_steps = machine.position_steps();
        Self {
            kinematics: axes_config.kinematics,
            config: config.clone(),
            moves: with_edges(moves, &mut record.edges, config.port.tolerance_ns(), record.continues),
            capabilities: machine.capabilities(),
            configs,
            edges: record.edges,
            waves: record.waves,
            tool: record.tool,
            tool_config: machine_config.tool,
            events: record.events,
            program,
            lines_sent: dialogue.sent,
            said: dialogue.said,
            refusals: dialogue.refusals,
            pauses: dialogue.pauses,
            alarm_code: dialogue.alarm,
            cut_short: dialogue.cut_short,
            limits_high_at_start: world.limits_high_at_start(),
            violations: record.violations,
            losses: record.losses,
            position_steps,
            motor_steps: machine.motor_steps(),
            counted_steps: world.counted_steps(),
            position_mm: axes_config.mm_at(machine.motor_steps()),
            places_steps: world.places_steps(),
            drift_steps: world.drift_steps(),
            ahead_steps: world.ahead_steps(),
            second: second_at_end(world, &axes_config),
            state: machine.state(),
            steps_per_mm: machine_config.steps_per_mm,
            axis_steps_per_mm: axes_config.steps_per_mm,
            axis_limits: axis_limits(&axes_config),
            travel_mm: machine_config.travel_mm,
            limits: machine_config.limits,
            junction_deviation_mm: machine_config.junction_deviation_mm,
            speed_profile: machine_config.speed_profile,
            duration_ns,
            motion_s: world.motion_s(),
        }
    }

    /// The configuration that a move was planned with.
    ///
    /// # Panics
    /// If the move is from another outcome.
    pub fn config_of(&self, record: &MoveRecord) -> &isostep_motion::Config {
        let known = self.configs.partition_point(|(run, _)| *run <= record.run);
        &self.configs[known - 1].1
    }

    /// The moves of the program, in order: all but those of homing.
    pub fn program_moves(&self) -> impl DoubleEndedIterator<Item = &MoveRecord> + Clone {
        self.moves.iter().filter(|record| !record.homing)
    }

    /// The number of a move of the program, from 1, by its index in [`moves`](Self::moves).
    pub fn move_number(&self, index: usize) -> usize {
        self.moves[..=index].iter().filter(|record| !record.homing).count()
    }

    /// The runs of the program, in order: each the moves that follow each other without a pause, with the index of the first.
    pub fn runs(&self) -> impl Iterator<Item = (usize, &[MoveRecord])> {
        let mut end = 0;
        let runs = self.moves.chunk_by(|one, next| one.run == next.run).map(move |run| {
            end += run.len();
            (end - run.len(), run)
        });
        runs.filter(|(_, run)| !run[0].homing)
    }

    /// The edges of a move.
    pub fn edges_of(&self, record: &MoveRecord) -> &[Edge] {
        &self.edges[record.edges.clone()]
    }

    /// The edges of a run.
    pub fn edges_of_run(&self, moves: &[MoveRecord]) -> &[Edge] {
        &self.edges[moves[0].edges.start..moves[moves.len() - 1].edges.end]
    }

    /// The texts that the controller sent in `[MSG:...]`, in order.
    pub fn messages(&self) -> impl Iterator<Item = &str> {
        self.said.iter().filter_map(|said| said.text.strip_prefix("[MSG:")?.strip_suffix(']'))
    }

    /// Time spent homing, ns.
    pub fn homing_ns(&self) -> u64 {
        self.homing().map(|(from_ns, to_ns)| to_ns - from_ns).sum()
    }

    /// When it homed: from and to, ns since power-up.
    fn homing(&self) -> impl Iterator<Item = (u64, u64)> {
        let mut began_ns = None;
        self.events.iter().filter_map(move |&(t_ns, event)| match event {
            Event::State(State::Home) => {
                began_ns = Some(t_ns);
                None
            }
            Event::State(_) => began_ns.take().map(|began_ns| (began_ns, t_ns)),
            _ => None,
        })
    }

    /// Time that the program waits before its first move and after its last one, for dwells and until a spindle has its
    /// speed, without homing, s. Without a move, all of it is before. What follows ends when the motors are freed (`$1`).
    pub fn waits_s(&self) -> [f64; 2] {
        let first_ns = self.program_moves().next().map_or(u64::MAX, MoveRecord::begin_ns);
        let last_ns =
            self.program_moves().next_back().map_or(u64::MAX, |last| last.start_ns + (last.plan_s * 1e9) as u64);
        let within = |begin_ns: u64, end_ns: u64| {
            let homing = self.homing().map(|(from_ns, to_ns)| to_ns.min(end_ns).saturating_sub(from_ns.max(begin_ns)));
            end_ns.saturating_sub(begin_ns).saturating_sub(homing.sum()) as f64 * 1e-9
        };
        [within(0, first_ns.min(self.duration_ns)), within(last_ns, self.duration_ns)]
    }

    /// The results of its probing moves, each with its line: `[PRB:...]`.
    pub fn probes(&self) -> impl Iterator<Item = &Said> {
        self.said.iter().filter(|said| said.text.starts_with("[PRB:"))
    }

    /// The position of the axes where the motors are at these steps, mm.
    pub fn mm(&self, motors_steps: [i32; AXES]) -> [f64; AXES] {
        self.mm_of(motors_steps.map(f64::from))
    }

    /// The same for what need not be whole: places, ways, speeds or accelerations of the motors.
    pub fn mm_of(&self, motors_steps: [f64; AXES]) -> [f64; AXES] {
        let steps = self.kinematics.axes_of(motors_steps);
        std::array::from_fn(|axis| steps[axis] / self.axis_steps_per_mm[axis])
    }

    /// What the motor of an axis is called where only that axis could be meant otherwise.
    pub fn motor_name(&self, axis: usize) -> String {
        let axis = Axis::ALL[axis];
        if self.kinematics.is_shared(axis) { format!("motor of {axis}") } else { axis.to_string() }
    }

    /// The millimetres of belt or screw that a motor turns for a millimetre of path in its direction: √2 with crossed belts.
    pub fn turned_mm(&self, motor: usize) -> f64 {
        self.steps_per_mm[motor] / self.axis_steps_per_mm[motor]
    }

    /// The position of the axes by the configuration that a move was planned with.
    pub fn mm_of_move(&self, record: &MoveRecord, motors_steps: [f64; AXES]) -> [f64; AXES] {
        let steps_per_mm = self.config_of(record).steps_per_mm;
        self.kinematics.along_axes(std::array::from_fn(|motor| motors_steps[motor] / steps_per_mm[motor]))
    }

    /// The true position of each carriage, mm from where its limit switch closes.
    pub fn carriage_mm(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| f64::from(self.places_steps[axis]) / self.axis_steps_per_mm[axis])
    }

    /// The speed along the path in a blend at `t_s` from the start of its run, mm/s.
    pub fn blend_mm_s(&self, blend: &Blend<AXES>, t_s: f64) -> f64 {
        let squares = (0..AXES).map(|axis| (blend.speed_at(axis, t_s) / self.steps_per_mm[axis]).powi(2));
        squares.sum::<f64>().sqrt()
    }
}

/// Puts edges in the order of their instants, in which they usually are.
pub(crate) fn sort_edges(edges: &mut [Edge]) {
    if !edges.is_sorted_by_key(|edge| edge.t_ns) {
        edges.sort_by_key(|edge| edge.t_ns);
    }
}

/// Assigns to each move all edges from its beginning to that of the next, including any that should not have risen. In a
/// shaped run that is when the axes, which are late, come there.
///
/// Around a corner that is a blend, edges of both moves may rise within the tolerance of instants. There they are put in the
/// order of the moves, each axis's edges in theirs. If the record `continues` an earlier one, the first move has all edges
/// before those of the second.
fn with_edges(mut moves: Vec<MoveRecord>, edges: &mut [Edge], tolerance_ns: f64, continues: bool) -> Vec<MoveRecord> {
    let mut last = edges.len();
    for index in (0..moves.len()).rev() {
        let first = if index == 0 && continues { 0 } else { first_edge(&moves, index, edges, tolerance_ns) };
        moves[index].edges = first..last;
        last = first;
    }
    moves
}

/// The index of the first edge of a move.
pub(crate) fn first_edge(moves: &[MoveRecord], index: usize, edges: &mut [Edge], tolerance_ns: f64) -> usize {
    match index.checked_sub(1) {
        Some(before) if moves[index].blend.is_some() && moves[index].shaping.is_none() => {
            split_at_blend([&moves[before], &moves[index]], edges, tolerance_ns)
        }
        _ => {
            // The first move of a run has all edges from its start on.
            let is_first = index == 0 || moves[index - 1].run != moves[index].run;
            let from_ns = if is_first { moves[index].begin_ns() } else { moves[index].reached_ns() };
            edges.partition_point(|edge| edge.t_ns < from_ns)
        }
    }
}

/// Puts the edges of the first move before those of the second one, and returns where these begin.
fn split_at_blend([before, after]: [&MoveRecord; 2], edges: &mut [Edge], tolerance_ns: f64) -> usize {
    let begin_ns = after.begin_ns();
    let window_ns = (2.0 * tolerance_ns) as u64 + 2;
    let from = edges.partition_point(|edge| edge.t_ns + window_ns < begin_ns);
    let to = edges.partition_point(|edge| edge.t_ns <= begin_ns + window_ns);
    let due_ns = |record: &MoveRecord, due_s: f64| record.start_ns as f64 + due_s * 1e9;
    let is_before = |edge: &Edge| {
        let off_ns = |due_ns: Option<f64>| due_ns.map_or(f64::INFINITY, |due_ns| (edge.t_ns as f64 - due_ns).abs());
        let first_ns = after.due_s(edge.axis).next().map(|(due_s, _)| due_ns(after, due_s));
        let last_ns = before.last_due_s(edge.axis).map(|due_s| due_ns(before, due_s));
        off_ns(last_ns) < off_ns(first_ns)
    };
    edges[from..to].sort_by_key(|edge| !is_before(edge));
    from + edges[from..to].iter().filter(|edge| is_before(edge)).count()
}
