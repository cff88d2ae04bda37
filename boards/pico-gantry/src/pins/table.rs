//! The consequences of a board's table: its pins as numbers, and as values that own them.

/// A board. Motors and limit switches are those of X, Y, Z, then of the fourth motor.
macro_rules! board {
    (
        step: [$x:ident, $y:ident, $z:ident, $fourth:ident],
        dir: [$x_dir:ident, $y_dir:ident, $z_dir:ident, $fourth_dir:ident],
        enable: [$($enable:ident),+],
        limits: [$($limit:ident),+],
        emergency_stop: $emergency_stop:ident,
        tool: {
            pwm: $pwm:ident of $slice:ident,
            enable: $tool:ident,
            direction: $direction:ident,
            flood: $flood:ident,
            mist: $mist:ident,
            cut_off: [$($channel:ident),+],
        },
        probe: $probe:ident,
        hold: $hold:ident,
        start: $start:ident,
        led: [$($led:ident)?],
        driver_wire: [$($driver_tx:ident, $driver_rx:ident)?],
    ) => {
        use embassy_rp::gpio::{Input, Level, Output, Pull};
        use embassy_rp::{Peri, Peripherals, peripherals};

        use super::number::Number;

        pub const STEP: [usize; 4] = numbers![$x, $y, $z, $fourth];
        pub const DIR: [usize; 4] = numbers![$x_dir, $y_dir, $z_dir, $fourth_dir];
        pub const ENABLE: [usize; numbers![$($enable),+].len()] = numbers![$($enable),+];
        pub const LIMITS: [usize; 4] = numbers![$($limit),+];
        pub const EMERGENCY_STOP: usize = number!($emergency_stop);
        pub const TOOL_PWM: usize = number!($pwm);
        /// The other outputs of the tool.
        pub const TOOL_SWITCHES: [usize; 4] = numbers![$tool, $direction, $flood, $mist];
        pub const PROBE: usize = number!($probe);
        pub const LED: &[usize] = &numbers![$($led)?];

        pub type StepTypes = owned![$x, $y, $z, $fourth];
        pub type DirTypes = owned![$x_dir, $y_dir, $z_dir, $fourth_dir];
        pub type ToolSlice = peripherals::$slice;
        /// One for each group of the tool's pads next to each other.
        pub type CutOffChannels = owned![$($channel),+];
        pub const CUT_OFF_CHANNELS: usize = [$(stringify!($channel)),+].len();

        impl super::Board {
            /// Takes the pins: motors off, no step, tool off, switches pulled up.
            pub fn new(p: Peripherals) -> Self {
                Self {
                    #[cfg(feature = "prove")]
                    prove: super::ProvePins { marker: p.PIN_27, out: p.PIN_28 },
                    // First, so that the drivers are switched off as early as possible.
                    enable: super::Enables([$(Output::new(p.$enable, Level::High)),+]),
                    steps: super::StepPins {
                        step: (p.$x, p.$y, p.$z, p.$fourth),
                        dir: (p.$x_dir, p.$y_dir, p.$z_dir, p.$fourth_dir),
                        #[cfg(not(feature = "timer-port"))]
                        pio: p.PIO0,
                        #[cfg(not(feature = "timer-port"))]
                        channels: (
                            p.DMA_CH0, p.DMA_CH1, p.DMA_CH2, p.DMA_CH3, p.DMA_CH4, p.DMA_CH5, p.DMA_CH6, p.DMA_CH7,
                        ),
                    },
                    switches: super::SwitchPins {
                        limits: [$(Input::new(p.$limit, Pull::Up)),+],
                        emergency_stop: Input::new(p.$emergency_stop, Pull::Up),
                        pio: p.PIO1,
                    },
                    tool: super::ToolPins {
                        slice: p.$slice,
                        pwm: Output::new(p.$pwm, Level::Low),
                        enable: Output::new(p.$tool, Level::Low),
                        direction: Output::new(p.$direction, Level::Low),
                        flood: Output::new(p.$flood, Level::Low),
                        mist: Output::new(p.$mist, Level::Low),
                    },
                    controls: super::ControlPins {
                        probe: Input::new(p.$probe, Pull::Up),
                        hold: Input::new(p.$hold, Pull::Up),
                        start: Input::new(p.$start, Pull::Up),
                    },
                    led: [$(Output::new(p.$led, Level::Low))?].into_iter().next(),
                    $(driver_wire: super::DriverWirePins { uart: p.UART1, tx: p.$driver_tx, rx: p.$driver_rx },)?
                    usb: p.USB,
                    uart: super::UartPins { uart: p.UART0, tx: p.PIN_0, rx: p.PIN_1 },
                    watchdog: p.WATCHDOG,
                    output_watchdog: ($(p.$channel,)+),
                    flash: p.FLASH,
                }
            }
        }
    };
}

macro_rules! number {
    ($pin:ident) => {
        <peripherals::$pin as Number>::NUMBER
    };
}

macro_rules! numbers {
    ($($pin:ident),*) => {
        [$(number!($pin)),*]
    };
}

macro_rules! owned {
    ($($peripheral:ident),+) => {
        ($(Peri<'static, peripherals::$peripheral>,)+)
    };
}
