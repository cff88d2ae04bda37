//! The use of each pin; see the table in `docs/bring-up.md`.

use embassy_rp::Peri;
use embassy_rp::Peripherals;
use embassy_rp::gpio::{Input, Level, Output, Pull};
#[cfg(not(feature = "timer-port"))]
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, DMA_CH2, DMA_CH3, DMA_CH4, DMA_CH5, DMA_CH6, DMA_CH7, PIO0};
use embassy_rp::peripherals::{
    DMA_CH11, FLASH, PIN_0, PIN_1, PIN_2, PIN_3, PIN_4, PIN_5, PIN_6, PIN_7, PIN_13, PIN_21, PIN_22, PIO1, PWM_SLICE6,
    UART0, USB, WATCHDOG,
};
#[cfg(feature = "prove")]
use embassy_rp::peripherals::{PIN_27, PIN_28};
use isostep_motion::{AXES, Contact};

/// STEP of the motors of X, Y and Z, then of the fourth motor, for code that must reach the pins without owning them. DIR
/// is on the pin after each.
pub const STEP: [usize; 4] = [2, 4, 6, 21];
pub const STEP_MASK: u32 = 1 << STEP[0] | 1 << STEP[1] | 1 << STEP[2] | 1 << STEP[3];
/// The fourth motor is the second one of an axis, or that of A.
pub const HAS_SECOND: bool = AXES == 3 && cfg!(not(feature = "prove"));
/// The index of the second motor.
pub const SECOND: usize = 3;
/// GP9. The limits of Y and Z and the emergency stop are on the three pins after it.
pub const LIMIT_X: u8 = 9;
/// The contact between the emergency stop's pin and ground. It is a property of the image: no console can change it.
pub const EMERGENCY_CONTACT: Contact =
    if cfg!(feature = "estop-nc") { Contact::NormallyClosed } else { Contact::NormallyOpen };
/// GP26: the fourth motor's.
pub const FOURTH_LIMIT: u8 = 26;
/// GP8, active low.
pub const ENABLE_MASK: u32 = 1 << 8;
/// GP13: the second output of PWM slice 6.
pub const TOOL_PWM: usize = 13;
/// GP14 to GP17: the other outputs of the tool.
pub const TOOL_SWITCHES: core::ops::Range<usize> = 14..18;
/// All outputs of the tool, one after the other.
pub const TOOL_PADS: [usize; 5] = [TOOL_PWM, 14, 15, 16, 17];
/// GP18.
pub const PROBE: usize = 18;
/// GP25.
pub const LED_MASK: u32 = 1 << 25;

/// The pins for steps, and the hardware that drives them for a hardware-timed port.
pub struct StepPins {
    pub x: Peri<'static, PIN_2>,
    pub y: Peri<'static, PIN_4>,
    pub z: Peri<'static, PIN_6>,
    /// High is the positive direction, unless the axis is inverted.
    pub x_dir: Peri<'static, PIN_3>,
    pub y_dir: Peri<'static, PIN_5>,
    pub z_dir: Peri<'static, PIN_7>,
    /// Of the second motor, which a setting gives to an axis, or of A.
    pub fourth: Peri<'static, PIN_21>,
    pub fourth_dir: Peri<'static, PIN_22>,
    #[cfg(not(feature = "timer-port"))]
    pub pio: Peri<'static, PIO0>,
    /// Two channels for each motor. Holding these values reserves the channels.
    #[cfg(not(feature = "timer-port"))]
    pub channels: DmaChannels,
}

/// DMA channels 0 to 7.
#[cfg(not(feature = "timer-port"))]
pub type DmaChannels = (
    Peri<'static, DMA_CH0>,
    Peri<'static, DMA_CH1>,
    Peri<'static, DMA_CH2>,
    Peri<'static, DMA_CH3>,
    Peri<'static, DMA_CH4>,
    Peri<'static, DMA_CH5>,
    Peri<'static, DMA_CH6>,
    Peri<'static, DMA_CH7>,
);

/// Inputs that stop the machine; they are connected to ground when pressed, or until then.
pub struct SwitchPins {
    /// X, Y, Z.
    pub limits: [Input<'static>; 3],
    /// The fourth motor's.
    pub fourth_limit: Input<'static>,
    pub emergency_stop: Input<'static>,
    /// The PIO block that watches all of them. The dead man's switch has another of its state machines.
    pub pio: Peri<'static, PIO1>,
}

/// The outputs of the tool, active high.
pub struct ToolPins {
    pub slice: Peri<'static, PWM_SLICE6>,
    pub pwm: Peri<'static, PIN_13>,
    pub enable: Output<'static>,
    pub direction: Output<'static>,
    pub flood: Output<'static>,
    pub mist: Output<'static>,
}

/// Inputs that switch to ground: the probe, and the buttons of feed hold and cycle start.
pub struct ControlPins {
    pub probe: Input<'static>,
    pub hold: Input<'static>,
    pub start: Input<'static>,
}

/// The wired console.
pub struct UartPins {
    pub uart: Peri<'static, UART0>,
    pub tx: Peri<'static, PIN_0>,
    pub rx: Peri<'static, PIN_1>,
}

/// The pads that only a proving image uses.
#[cfg(feature = "prove")]
pub struct ProvePins {
    /// At it the stampers begin.
    pub marker: Peri<'static, PIN_27>,
    /// A jumper leads it to a switch's input.
    pub out: Peri<'static, PIN_28>,
}

/// All pins and peripherals that the firmware uses.
pub struct Board {
    #[cfg(feature = "prove")]
    pub prove: ProvePins,
    pub steps: StepPins,
    pub switches: SwitchPins,
    /// Low energises the motors.
    pub enable: Output<'static>,
    pub tool: ToolPins,
    pub controls: ControlPins,
    pub led: Output<'static>,
    pub usb: Peri<'static, USB>,
    pub uart: UartPins,
    pub watchdog: Peri<'static, WATCHDOG>,
    /// The DMA channel of the dead man's switch.
    pub dead_man: Peri<'static, DMA_CH11>,
    pub flash: Peri<'static, FLASH>,
}

impl Board {
    /// Takes the pins: motors off, no step, tool off, switches pulled up.
    pub fn new(p: Peripherals) -> Self {
        Self {
            #[cfg(feature = "prove")]
            prove: ProvePins { marker: p.PIN_27, out: p.PIN_28 },
            // First, so that the drivers are switched off as early as possible.
            enable: Output::new(p.PIN_8, Level::High),
            steps: StepPins {
                x: p.PIN_2,
                y: p.PIN_4,
                z: p.PIN_6,
                x_dir: p.PIN_3,
                y_dir: p.PIN_5,
                z_dir: p.PIN_7,
                fourth: p.PIN_21,
                fourth_dir: p.PIN_22,
                #[cfg(not(feature = "timer-port"))]
                pio: p.PIO0,
                #[cfg(not(feature = "timer-port"))]
                channels: (p.DMA_CH0, p.DMA_CH1, p.DMA_CH2, p.DMA_CH3, p.DMA_CH4, p.DMA_CH5, p.DMA_CH6, p.DMA_CH7),
            },
            switches: SwitchPins {
                limits: [Input::new(p.PIN_9, Pull::Up), Input::new(p.PIN_10, Pull::Up), Input::new(p.PIN_11, Pull::Up)],
                fourth_limit: Input::new(p.PIN_26, Pull::Up),
                emergency_stop: Input::new(p.PIN_12, Pull::Up),
                pio: p.PIO1,
            },
            tool: ToolPins {
                slice: p.PWM_SLICE6,
                pwm: p.PIN_13,
                enable: Output::new(p.PIN_14, Level::Low),
                direction: Output::new(p.PIN_15, Level::Low),
                flood: Output::new(p.PIN_16, Level::Low),
                mist: Output::new(p.PIN_17, Level::Low),
            },
            controls: ControlPins {
                probe: Input::new(p.PIN_18, Pull::Up),
                hold: Input::new(p.PIN_19, Pull::Up),
                start: Input::new(p.PIN_20, Pull::Up),
            },
            led: Output::new(p.PIN_25, Level::Low),
            usb: p.USB,
            uart: UartPins { uart: p.UART0, tx: p.PIN_0, rx: p.PIN_1 },
            watchdog: p.WATCHDOG,
            dead_man: p.DMA_CH11,
            flash: p.FLASH,
        }
    }
}
