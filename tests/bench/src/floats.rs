//! What operations on floats cost on the chip.

use anyhow::Result;
use rp2040_bench::{FLOAT_AMONG_DIVISION, FLOAT_CASES, FLOAT_DIVIDE};
use serde::Serialize;

use super::lines::Lines;

/// The cost of an operation, in emulated cycles of the core, the call included.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FloatFigures {
    pub operation: &'static str,
    pub cycles_mean: f64,
}

/// The figures of every case. The checksum of all results is verified.
pub fn all(lines: &Lines) -> Result<Vec<FloatFigures>> {
    let checksum = |case| rp2040_bench::floats(case, |pair, work| work(pair));
    lines.proven(FLOAT_AMONG_DIVISION, checksum(&FLOAT_CASES[FLOAT_DIVIDE]))?;
    let figures = FLOAT_CASES.iter().map(|case| {
        let line = lines.proven(&format!("float.{}", case.name), checksum(case))?;
        Ok(FloatFigures { operation: case.name, cycles_mean: line.cycles_per_result() })
    });
    figures.collect()
}

/// Names and cycles of all operations.
pub fn words(figures: &[FloatFigures]) -> String {
    let words = figures.iter().map(|one| format!("{} {:.0}", one.operation, one.cycles_mean));
    words.collect::<Vec<_>>().join(", ")
}
