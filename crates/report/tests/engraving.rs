//! A laser's raster: each pixel is at its position with its power; also the picture of it.

use std::ops::Range;

use isostep_motion::{Finish, Level};
use isostep_report::{Figures, pictures};
use isostep_sim::lines_of_moves::sections;
use isostep_sim::tool::ToolOutput;
use isostep_sim::{Config, MoveRecord, Outcome, run};

#[path = "../examples/gradient.rs"]
mod gradient;

const PIXELS: usize = 600;
const STEPS_PER_PIXEL: usize = 8;
/// The feed asked for, which is also the top speed of the axes.
const FEED_STEPS_S: f64 = 16_000.0;
/// Pixels on the ramp to the stop at the end: 4 mm at 5,000 mm/s² from 200 mm/s.
const RAMP_PIXELS: usize = 41;
/// Motion starts with the pixels known by then. The speed is constant only after many more have arrived.
const FIRST_PIXELS: usize = 80;
/// The largest time between the beginning of a move and the change to its level.
const LATE_NS: u64 = 1_000;

/// A fast machine with a laser.
fn machine() -> Config {
    let mut config = Config { keep_waves: false, start_mm: [5.0; 3], ..Config::default() };
    let settings = &mut config.settings;
    (settings.soft_limits, settings.hard_limits, settings.laser_mode) = (false, false, true);
    settings.steps_per_mm = [80.0; 3];
    settings.max_rate_mm_min = [12_000.0; 3];
    settings.accel_mm_s2 = [5_000.0; 3];
    config
}

fn made(program: &str) -> Outcome {
    let outcome = run(program.as_bytes(), &machine()).unwrap();
    let figures = Figures::new("raster", &outcome);
    let broken: Vec<_> = figures.broken().map(|verdict| format!("{}: {}", verdict.promise, verdict.detail)).collect();
    assert_eq!(broken, [""; 0]);
    outcome
}

/// S of a pixel, of 1,000; neighbours differ a lot.
fn level(pixel: usize) -> usize {
    pixel * 373 % 1_001
}

/// One raster line of pixels, with M3 or M4.
fn line(word: &str) -> Outcome {
    let pixels = (0..PIXELS).map(|pixel| format!("X{}.{} S{}\n", (pixel + 1) / 10, (pixel + 1) % 10, level(pixel)));
    let outcome = made(&format!("G21 G90\n{word} S0\nG1 F12000\n{}M5\n", pixels.collect::<String>()));
    assert!(outcome.moves.len() < PIXELS / 5, "{} moves: few pixels follow each other in one", outcome.moves.len());
    outcome
}

/// A pixel: a section of a move.
struct Pixel<'a> {
    record: &'a MoveRecord,
    begin_ns: u64,
    /// The place where the next one begins, or where the plan ends.
    end_ns: u64,
    edges: Range<usize>,
}

/// Every pixel, with its instants by the closed form of the plan that its move was made by.
fn pixels(outcome: &Outcome) -> Vec<Pixel<'_>> {
    let sections = sections(outcome);
    let begins = sections.iter().map(|section| {
        let record = &outcome.moves[section.index];
        let latest = record.parts.iter().rev().find(|part| part.begin_steps() <= section.from_steps);
        record.start_ns + (latest.unwrap_or(&record.plan).time_at(section.from_steps) * 1e9).round() as u64
    });
    let last = &outcome.moves[outcome.moves.len() - 1];
    let end_ns = last.start_ns + (last.parts.last().unwrap_or(&last.plan).end_s() * 1e9) as u64;
    let bounds: Vec<_> = begins.chain([end_ns]).collect();
    let pixels = sections.iter().zip(bounds.windows(2)).map(|(section, bounds)| {
        let [begin, end] = [bounds[0], bounds[1]].map(|at_ns| outcome.edges.partition_point(|edge| edge.t_ns < at_ns));
        Pixel { record: &outcome.moves[section.index], begin_ns: bounds[0], end_ns: bounds[1], edges: begin..end }
    });
    pixels.collect()
}

/// Duties of the PWM output in order, each with the instant from which it is in force.
fn duties(outcome: &Outcome) -> Vec<(u64, u16)> {
    let pwm = outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm);
    pwm.map(|change| (change.t_ns, change.duty)).collect()
}

fn duty_at(duties: &[(u64, u16)], t_ns: u64) -> u16 {
    duties[..duties.partition_point(|&(from_ns, _)| from_ns <= t_ns)].last().map_or(0, |&(_, duty)| duty)
}

/// The speed at an instant within a move, steps/s; the latest plan applies.
fn speed_steps_s(record: &MoveRecord, t_ns: u64) -> f64 {
    let t_s = (t_ns - record.start_ns) as f64 * 1e-9;
    let part = record.parts.iter().rev().find(|part| part.begin_s() <= t_s);
    part.unwrap_or(&record.plan).speed_at(t_s)
}

/// In the middle of the line each pixel takes 0.5 ms, beginning half a step before its first step, and there is no
/// stop.
fn is_at_speed_in_the_middle(outcome: &Outcome) {
    for pair in outcome.moves.windows(2).skip(1) {
        assert!(pair[0].run == pair[1].run && pair[0].finish == Finish::Done);
        assert!(pair[0].pause_ns(&pair[1]).abs() < 1.0);
    }
    let pixels = pixels(outcome);
    assert_eq!(pixels.len(), PIXELS);
    // The first one is made before the others have arrived.
    for (pixel, pair) in pixels.windows(2).enumerate().skip(1) {
        assert_eq!(pair[0].edges.len(), STEPS_PER_PIXEL, "{pixel}");
        if !(FIRST_PIXELS..PIXELS - RAMP_PIXELS).contains(&pixel) {
            continue;
        }
        assert!(pair[1].begin_ns.abs_diff(pair[0].begin_ns + 500_000) <= 1, "{pixel}");
        let first_ns = outcome.edges[pair[0].edges.start].t_ns;
        let half_step_ns = (0.5e9 / FEED_STEPS_S) as u64;
        assert!(first_ns.abs_diff(pair[0].begin_ns + half_step_ns) <= 50, "{pixel}");
    }
}

/// A raster line of 0.1 mm pixels at 200 mm/s is made as programmed.
#[test]
fn a_pixel_has_its_level_from_its_first_half_step_on() {
    let outcome = line("M3");
    is_at_speed_in_the_middle(&outcome);
    let duties = duties(&outcome);
    let mut before = 0;
    let pixels = pixels(&outcome);
    for (pixel, &Pixel { begin_ns, .. }) in pixels.iter().enumerate() {
        let own = outcome.tool_config.duties.duty(Level::of_ratio(level(pixel) as f32 / 1_000.0));
        assert_eq!(duty_at(&duties, begin_ns - LATE_NS), before, "pixel {pixel}, before");
        assert_eq!(duty_at(&duties, begin_ns + LATE_NS), own, "pixel {pixel}, behind its beginning");
        before = own;
    }
    // The laser goes out at the end of the plan, half a step after the last edge.
    let end_ns = pixels[PIXELS - 1].end_ns;
    assert_eq!(duty_at(&duties, end_ns - LATE_NS), before);
    assert_eq!(duty_at(&duties, end_ns + LATE_NS), 0);
    let found = Figures::new("raster", &outcome).tool.unwrap().beam.unwrap().beginnings.unwrap();
    assert!(found.total == PIXELS - 1 && found.most_us < 1.0, "the first pixel has none: {found:?}");
}

/// Between two changes of the duty the speed only rises or only falls. So the largest deviation is next to these
/// instants, or to the ends of moves.
#[test]
fn a_level_by_speed_follows_the_speed_within_a_hundredth() {
    let outcome = line("M4");
    is_at_speed_in_the_middle(&outcome);
    let duties = duties(&outcome);
    let mut looked_at = 0;
    for (pixel, Pixel { record, begin_ns, end_ns, .. }) in pixels(&outcome).into_iter().enumerate() {
        let (begin_ns, end_ns) = (begin_ns + LATE_NS, end_ns - LATE_NS);
        let changes = duties.iter().flat_map(|&(t_ns, _)| [t_ns - 1, t_ns]);
        let within = changes.filter(|t_ns| (begin_ns..end_ns).contains(t_ns));
        for t_ns in within.chain([begin_ns, end_ns]) {
            let wanted = level(pixel) as f64 / 1_000.0 * speed_steps_s(record, t_ns) / FEED_STEPS_S;
            let ratio = f64::from(duty_at(&duties, t_ns)) / f64::from(u16::MAX);
            assert!((ratio - wanted).abs() < 0.01, "pixel {pixel} at {t_ns} ns: {ratio:.4}, not {wanted:.4}");
            looked_at += 1;
        }
    }
    assert!(looked_at > 2 * PIXELS + 50, "{looked_at}");
}

/// The mean grey of each column of the engraved gradient.
fn columns(outcome: &Outcome) -> Vec<f64> {
    let both = pictures::BothRules::of(outcome, None);
    let files = pictures::page(outcome, &both, &Figures::new("engraved", outcome)).files();
    let (_, picture) = files.iter().find(|(name, _)| name == "engraving.png").unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info().unwrap();
    let mut greys = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut greys).unwrap();
    let (width, height) = (info.width as usize, info.height as usize);
    // The rims are left out, because only a part of the spot falls on them.
    let rows = 8..height - 8;
    let mean = |column| rows.clone().map(|row| f64::from(greys[row * width + column])).sum::<f64>() / rows.len() as f64;
    (0..width).map(mean).collect()
}

#[test]
fn a_gradient_is_engraved_evenly_from_white_to_black() {
    let mut program = Vec::new();
    gradient::write(24, &mut program).unwrap();
    let outcome = made(&String::from_utf8(program).unwrap());
    let columns = columns(&outcome);
    let inner = &columns[20..columns.len() - 20];
    assert!(inner.len() > 2 * gradient::PIXELS - 50, "two columns a pixel: {}", inner.len());
    let (first, last) = (inner[0], inner[inner.len() - 1]);
    assert!(first > 245.0 && last < 10.0, "{first} to {last}");
    for (index, grey) in inner.iter().enumerate() {
        let even = first + (last - first) * index as f64 / (inner.len() - 1) as f64;
        assert!((grey - even).abs() < 6.0, "column {index}: {grey:.1}, not {even:.1}");
    }
}
