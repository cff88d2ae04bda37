//! Times the mathematics of a move, and the other generators, on an RP2040. The library says what is timed and printed.
//!
//! Nothing else runs: one core, no interrupts.
#![no_std]
#![no_main]

mod report;
mod stopwatch;
mod work;

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use embassy_rp::uart::UartTx;

use crate::report::Report;
use crate::stopwatch::Stopwatch;

#[entry]
fn main() -> ! {
    rp2040_floats::link();
    let chip = embassy_rp::init(Default::default());
    let core = cortex_m::Peripherals::take().expect("nobody else takes them");
    // 115200 8N1 is the driver's default.
    let mut report = Report::new(UartTx::new_blocking(chip.UART0, chip.PIN_0, Default::default()));
    let stopwatch = Stopwatch::start(core.SYST);
    work::floats(&stopwatch, &mut report);
    work::plan(&stopwatch, &mut report);
    work::compile(&stopwatch, &mut report);
    work::flow(&stopwatch, &mut report);
    work::fill(&stopwatch, &mut report);
    work::peers(&stopwatch, &mut report);
    report.end();
    loop {
        cortex_m::asm::wfi();
    }
}

/// A fault makes itself known: the host waits for a line `end` that never comes.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    cortex_m::asm::udf()
}
