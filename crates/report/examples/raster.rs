//! A raster as a laser engraves it, of any length: rows of pixels of 0.1 mm, a line for each pixel.
//!
//! `cargo run -q -p isostep-report --example raster -- 200000 > raster.nc`

use std::io::{self, BufWriter, Write};

/// Pixels of a row.
const ROW: usize = 1_000;

/// Writes a raster of so many lines.
pub fn write(lines: usize, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "G21 G90\nM4 S0\nG1 F12000")?;
    let last = lines.saturating_sub(1);
    for index in 0..last.saturating_sub(3) {
        let (row, pixel) = (index / (ROW + 1), index % (ROW + 1));
        if pixel == ROW {
            writeln!(out, "Y{}", tenths(row + 1))?;
        } else {
            let tenth = if row.is_multiple_of(2) { pixel + 1 } else { ROW - pixel - 1 };
            // A grey that changes from pixel to pixel, as in a photograph.
            writeln!(out, "X{} S{}", tenths(tenth), (row * 7 + pixel * 13) % 256)?;
        }
    }
    writeln!(out, "M2")
}

fn tenths(count: usize) -> String {
    format!("{}.{}", count / 10, count % 10)
}

#[allow(dead_code, reason = "a test has the raster without the program around it")]
fn main() -> io::Result<()> {
    let lines = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(200_000);
    let mut out = BufWriter::new(io::stdout().lock());
    write(lines, &mut out)?;
    out.flush()
}
