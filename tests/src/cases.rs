//! Tests that every machine must pass, whatever makes its steps.

use crate::axes::{words, xyz_a};
use isostep_motion::{AXES, Axis};
use isostep_profile::SpeedProfile;
use isostep_report::compare::{self, Comparison};
use isostep_sim::drive::MotorData;
use isostep_sim::{Config, run};
use isostep_trials::{cases, stride};
use oorandom::Rand32;

use crate::rig::{Act, Pace, Rig, Seen, Stop};

/// Seed of the random instants at which moves are stopped and at which they start.
const SEED: u64 = 7;
/// Number of starts with the same acceleration.
const STARTS_OF_A_PACE: usize = 15;

/// Number of stops.
fn stops() -> u32 {
    cases(9, 200)
}

/// Number of moves from rest, each there and back.
fn starts() -> usize {
    cases(20, 150) as usize
}

fn relative(mm: [f64; AXES]) -> Act {
    Act::Line(format!("G91 G0 {}", words(mm)))
}

/// A wait until the machine is at rest. It is needed because settings are refused in motion, and the sender of the
/// simulated plans does not wait by itself.
fn rested() -> Act {
    Act::Line("G4 P0".to_owned())
}

fn set(pace: Pace) -> Vec<Act> {
    pace.settings().into_iter().map(Act::Line).collect()
}

/// A move is stopped at random instants, in turn by a limit switch, the emergency stop and two reset bytes. Each
/// time the machine must report the position that the edges have taken it to, and must return from there to where it
/// began.
///
/// # Panics
/// When a reported or final position is wrong.
pub fn stops_leave_the_exact_count(rig: impl Rig) {
    let mut random = Rand32::new(SEED);
    let pace = rig.pace();
    let mut acts = set(rig.pace());
    for i in 0..stops() {
        let axis = Axis::ALL[(i / 3) as usize % AXES];
        let stop = [Stop::Limit(axis), Stop::Emergency, Stop::Reset][i as usize % 3];
        acts.extend([relative(pace.away_mm), Act::WaitUs(random.rand_range(2_000..pace.lasts_us)), Act::Press(stop)]);
        // Longer than the debounce of the switches.
        acts.extend([Act::WaitUs(20_000), Act::Report, Act::Release(stop), Act::WaitUs(20_000)]);
        acts.extend([Act::Line("$X".to_owned()), Act::Line(format!("G90 G0 {}", words([0.0; AXES]))), Act::WaitIdle]);
    }
    acts.push(Act::Report);
    let seen = rig.carry_out("stops", &acts);
    assert_eq!(seen.reports.len() as u32, stops() + 1, "{rig}");
    for (i, &(t_ns, reported)) in seen.reports.iter().enumerate() {
        assert_eq!(reported, seen.counted_steps(t_ns), "{rig}, SEED={SEED}, stop {i} at {t_ns} ns");
    }
    assert_eq!(seen.counted_steps(u64::MAX), [0; AXES], "{rig}");
}

/// Moves of single steps and of many, of one axis and of all, there and back. Each step must be at its closed-form
/// instant.
///
/// # Panics
/// When a step is missing or is not at its instant.
pub fn moves_there_and_back_are_exact(rig: impl Rig) {
    let away = rig.pace().away_mm;
    let short = [[0.02, 0.0, 0.0], [0.0, -0.04, 0.02], [away[0], 0.02, 0.0], [0.02, -0.02, 0.02]];
    let ways: Vec<_> = [away].into_iter().chain(short.map(|mm| xyz_a(mm, 0.02))).collect();
    let lines: Vec<_> = ways.into_iter().flat_map(|way| [way, way.map(|mm| -mm)]).map(relative).collect();
    let mut acts = set(rig.pace());
    for line in lines {
        acts.extend([line, Act::WaitIdle, rested()]);
    }
    acts.push(Act::Report);
    let seen = rig.carry_out("there-and-back", &acts);
    assert_eq!(seen.reports[0].1, [0; AXES], "{rig}");

    let comparison = held_against_plans(&rig, &acts, &seen);
    assert!(comparison.all.max_ns <= rig.jitter_max_ns(), "{rig}: {comparison:#?}");
}

/// Moves of `pace` under each speed profile, there and back: as fast as the limits allow and in thirds, or one of the two if few
/// cases are tried. Then one speed profile in `few` is enough. Every step must be at its closed-form instant.
///
/// # Panics
/// When a step is missing or is not at its instant.
pub fn every_speed_profile_is_exact(rig: impl Rig, pace: Pace, few: usize) {
    let mut acts = set(pace);
    let of_each = cases(1, 2) as usize;
    let speed_profiles = SpeedProfile::ALL.into_iter().enumerate().step_by(stride(few));
    for (row, (number, speed_profile)) in speed_profiles.clone().enumerate() {
        let start_mm_min = if speed_profile.is_over_displacement() { pace.start_mm_min } else { 0 };
        acts.extend((910..910 + AXES).map(|start| Act::Line(format!("${start}={start_mm_min}"))));
        acts.push(Act::Line(format!("$940={number}")));
        for index in 0..of_each {
            let thirds = (index + row) % 2;
            let sign = if (of_each * row + index).is_multiple_of(2) { 1.0 } else { -1.0 };
            acts.extend([
                Act::Line(format!("$900={thirds}")),
                relative(pace.away_mm.map(|mm| sign * mm)),
                Act::WaitIdle,
            ]);
            acts.push(rested());
        }
    }
    let seen = rig.carry_out("speed profiles", &acts);
    let comparison = held_against_plans(&rig, &acts, &seen);
    assert_eq!(comparison.moves.len(), of_each * speed_profiles.len(), "{rig}");
    assert!(comparison.all.max_ns <= rig.jitter_max_ns(), "{rig}: {comparison:#?}");
}

/// A move of up to some hundred steps after a rest. Other work precedes it, and requests and lines without motion
/// follow it. One move in three begins with a cold cache.
struct Start {
    rest_us: u32,
    steps: [i32; AXES],
    index: usize,
}

impl Start {
    /// Answering these fills the cache with other code. They are refused in motion.
    const AT_REST: [&str; 5] = ["$$", "$#", "$I", "$G", "$N"];
    /// Lines that are read while the move is planned and started.
    const MEANWHILE: [&str; 5] = ["(as cold as it gets)", "G54", "G91", "G17 G21 G94", "F1000"];

    /// A random start. Most rests are short; some last nearly a second.
    fn random(random: &mut Rand32, index: usize) -> Self {
        let ratio = f64::from(random.rand_float());
        let steps = std::array::from_fn(|_| random.rand_range(1..600) as i32 - 300);
        Self { rest_us: (1e6 * ratio.powi(4)) as u32 + 1, steps, index }
    }

    fn acts(&self) -> Vec<Act> {
        let of = |lines: [&str; 5]| Act::Line(lines[self.index % lines.len()].to_owned());
        let cold = self.index.is_multiple_of(3).then_some(Act::ColdCache);
        let rest = [rested(), Act::WaitUs(self.rest_us), of(Self::AT_REST)];
        let way = relative(self.steps.map(|steps| f64::from(2 * steps) / 100.0));
        rest.into_iter().chain(cold).chain([way, Act::Ask, of(Self::MEANWHILE), Act::Ask, Act::WaitIdle]).collect()
    }
}

/// Three hundred moves from rest, half of them with the steepest acceleration for which the port is tested, after rests
/// of up to a second and with a cold cache. None may start late: every step must be within `off_max_ns` of its
/// closed-form instant.
///
/// # Panics
/// When a step is not.
pub fn cold_starts_are_exact(rig: impl Rig, off_max_ns: f64) {
    let mut random = Rand32::new(SEED);
    let mut acts = Vec::new();
    for index in 0..starts() {
        if index.is_multiple_of(STARTS_OF_A_PACE) {
            let steep = (index / STARTS_OF_A_PACE).is_multiple_of(2);
            acts.push(rested());
            acts.extend(set(if steep { rig.steep_pace() } else { rig.pace() }));
        }
        let there = Start::random(&mut random, 2 * index);
        acts.extend(there.acts());
        let back = Start { steps: there.steps.map(|steps| -steps), ..Start::random(&mut random, 2 * index + 1) };
        acts.extend(back.acts());
    }
    acts.push(Act::Report);
    let seen = rig.carry_out("cold-starts", &acts);
    assert_eq!(seen.reports.last().map(|report| report.1), Some([0; AXES]), "{rig}, SEED={SEED}");
    let comparison = held_against_plans(&rig, &acts, &seen);
    assert_eq!(comparison.moves.len(), 2 * starts(), "{rig}, SEED={SEED}");
    assert!(comparison.all.max_ns <= off_max_ns, "{rig}, SEED={SEED}: {:?}", comparison.all);
}

/// Compares every step with the plan of the same lines in simulation.
fn held_against_plans(rig: &impl Rig, acts: &[Act], seen: &Seen) -> Comparison {
    let program =
        acts.iter().filter_map(|act| if let Act::Line(line) = act { Some(format!("{line}\n")) } else { None });
    let config = Config { motor: MotorData::RIGID, port: rig.port(), ..Config::default() };
    let planned = run(program.collect::<String>().as_bytes(), &config).expect("a program");
    assert!(planned.refusals.is_empty(), "{rig}: {:?}", planned.refusals);
    compare::compare(&planned, &seen.edges).unwrap_or_else(|error| panic!("{rig}: {error}"))
}

/// Moves up to `top_mm_min`, the highest rate that the step port accepts, at twenty accelerations. None may be refused
/// half-way as too fast.
///
/// # Panics
/// When a move is refused.
pub fn the_highest_rate_is_made(rig: impl Rig, top_mm_min: u32) {
    let mut acts = vec![Act::Line(format!("$110={top_mm_min}"))];
    let accelerations = (0..20).step_by(stride(5)).map(|i| 81_907 + i * 911);
    for accel_mm_s2 in accelerations.clone() {
        acts.push(Act::Line(format!("$120={accel_mm_s2}")));
        acts.extend([310.0, -310.0].map(|x_mm| relative(xyz_a([x_mm, 0.0, 0.0], 0.0))));
        acts.extend([Act::WaitIdle, Act::Report]);
    }
    let seen = rig.carry_out("highest-rate", &acts);
    assert!(seen.reports.iter().all(|(_, steps)| *steps == [0; AXES]), "{rig}: {:?}", seen.reports);
    assert_eq!(seen.edges.len(), accelerations.count() * 2 * 15_500, "{rig}");
}

/// Groups of single steps, so slow that half a step takes 15 ms. Each move must last as long as its plan, and the next
/// must begin then.
///
/// # Panics
/// When a move begins before the previous plan has ended, or more than `late_max_us` after.
pub fn single_steps_take_as_long_as_planned(rig: impl Rig, late_max_us: f64) {
    /// As many moves as fit in the queue.
    const MOVES: usize = 15;
    const GROUPS: usize = 4;
    let step = Act::Line("G91 G1 X0.02 F40".to_owned());
    let group = [vec![step; MOVES], vec![Act::WaitIdle]].concat();
    let acts = vec![group; GROUPS].concat();
    let seen = rig.carry_out("single-steps", &acts);
    let comparison = held_against_plans(&rig, &acts, &seen);
    for (index, each) in comparison.moves.iter().enumerate().skip(1) {
        let pause_ns = each.pause_ns.expect("a move before it");
        assert!(pause_ns >= -rig.jitter_max_ns(), "{rig}: move {index} began {pause_ns} ns after the plan before it");
        // The first move of a group waited for its line, so it may begin late.
        assert!(index % MOVES == 0 || pause_ns <= late_max_us * 1e3, "{rig}: move {index} began {pause_ns} ns late");
    }
}
