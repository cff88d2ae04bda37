//! Measures the distance in time between a laser's level and the step with which the level should begin, in lines of
//! pixels of 0.1 mm. Also measures how many pixels per second the firmware sustains when they are sent faster than
//! that.

use anyhow::Result;
use isostep::measure::errors::Errors;
use isostep::measure::{Better, Figure, Findings, Measured};

use super::edges::Edge;
use super::runs::{Job, OutputChange, Runs};

/// Of the X axis.
const STEPS_PER_MM: usize = 80;
const PIXEL_STEPS: usize = STEPS_PER_MM / 10;
/// Distance before and after the pixels.
const RUN_UP_MM: usize = 5;
/// The levels of the pixels, percent. Adjacent levels differ.
const LEVELS_PERCENT: [u32; 5] = [20, 80, 50, 100, 10];
/// At this speed a line has a thousand moves per second.
const STEADY_MM_S: f64 = 100.0;
/// Faster than the firmware can sustain.
const HASTY_MM_S: f64 = 600.0;
/// The run does not wait for a core that makes fewer pixels per second than this.
const SLOWEST_PIXELS_S: f64 = 100.0;

/// Measures lines of `pixels` each.
pub fn measure(runs: &Runs, found: &mut Findings, pixels: usize) -> Result<()> {
    let what = "from the middle between its two steps to the change of a laser's level, at 1,000 moves/s";
    let distance = |key: &str, part: &str| {
        Figure::new(format!("level.{key}"), format!("{what}, {part}"), "us").compared(Better::Lower, 0.05, 0.1)
    };
    match run(runs, "M3", STEADY_MM_S, pixels)?.and_then(|line| line.distances()) {
        Ok(errors) => {
            let [median_ns, p99_ns] = [0.5, 0.99].map(|ratio| errors.quantile_ns(ratio));
            for (key, part, ns) in
                [("median", "median", median_ns), ("p99", "p99", p99_ns), ("max", "at most", errors.max_ns())]
            {
                found.add(distance(key, part).measured(ns * 1e-3, format!("of {pixels} pixels of 0.1 mm")));
            }
        }
        Err(why_not) => found.add(distance("max", "at most").missing(why_not)),
    }
    for (mode, levels) in [("M3", "constant levels"), ("M4", "levels by speed")] {
        let what = format!("pixels of 0.1 mm a second, {levels} ({mode})");
        let figure = Figure::new(format!("pixels.{mode}"), what, "pixels/s").compared(Better::Higher, 0.02, 0.0);
        found.add(match run(runs, mode, HASTY_MM_S, pixels)?.and_then(|line| line.rate_pixels_s()) {
            Ok(per_s) => figure.measured(per_s.round(), "in the middle half of a line"),
            Err(why_not) => figure.missing(why_not),
        });
    }
    Ok(())
}

fn run(runs: &Runs, mode: &str, feed_mm_s: f64, pixels: usize) -> Result<Measured<Line>> {
    let ran = runs.outputs(Job::Program(&program(mode, feed_mm_s, pixels)), pixels as f64 / SLOWEST_PIXELS_S)?;
    Ok(ran.map(|(edges, outputs)| Line { pixels, edges, outputs }))
}

fn program(mode: &str, feed_mm_s: f64, pixels: usize) -> String {
    let mut text = format!(
        "$32=1\n$30=1000\n$100={STEPS_PER_MM}\n$110=60000\n$120=10000\nG21G91\n{mode}S0\nG1F{}X{RUN_UP_MM}\n",
        feed_mm_s * 60.0
    );
    for percent in LEVELS_PERCENT.iter().cycle().take(pixels) {
        text += &format!("X0.1S{}\n", percent * 10);
    }
    text + &format!("X{RUN_UP_MM}S0\nM5\nM2\n")
}

/// The edges and output changes of a line of pixels.
struct Line {
    pixels: usize,
    edges: Vec<Edge>,
    outputs: Vec<OutputChange>,
}

impl Line {
    /// The middle between the last step before this pixel and the pixel's first step, ns.
    fn begin_ns(&self, pixel: usize) -> Option<f64> {
        let last = RUN_UP_MM * STEPS_PER_MM + pixel * PIXEL_STEPS - 1;
        let [before, after] = [last, last + 1].map(|index| self.edges.get(index));
        Some((before?.t_ns + after?.t_ns) / 2.0)
    }

    fn distances(&self) -> Measured<Errors> {
        let mut errors = Errors::default();
        for pixel in 0..self.pixels {
            let begin_ns = self.begin_ns(pixel).ok_or_else(|| format!("{} edges", self.edges.len()))?;
            let ratio = f64::from(LEVELS_PERCENT[pixel % LEVELS_PERCENT.len()]) / 100.0;
            let is_its = |change: &&OutputChange| change.output == "pwm" && (change.value - ratio).abs() < 1e-3;
            let after = self.outputs.partition_point(|change| change.t_ns < begin_ns);
            let near = &self.outputs[after.saturating_sub(LEVELS_PERCENT.len())..];
            let distance_ns = |change: &OutputChange| change.t_ns - begin_ns;
            let all = near.iter().take(2 * LEVELS_PERCENT.len()).filter(is_its).map(distance_ns);
            let nearest_ns = all.min_by(|a, b| a.abs().total_cmp(&b.abs()));
            errors.add(nearest_ns.ok_or_else(|| format!("pixel {pixel} never had its level"))?);
        }
        Ok(errors)
    }

    /// The rate in the middle half of the line.
    fn rate_pixels_s(&self) -> Measured<f64> {
        let [from, to] = [self.pixels / 4, self.pixels * 3 / 4].map(|pixel| self.begin_ns(pixel).map(|ns| (pixel, ns)));
        let (Some((from, from_ns)), Some((to, to_ns))) = (from, to) else {
            return Err(format!("{} edges", self.edges.len()));
        };
        Ok((to - from) as f64 / (to_ns - from_ns) * 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line with steps every 8 us, and each level `late_ns` after the middle between its two steps.
    fn line(pixels: usize, late_ns: f64) -> Line {
        let steps = 2 * RUN_UP_MM * STEPS_PER_MM + pixels * PIXEL_STEPS;
        let edges = (0..steps).map(|step| Edge { t_ns: 8_000.0 * step as f64, axis: 0, direction: 1 }).collect();
        let mut line = Line { pixels, edges, outputs: Vec::new() };
        for pixel in 0..pixels {
            let value = f64::from(LEVELS_PERCENT[pixel % LEVELS_PERCENT.len()]) / 100.0;
            let t_ns = line.begin_ns(pixel).unwrap() + late_ns;
            line.outputs.push(OutputChange { t_ns, output: "pwm".to_owned(), value });
        }
        line
    }

    #[test]
    fn distances_are_from_the_middle_between_steps() {
        let errors = line(100, 3_000.0).distances().unwrap();
        assert_eq!((errors.quantile_ns(0.5), errors.max_ns(), errors.count()), (3_000.0, 3_000.0, 100));
        let mut short = line(100, 0.0);
        short.outputs.remove(50);
        assert!(short.distances().unwrap().max_ns() > 30_000.0, "another one of its like is far off");
        short.edges.truncate(500);
        assert_eq!(short.distances(), Err("500 edges".to_owned()));
    }

    #[test]
    fn rates_are_of_the_middle_half() {
        // 8 us per step, 8 steps per pixel.
        assert!((line(400, 0.0).rate_pixels_s().unwrap() - 1e6 / 64.0).abs() < 1e-6);
    }

    #[test]
    fn a_program_has_a_level_for_each_pixel() {
        let text = program("M4", 100.0, 6);
        let lines: Vec<_> = text.lines().skip(6).collect();
        assert_eq!(lines[..4], ["M4S0", "G1F6000X5", "X0.1S200", "X0.1S800"]);
        assert_eq!(lines[7..], ["X0.1S200", "X5S0", "M5", "M2"]);
    }
}
