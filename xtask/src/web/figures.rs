//! Prints how large and how fast the page is, beside the same runs on this computer.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::Result;
use isostep::stopwatch::Stopwatch;
use isostep_sim::Config;

use super::{chromium, dir};
use crate::process;
use crate::workspace;

/// Moves of the programs that are made for it. The longest is run on the page only.
const MOVES: [usize; 2] = [20_000, 200_000];
/// Lines of the relief.
const RELIEF_LINES: usize = 20_000;
/// Lines in a row of it.
const IN_ROW: usize = 200;

/// Measures the page of this folder.
pub fn print(page: &Path) -> Result<()> {
    let folder = workspace::target_dir().join("web-figures");
    fs::create_dir_all(&folder)?;
    let mut programs = vec![workspace::root().join("programs").join("engraving.nc")];
    for moves in MOVES {
        programs.push(folder.join(format!("moves-{moves}.nc")));
        fs::write(&programs[programs.len() - 1], short_moves(moves))?;
    }
    programs.insert(1, folder.join(format!("relief-{RELIEF_LINES}.nc")));
    fs::write(&programs[1], relief(RELIEF_LINES))?;
    println!("{:<22} {:>12} {:>12} {:>8}", "on this computer", "machine, s", "run in, s", "times");
    for path in &programs[..3] {
        let stopwatch = Stopwatch::start();
        let outcome = isostep_sim::run(&fs::read(path)?, &Config { keep_waves: false, ..Config::default() })?;
        let (machine_s, elapsed_s) = (outcome.duration_ns as f64 * 1e-9, stopwatch.elapsed_s());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        println!("{name:<22} {machine_s:>12.1} {elapsed_s:>12.2} {:>8.0}", machine_s / elapsed_s);
    }
    let mut figures = Command::new("node");
    figures.arg(dir().join("test").join("figures.mjs")).arg("--folder").arg(page).arg("--shots").arg(&folder);
    figures.arg("--page").arg(chromium::served(page, None)?).arg("--chromium").arg(chromium::found()?);
    for path in &programs {
        figures.arg("--program").arg(path);
    }
    process::run(&mut figures)
}

/// A smooth surface in rows 0.4 mm apart, with a place every 0.2 mm, as CAM writes it.
fn relief(lines: usize) -> String {
    let line = |number: usize| {
        let (row, column) = (number / IN_ROW, number % IN_ROW);
        let along = if row.is_multiple_of(2) { column } else { IN_ROW - 1 - column };
        let (x, y) = (0.2 * along as f64, 0.4 * row as f64);
        format!("X{x:.3} Y{y:.3} Z{:.3}\n", 2.0 * (x / 6.0).sin() * (y / 8.0).cos())
    };
    format!("G21 G90 G1 F2400\n{}", (0..lines).map(line).collect::<String>())
}

/// A chain of short moves with a blend at each corner.
fn short_moves(moves: usize) -> String {
    let line = |number: usize| format!("G1 {}{}0.2\n", ["X", "Y"][number % 2], if number % 4 < 2 { "" } else { "-" });
    format!("G21 G91 F2400\n{}", (0..moves).map(line).collect::<String>())
}
