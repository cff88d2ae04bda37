//! The clock of the chip: 170 MHz, from its own oscillator.

use embassy_stm32::Config;
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};

/// The clock of the processor, MHz.
pub const CORE_MHZ: u32 = 170;

/// The HAL's configuration. It makes the clock of `embassy-time` of a timer, TIM2 here.
#[must_use]
pub fn config() -> Config {
    let mut config = Config::default();
    // 16 MHz / 4 * 85 / 2.
    config.rcc.pll = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    // Above 150 MHz the chip needs it.
    config.rcc.boost = true;
    config
}
