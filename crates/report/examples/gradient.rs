//! A grey gradient as a laser engraves it: rows of pixels of 0.1 mm at 200 mm/s, from nothing on the left to full power
//! on the right. Each row begins and ends with a dark run-up in which the carriage comes to its speed.
//!
//! `cargo run -q -p isostep-report --example gradient -- 100 > gradient.nc` writes 100 rows, to be made in laser mode
//! (`$32=1`).

use std::io::{self, BufWriter, Write};

/// Pixels of a row.
pub const PIXELS: usize = 400;
/// Run-up before the first pixel and behind the last one, pixels.
const RUN_UP: usize = 50;
/// S of full power.
const FULL: usize = 1_000;

/// Writes a gradient of so many rows.
pub fn write(rows: usize, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "G21 G90\nM4 S0\nG1 F12000")?;
    for row in 0..rows {
        let is_back = row % 2 == 1;
        let place = |pixels: usize| tenths(if is_back { PIXELS + 2 * RUN_UP - pixels } else { pixels });
        writeln!(out, "Y{}\nX{} S0", tenths(row), place(RUN_UP))?;
        for pixel in 0..PIXELS {
            let column = if is_back { PIXELS - 1 - pixel } else { pixel };
            writeln!(out, "X{} S{}", place(RUN_UP + pixel + 1), column * FULL / (PIXELS - 1))?;
        }
        writeln!(out, "X{} S0", place(PIXELS + 2 * RUN_UP))?;
    }
    writeln!(out, "M2")
}

fn tenths(count: usize) -> String {
    format!("{}.{}", count / 10, count % 10)
}

#[allow(dead_code, reason = "a test has the gradient without the program around it")]
fn main() -> io::Result<()> {
    let rows = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(100);
    let mut out = BufWriter::new(io::stdout().lock());
    write(rows, &mut out)?;
    out.flush()
}
