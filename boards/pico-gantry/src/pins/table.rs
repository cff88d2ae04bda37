//! The consequences of a board's table: its pins as numbers, and as values that own them.

/// A board. Motors and limit switches are those of X, Y, Z, then of the fourth motor, and of the fifth. The alarm of drives is the last
/// of the limit inputs.
macro_rules! board {
    (
        step: [$($step:ident),+],
        dir: [$($dir:ident),+],
        pio: [$($pio:ident),+],
        channels: [$($channel:ident),+],
        enable: [$($enable:ident),+],
        limits: [$($limit:ident),+],
        emergency_stop: $emergency_stop:ident,
        tool: {
            pwm: $pwm:ident of $slice:ident,
            enable: $tool:ident,
            direction: $direction:ident,
            flood: $flood:ident,
            mist: $mist:ident,
            cut_off: [$($cut_off:ident),+],
        },
        probe: $probe:ident,
        hold: $hold:ident,
        start: [$($start:ident)?],
        led: [$($led:ident)?],
        driver_wire: [$($driver_tx:ident, $driver_rx:ident)?],
        vfd_sends: [$($vfd_sends:ident)?],
    ) => {
        use embassy_rp::gpio::{Input, Level, Output, Pull};
        use embassy_rp::{Peri, Peripherals, peripherals};

        use super::number::Number;

        pub const STEP: [usize; super::MOTORS] = numbers![$($step),+];
        pub const DIR: [usize; super::MOTORS] = numbers![$($dir),+];
        pub const ENABLE: [usize; numbers![$($enable),+].len()] = numbers![$($enable),+];
        pub const LIMITS: [usize; super::LIMIT_INPUTS] = numbers![$($limit),+];
        pub const EMERGENCY_STOP: usize = number!($emergency_stop);
        pub const TOOL_PWM: usize = number!($pwm);
        /// The other outputs of the tool.
        pub const TOOL_SWITCHES: [usize; 4] = numbers![$tool, $direction, $flood, $mist];
        pub const PROBE: usize = number!($probe);
        pub const LED: &[usize] = &numbers![$($led)?];
        /// High while the board sends on the wire to a VFD. Not every board has a pin left for it.
        pub const VFD_SENDS: &[usize] = &numbers![$($vfd_sends)?];

        pub type StepTypes = owned![$($step),+];
        pub type DirTypes = owned![$($dir),+];
        /// The blocks whose state machines make the steps.
        #[cfg(not(feature = "timer-port"))]
        pub type StepPios = owned![$($pio),+];
        /// Two for each motor.
        #[cfg(not(feature = "timer-port"))]
        pub type StepChannels = owned![$($channel),+];
        pub type ToolSlice = peripherals::$slice;
        /// One for each group of the tool's pads next to each other.
        pub type CutOffChannels = owned![$($cut_off),+];
        pub const CUT_OFF_CHANNELS: usize = [$(stringify!($cut_off)),+].len();

        impl super::Board {
            /// Takes the pins: motors off, no step, tool off, switches pulled up.
            pub fn new(p: Peripherals) -> Self {
                Self {
                    #[cfg(feature = "prove")]
                    prove: super::ProvePins { marker: p.PIN_27, out: p.PIN_28 },
                    // First, so that the drivers are switched off as early as possible.
                    enable: super::Enables([$(Output::new(p.$enable, Level::High)),+]),
                    steps: super::StepPins {
                        step: ($(p.$step,)+),
                        dir: ($(p.$dir,)+),
                        #[cfg(not(feature = "timer-port"))]
                        pio: ($(p.$pio,)+),
                        #[cfg(not(feature = "timer-port"))]
                        channels: ($(p.$channel,)+),
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
                        start: [$(Input::new(p.$start, Pull::Up))?].into_iter().next(),
                    },
                    led: [$(Output::new(p.$led, Level::Low))?].into_iter().next(),
                    $(driver_wire: super::DriverWirePins { uart: p.UART1, tx: p.$driver_tx, rx: p.$driver_rx },)?
                    usb: p.USB,
                    uart: super::UartPins {
                        uart: p.UART0,
                        tx: p.PIN_0,
                        rx: p.PIN_1,
                        vfd_sends: [$(Output::new(p.$vfd_sends, Level::Low))?].into_iter().next(),
                    },
                    watchdog: p.WATCHDOG,
                    output_watchdog: ($(p.$cut_off,)+),
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
