//! The use of each pin. The types are the HAL's: what the crates ask for are the traits of `embedded-hal` alone.

use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{AnyPin, Level, Output, Pull, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{self, BufferedUart};
use embassy_stm32::{Peri, Peripherals, bind_interrupts, interrupt, peripherals};
use isostep_motion::AXES;

bind_interrupts!(struct Irqs {
    EXTI0 => exti::InterruptHandler<interrupt::typelevel::EXTI0>;
    EXTI1 => exti::InterruptHandler<interrupt::typelevel::EXTI1>;
    EXTI2 => exti::InterruptHandler<interrupt::typelevel::EXTI2>;
    EXTI9_5 => exti::InterruptHandler<interrupt::typelevel::EXTI9_5>;
    USART2 => usart::BufferedInterruptHandler<peripherals::USART2>;
});

/// STEP and DIR of an axis: two outputs are `MotorPins`.
pub type StepDir = (Output<'static>, Output<'static>);
/// A switch to ground: its edges are kept while nobody waits for them.
pub type Switch = ExtiInput<'static, Async>;

/// All that the machine is wired to.
pub struct Pins {
    /// Of X, Y and Z.
    pub motors: [StepDir; AXES],
    /// ENABLE of all drivers, active low: they begin switched off.
    pub enable: Output<'static>,
    /// The limit switches of X, Y and Z.
    pub limits: [Switch; AXES],
    /// The emergency stop.
    pub emergency_stop: Switch,
    /// The parts of the console's link.
    pub console: Console,
    /// The place where settings are kept.
    pub flash: Peri<'static, peripherals::FLASH>,
}

/// The UART that a Nucleo board leads to its USB plug.
pub struct Console {
    uart: Peri<'static, peripherals::USART2>,
    rx: Peri<'static, peripherals::PA3>,
    tx: Peri<'static, peripherals::PA2>,
}

impl Console {
    /// Opens both directions, 115,200 baud. Bytes wait in these buffers; what comes while the first one is full is lost.
    ///
    /// # Panics
    /// Never: 170 MHz make this rate.
    #[must_use]
    pub fn open(self, rx_bytes: &'static mut [u8], tx_bytes: &'static mut [u8]) -> BufferedUart<'static> {
        let Self { uart, rx, tx } = self;
        BufferedUart::new(uart, rx, tx, tx_bytes, rx_bytes, Irqs, usart::Config::default())
            .expect("the baud rate can be made")
    }
}

/// Makes the pins what they are.
#[must_use]
pub fn open(chip: Peripherals) -> Pins {
    let low = |pin: Peri<'static, AnyPin>| Output::new(pin, Level::Low, Speed::High);
    Pins {
        motors: [
            (low(chip.PC0.into()), low(chip.PC1.into())),
            (low(chip.PC2.into()), low(chip.PC3.into())),
            (low(chip.PC4.into()), low(chip.PC5.into())),
        ],
        enable: Output::new(chip.PB10, Level::High, Speed::Low),
        limits: [
            ExtiInput::new(chip.PB0, chip.EXTI0, Pull::Up, Irqs),
            ExtiInput::new(chip.PB1, chip.EXTI1, Pull::Up, Irqs),
            ExtiInput::new(chip.PB2, chip.EXTI2, Pull::Up, Irqs),
        ],
        emergency_stop: ExtiInput::new(chip.PB5, chip.EXTI5, Pull::Up, Irqs),
        console: Console { uart: chip.USART2, rx: chip.PA3, tx: chip.PA2 },
        flash: chip.FLASH,
    }
}
