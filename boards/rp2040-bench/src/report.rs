//! Prints the figures on UART0, one line each.

use core::fmt::{self, Display, Write};

use embassy_rp::uart::{Blocking, UartTx};
use rp2040_bench::Checksum;

/// Cycles, and the number of results they made.
#[derive(Clone, Copy, Default)]
pub struct Figure {
    /// Cycles of all pieces of work.
    pub cycles: u64,
    /// Cycles of the slowest piece of work.
    pub cycles_max: u32,
    /// Number of results.
    pub count: u32,
}

impl Figure {
    /// The figure of one piece of work that made one result.
    pub fn one(cycles: u32) -> Self {
        let mut figure = Self::default();
        figure.add(cycles, 1);
        figure
    }

    /// Adds a piece of work that took `cycles` and made `count` results.
    pub fn add(&mut self, cycles: u32, count: u32) {
        self.cycles += u64::from(cycles);
        self.cycles_max = self.cycles_max.max(cycles);
        self.count += count;
    }
}

/// Writes the lines to the UART.
pub struct Report {
    uart: Text,
}

struct Text(UartTx<'static, Blocking>);

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.blocking_write(text.as_bytes()).map_err(|_| fmt::Error)
    }
}

impl Report {
    pub fn new(uart: UartTx<'static, Blocking>) -> Self {
        Self { uart: Text(uart) }
    }

    /// Prints the sum over all results.
    pub fn sum(&mut self, name: impl Display, figure: Figure, checksum: Checksum) {
        self.line(format_args!("{name},{},{},{}", figure.cycles, figure.count, checksum.value()));
    }

    /// Prints the slowest piece of work.
    pub fn max(&mut self, name: impl Display, figure: Figure, checksum: Checksum) {
        self.line(format_args!("{name}.max,{},{},{}", figure.cycles_max, figure.count, checksum.value()));
    }

    /// Prints the last line.
    pub fn end(&mut self) {
        self.line(format_args!("end"));
    }

    fn line(&mut self, text: fmt::Arguments) {
        writeln!(self.uart, "{text}").expect("a blocking UART takes everything");
    }
}
