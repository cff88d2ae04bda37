//! Which pin does what; the table of README's wiring section.

use embassy_rp::Peri;
use embassy_rp::Peripherals;
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::peripherals::{PIN_0, PIN_1, UART0, USB, WATCHDOG};

/// GP2, GP4, GP6, for those who must reach the pins without owning them.
pub const STEP_MASK: u32 = 1 << 2 | 1 << 4 | 1 << 6;
/// GP8, active low.
pub const ENABLE_MASK: u32 = 1 << 8;

/// The pins of one axis.
pub struct AxisPins {
    pub step: Output<'static>,
    /// High is the positive direction.
    pub dir: Output<'static>,
    /// To ground when pressed.
    pub limit: Input<'static>,
}

/// The wired console.
pub struct UartPins {
    pub uart: Peri<'static, UART0>,
    pub tx: Peri<'static, PIN_0>,
    pub rx: Peri<'static, PIN_1>,
}

/// All pins and peripherals that the firmware uses.
pub struct Board {
    /// X, Y, Z.
    pub axes: [AxisPins; 3],
    /// Low energises the motors.
    pub enable: Output<'static>,
    /// To ground when pressed.
    pub emergency_stop: Input<'static>,
    pub led: Output<'static>,
    pub usb: Peri<'static, USB>,
    pub uart: UartPins,
    pub watchdog: Peri<'static, WATCHDOG>,
}

impl Board {
    /// Motors off, no step, switches pulled up.
    pub fn new(p: Peripherals) -> Self {
        let low = Level::Low;
        Self {
            // First, so that the drivers are off as early as can be.
            enable: Output::new(p.PIN_8, Level::High),
            axes: [
                AxisPins {
                    step: Output::new(p.PIN_2, low),
                    dir: Output::new(p.PIN_3, low),
                    limit: Input::new(p.PIN_9, Pull::Up),
                },
                AxisPins {
                    step: Output::new(p.PIN_4, low),
                    dir: Output::new(p.PIN_5, low),
                    limit: Input::new(p.PIN_10, Pull::Up),
                },
                AxisPins {
                    step: Output::new(p.PIN_6, low),
                    dir: Output::new(p.PIN_7, low),
                    limit: Input::new(p.PIN_11, Pull::Up),
                },
            ],
            emergency_stop: Input::new(p.PIN_12, Pull::Up),
            led: Output::new(p.PIN_25, low),
            usb: p.USB,
            uart: UartPins { uart: p.UART0, tx: p.PIN_0, rx: p.PIN_1 },
            watchdog: p.WATCHDOG,
        }
    }
}
