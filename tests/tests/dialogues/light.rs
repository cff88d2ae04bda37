//! The light of a laser on each piece of a path, over whole programs with overrides, against the rule of docs/tool.md.

use embassy_time::Duration;
use isostep_motion::State;
use isostep_sim::lines_of_moves::sections;
use isostep_sim::tool::ToolOutput;
use isostep_sim::{Config, MoveRecord, Outcome, Sim};
use isostep_trials::cases;
use oorandom::Rand32;

use crate::talk::{ON, homed, powered_up, say};

/// The path is compared piece by piece, mm.
const PIECE_MM: f64 = 0.25;
/// The interval in which the plan is summed up, s.
const SAMPLE_S: f64 = 20e-6;
/// The time between two settings of a level that changes, s.
const UPDATE_S: f64 = 500e-6;
/// Resolution of levels and duties together, each rounded once or twice, and at 200 % the first of them doubled.
const LEVELS: f64 = 8.0 / 65_535.0;
/// Resolution of the instants at which a piece of the path, a move and a stroke begin and end, s.
const INSTANTS_S: f64 = 3e-6;

/// The request of a line to the laser.
#[derive(Clone, Copy)]
struct Lit {
    mode: &'static str,
    /// S, of the full one.
    power: f64,
    feed_mm_s: f64,
}

/// The rule: the level at a speed along the path, which is limited to the full one after that.
fn asked(lit: Lit, percent: f64, speed_mm_s: f64) -> f64 {
    let by_speed = match lit.mode {
        "M3" => 1.0,
        "M4" => speed_mm_s / lit.feed_mm_s,
        _ => 0.0,
    };
    lit.power * percent / 100.0 * by_speed
}

/// The longest stroke that stands for a curve, s.
fn chord_s(speed_profile: u8) -> f64 {
    match speed_profile {
        0 => 0.0,
        1 | 2 => 0.002,
        _ => 0.01,
    }
}

/// A program under way: what its moves ask for, and the override of the power.
struct Program {
    speed_profile: u8,
    sim: Sim,
    lit: Vec<Lit>,
    /// From when on which percentage counts, s since power-up.
    percents: Vec<(f64, f64)>,
}

impl Program {
    fn new(speed_profile: u8, accel_mm_s2: f64) -> Self {
        let mut sim = powered_up(&Config { only_time: true, ..Config::default() });
        let start = if speed_profile > 2 { 120 } else { 0 };
        for axis in 0..3 {
            let settings = format!("$12{axis}={accel_mm_s2}\n$91{axis}={start}\n$11{axis}=6000\n");
            assert_eq!(say(&mut sim, &settings).last_line(), "ok");
        }
        assert_eq!(say(&mut sim, &format!("$940={speed_profile}\n$32=1\nG91")), ["ok"; 3]);
        Self { speed_profile, sim, lit: Vec::new(), percents: vec![(0.0, 100.0)] }
    }

    /// Steps of an override by 10 %, for feed or power.
    fn overrides(&mut self, up: u8, tens: i32) {
        let byte = if tens < 0 { up + 1 } else { up };
        self.sim.send(&vec![byte; tens.unsigned_abs() as usize]);
        if up == 0x9A {
            let percent = self.percents.last().unwrap().1 + 10.0 * f64::from(tens);
            self.percents.push((self.sim.now_ns() as f64 * 1e-9, percent.clamp(10.0, 200.0)));
        }
    }

    fn percent_at(&self, t_s: f64) -> f64 {
        self.percents.iter().rfind(|(since_s, _)| *since_s <= t_s).unwrap().1
    }

    /// Compares the light of all pieces. Returns their number, and of how many the level was full in a part only.
    fn compare(self, name: &str) -> (usize, usize) {
        let outcome = self.sim.outcome();
        let light = Light::of(&outcome);
        // The machine is not homed. A line that goes straight on is a section of the same move.
        let sections = sections(&outcome);
        assert_eq!(sections.len(), self.lit.len(), "{name}");
        let (mut pieces, mut kinks) = (0, 0);
        for (index, (section, lit)) in sections.iter().zip(&self.lit).enumerate() {
            let record = &outcome.moves[section.index];
            let next = sections.get(index + 1).filter(|next| next.index == section.index);
            let end_s = next.map_or(record.plan_s, |next| record.place_time_s(next.from_steps));
            let samples = self.samples(record, [record.place_time_s(section.from_steps), end_s], *lit);
            let mut begin = 0;
            while begin < samples.len() {
                let place_mm = samples[begin].place_mm;
                let end = begin + samples[begin..].partition_point(|sample| sample.place_mm < place_mm + PIECE_MM);
                self.compare_piece(&samples, begin..end, *lit, &light, name);
                let full = samples[begin..end].iter().filter(|sample| sample.asked > 1.0).count();
                (pieces, kinks) = (pieces + 1, kinks + usize::from(full > 0 && full < end - begin));
                begin = end;
            }
        }
        (pieces, kinks)
    }

    fn compare_piece(&self, samples: &[Sample], piece: std::ops::Range<usize>, lit: Lit, light: &Light, name: &str) {
        let made = &samples[piece.clone()];
        let (begin_s, end_s) = (made[0].begin_s, made.last().unwrap().end_s);
        let expected_s: f64 = made.iter().map(|each| each.asked.min(1.0) * (each.end_s - each.begin_s)).sum();
        let actual_s = light.until_s(end_s) - light.until_s(begin_s);
        // How steeply the level changes here, and within the stroke that stands for a curve.
        let chord_s = chord_s(self.speed_profile);
        let around = (chord_s / SAMPLE_S) as usize + 1;
        let near = &samples[piece.start.saturating_sub(around)..samples.len().min(piece.end + around)];
        let slopes = near.windows(2).map(|pair| lit.slope(pair));
        let (low, high) = slopes.fold((0.0f64, 0.0f64), |(low, high), slope| (low.min(slope), high.max(slope)));
        let percent = self.percent_at(begin_s).max(self.percent_at(end_s)) / 100.0;
        let steep = low.abs().max(high) * percent;
        let changes = self.percents.iter().filter(|(at_s, _)| (begin_s..end_s).contains(at_s)).count();
        let bound_s = LEVELS * (end_s - begin_s)
            + INSTANTS_S
            // An update is cut at either end of the piece.
            + 2.0 * steep * UPDATE_S.powi(2) / 8.0
            + percent * (high - low) * chord_s / 4.0 * (end_s - begin_s)
            + SAMPLE_S * changes as f64;
        assert!(
            (actual_s - expected_s).abs() <= bound_s,
            "{name}: {} at {:.3} mm, {begin_s:.6} to {end_s:.6} s: light {:.3} us, expected {:.3} us, bound {:.3} us",
            lit.mode,
            made[0].place_mm,
            actual_s * 1e6,
            expected_s * 1e6,
            bound_s * 1e6,
        );
    }

    /// The plan of a move from one instant to another, s from the start of its run, in short sections of time.
    fn samples(&self, record: &MoveRecord, [begin_s, end_s]: [f64; 2], lit: Lit) -> Vec<Sample> {
        let mm_per_step = {
            let path = record.plan.steps.iter().map(|steps| (f64::from(*steps) / 50.0).powi(2)).sum::<f64>().sqrt();
            path / record.plan.distance_steps()
        };
        let count = ((end_s - begin_s) / SAMPLE_S).ceil();
        let mut place_mm = 0.0;
        let start_s = record.start_ns as f64 * 1e-9;
        (0..count as usize)
            .map(|number| {
                let from_s = begin_s + number as f64 * SAMPLE_S;
                let to_s = (from_s + SAMPLE_S).min(end_s);
                let t_s = (from_s + to_s) / 2.0;
                let part = record.parts.iter().rfind(|part| part.begin_s() <= t_s).unwrap_or(&record.plan);
                let speed_mm_s = part.speed_at(t_s) * mm_per_step;
                place_mm += speed_mm_s * (to_s - from_s);
                Sample {
                    begin_s: start_s + from_s,
                    end_s: start_s + to_s,
                    place_mm,
                    speed_mm_s,
                    asked: asked(lit, self.percent_at(start_s + t_s), speed_mm_s),
                }
            })
            .collect()
    }
}

impl Lit {
    /// The slope of the level without overrides between two samples, 1/s.
    fn slope(self, pair: &[Sample]) -> f64 {
        let [from, to] = [pair[0], pair[1]].map(|sample| asked(self, 100.0, sample.speed_mm_s));
        (to - from) / SAMPLE_S
    }
}

#[derive(Clone, Copy)]
struct Sample {
    begin_s: f64,
    end_s: f64,
    /// The place on the path of its move where it ends.
    place_mm: f64,
    speed_mm_s: f64,
    /// The level that is asked for, without the limit.
    asked: f64,
}

/// The light so far at each change of the level: seconds since power-up, seconds of full light, level from there on.
struct Light(Vec<(f64, f64, f64)>);

impl Light {
    fn of(outcome: &Outcome) -> Self {
        let mut changes = vec![(0.0, 0.0, 0.0)];
        for change in outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm) {
            let (t_s, &(since_s, sum_s, level)) = (change.t_ns as f64 * 1e-9, changes.last().unwrap());
            changes.push((t_s, sum_s + level * (t_s - since_s), change.duty_ratio()));
        }
        Self(changes)
    }

    fn until_s(&self, t_s: f64) -> f64 {
        let (since_s, sum_s, level) = self.0[self.0.partition_point(|change| change.0 <= t_s) - 1];
        sum_s + level * (t_s - since_s)
    }
}

/// A program of random moves, of which some are dark, with overrides before it and while it runs. In a raster many of
/// them go straight on at the same feed.
fn random_program(speed_profile: u8, seed: u32, is_raster: bool) -> (Program, String) {
    let mut random = Rand32::new(u64::from(seed) * 7 + u64::from(speed_profile));
    let mut pick = |choices: &[f64]| choices[random.rand_range(0..choices.len() as u32) as usize];
    let accel_mm_s2 = pick(&[100.0, 500.0, 2_000.0]);
    let mut program = Program::new(speed_profile, accel_mm_s2);
    let (feed, power) = (pick(&[-9.0, -4.0, 3.0, 6.0, 10.0]), pick(&[-9.0, -4.0, 0.0, 5.0, 10.0]));
    program.overrides(0x91, feed as i32);
    program.overrides(0x9A, power as i32);
    let mut lines = String::new();
    for _ in 0..8 {
        let [x, y, z] = [(); 3].map(|()| pick(&[-3.0, -1.0, -0.2, 0.0, 0.2, 1.0, 3.0]) + 0.02);
        let mode = ["M3", "M4", "M4", "M4", "M5"][pick(&[0.0, 1.0, 2.0, 3.0, 4.0]) as usize];
        let (mut s, f) = (pick(&[50.0, 600.0, 800.0, 1_000.0]), pick(&[600.0, 1_000.0, 2_000.0]));
        let times = if is_raster { pick(&[1.0, 4.0, 12.0]) as usize } else { 1 };
        for _ in 0..times {
            lines += &format!("{mode} S{s}\nG1 F{f} X{x} Y{y} Z{z}\n");
            program.lit.push(Lit { mode, power: s / 1_000.0, feed_mm_s: f / 60.0 });
            s = pick(&[0.0, 50.0, 600.0, 1_000.0]);
        }
    }
    program.sim.send(lines.as_bytes());
    let mut acts = String::new();
    for _ in 0..4 {
        let (wait_ms, feed, power) = (pick(&[40.0, 300.0, 1_000.0]), pick(&[-5.0, 0.0, 4.0]), pick(&[-3.0, 0.0, 2.0]));
        program.sim.run_for(Duration::from_micros(wait_ms as u64 * 1_000)).unwrap();
        program.overrides(0x91, feed as i32);
        program.overrides(0x9A, power as i32);
        acts += &format!("; after {wait_ms} ms feed {feed:+}, power {power:+}");
    }
    program.sim.run_until_idle().unwrap();
    assert!(program.sim.replies().iter().all(|answer| answer == "ok"));
    let name = format!(
        "speed profile {speed_profile}, seed {seed}, {accel_mm_s2} mm/s2, feed {feed:+}, power {power:+}{acts}\n{lines}"
    );
    (program, name)
}

/// The light of each piece of the path is what the rule says, on ramps and at corners too, whatever the overrides are.
#[test]
fn the_light_of_each_piece_of_the_path_is_that_of_the_rule() {
    let (mut programs, mut pieces, mut kinks) = (0, 0, 0);
    for speed_profile in 0..7 {
        for seed in 0..if speed_profile < 3 { cases(4, 10) } else { cases(1, 3) } {
            let (program, name) = random_program(speed_profile, seed, false);
            let counted = program.compare(&name);
            (programs, pieces, kinks) = (programs + 1, pieces + counted.0, kinks + counted.1);
        }
    }
    assert!(pieces > 70 * programs && kinks > programs, "{pieces} pieces, {kinks} of them full in a part");
}

/// The same for lines that are parts of one move: each has the light that is its own, on ramps too.
#[test]
fn the_light_of_each_line_of_a_raster_is_that_of_the_rule() {
    let (mut pieces, mut marks) = (0, 0);
    for seed in 0..cases(10, 50) {
        let (program, name) = random_program(0, seed, true);
        marks += program.sim.outcome().moves.iter().map(|record| record.marks_steps.len()).sum::<usize>();
        pieces += program.compare(&name).0;
    }
    assert!(marks > 60 && pieces > 10 * marks, "{marks} marks, {pieces} pieces");
}

/// At 200 % of the feed a ramp passes the programmed speed in its middle. There the laser is full, and not later.
#[test]
fn m4_is_full_from_the_programmed_speed_on_whatever_the_feed_override() {
    for accel_mm_s2 in [50.0, 500.0] {
        let mut sim = homed();
        assert_eq!(say(&mut sim, &format!("$120={accel_mm_s2}\n$32=1")), ["ok", "ok"]);
        sim.send(&[0x91; 10]);
        sim.send(b"M4 S1000\nG91 G1 X30 F1000\n");
        let mut looks = Vec::new();
        while looks.len() < 10_000 || sim.machine().state() == State::Run {
            sim.run_for(Duration::from_micros(50)).unwrap();
            looks.push((sim.now_ns(), f64::from(sim.tool()[0]) / f64::from(ON)));
        }
        let outcome = sim.outcome();
        let record = outcome.moves.iter().find(|record| !record.homing).unwrap();
        let lit = Lit { mode: "M4", power: 1.0, feed_mm_s: 1_000.0 / 60.0 };
        // A level is made for half an update before and after its instant.
        let bound = accel_mm_s2 * UPDATE_S / 2.0 / lit.feed_mm_s + LEVELS;
        let mut seen = 0;
        for (t_ns, level) in looks.into_iter().filter(|look| (record.begin_ns()..record.end_ns).contains(&look.0)) {
            let t_s = (t_ns - record.start_ns) as f64 * 1e-9;
            let part = record.parts.iter().rfind(|part| part.begin_s() <= t_s).unwrap_or(&record.plan);
            let speed_mm_s = part.speed_at(t_s) / 50.0;
            let off = level - asked(lit, 100.0, speed_mm_s).min(1.0);
            assert!(off.abs() <= bound, "{level} at {speed_mm_s:.3} mm/s: {off:.4} off, {bound:.4} allowed");
            seen += usize::from((16.7..33.0).contains(&speed_mm_s) && level > 1.0 - LEVELS);
        }
        // Both ramps pass through these speeds.
        let expected = 2.0 * 16.0 / accel_mm_s2 / 50e-6;
        assert!(seen as f64 > expected, "full on {seen} looks at the ramps");
    }
}
