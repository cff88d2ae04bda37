//! The figures, a line each, on UART0.

use core::fmt::{self, Display, Write};

use embassy_rp::uart::{Blocking, UartTx};
use rp2040_bench::Checksum;

/// Cycles, and the results they made.
#[derive(Clone, Copy, Default)]
pub struct Figure {
    /// Of all results.
    pub cycles: u64,
    /// Of the slowest piece of work.
    pub cycles_max: u32,
    /// Results.
    pub count: u32,
}

impl Figure {
    /// One piece of work that made one result.
    pub fn one(cycles: u32) -> Self {
        let mut figure = Self::default();
        figure.add(cycles, 1);
        figure
    }

    /// A piece of work that took `cycles` and made `count` results.
    pub fn add(&mut self, cycles: u32, count: u32) {
        self.cycles += u64::from(cycles);
        self.cycles_max = self.cycles_max.max(cycles);
        self.count += count;
    }
}

/// Where the lines go.
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

    /// The sum over all results.
    pub fn sum(&mut self, name: impl Display, figure: Figure, checksum: Checksum) {
        self.line(format_args!("{name},{},{},{}", figure.cycles, figure.count, checksum.value()));
    }

    /// The slowest piece of work.
    pub fn max(&mut self, name: impl Display, figure: Figure, checksum: Checksum) {
        self.line(format_args!("{name}.max,{},{},{}", figure.cycles_max, figure.count, checksum.value()));
    }

    /// Nothing comes after it.
    pub fn end(&mut self) {
        self.line(format_args!("end"));
    }

    fn line(&mut self, text: fmt::Arguments) {
        writeln!(self.uart, "{text}").expect("a blocking UART takes everything");
    }
}
