//! The use of each pin. A board is one file: which pins are what. Everything else follows from it.

#[macro_use]
mod table;
mod enables;
mod number;
#[cfg(not(feature = "skr-pico"))]
mod pico;
#[cfg(feature = "skr-pico")]
mod skr_pico;

use embassy_rp::Peri;
use embassy_rp::gpio::{Input, Output};
use embassy_rp::peripherals::{FLASH, PIN_0, PIN_1, PIO1, UART0, USB, WATCHDOG};
#[cfg(feature = "skr-pico")]
use embassy_rp::peripherals::{PIN_8, PIN_9, UART1};
#[cfg(feature = "prove")]
use embassy_rp::peripherals::{PIN_27, PIN_28};
use isostep_motion::AXES;

pub use self::enables::Enables;
#[cfg(not(feature = "skr-pico"))]
pub use self::pico::*;
#[cfg(feature = "skr-pico")]
pub use self::skr_pico::*;

#[cfg(all(feature = "skr-pico", rp2350))]
compile_error!("the chip of an SKR Pico is an RP2040: compile it for thumbv6m-none-eabi");
#[cfg(all(feature = "skr-pico", feature = "prove"))]
compile_error!("a proving image is for a Pico, whose pads it reads");

pub const STEP_MASK: u32 = mask(&STEP);
pub const ENABLE_MASK: u32 = mask(&ENABLE);
pub const LED_MASK: u32 = mask(LED);
pub const VFD_SENDS_MASK: u32 = mask(VFD_SENDS);
/// The motors that the board has pins for. The fourth is the second one of an axis, or that of A; where there is a fifth it is the
/// second one.
pub const MOTORS: usize = if cfg!(five_motors) { 5 } else { 4 };
/// The inputs that stop the machine, without the emergency stop: a switch of each motor, and the alarm of drives.
pub const LIMIT_INPUTS: usize = MOTORS + cfg!(drive_alarm) as usize;
pub const HAS_SECOND: bool = AXES < MOTORS && cfg!(not(feature = "prove"));
/// The index of the second motor.
pub const SECOND: usize = MOTORS - 1;

/// The pins for steps, and the hardware that drives them for a hardware-timed port.
pub struct StepPins {
    pub step: StepTypes,
    /// High is the positive direction, unless the axis is inverted.
    pub dir: DirTypes,
    #[cfg(not(feature = "timer-port"))]
    pub pio: StepPios,
    /// Holding these values reserves the channels.
    #[cfg(not(feature = "timer-port"))]
    pub channels: StepChannels,
}

/// Inputs that stop the machine; they are connected to ground when pressed, or until then.
pub struct SwitchPins {
    /// X, Y, Z, those of the motors after them, and the alarm of drives.
    pub limits: [Input<'static>; LIMIT_INPUTS],
    pub emergency_stop: Input<'static>,
    /// The PIO block that watches all of them. The output watchdog has another of its state machines.
    pub pio: Peri<'static, PIO1>,
}

/// The outputs of the tool, active high.
pub struct ToolPins {
    pub slice: Peri<'static, ToolSlice>,
    pub pwm: Output<'static>,
    pub enable: Output<'static>,
    pub direction: Output<'static>,
    pub flood: Output<'static>,
    pub mist: Output<'static>,
}

/// Inputs that switch to ground: the probe, and the buttons of feed hold and cycle start.
pub struct ControlPins {
    pub probe: Input<'static>,
    pub hold: Input<'static>,
    /// A board with five motors has no pin left for it.
    pub start: Option<Input<'static>>,
}

/// The wired console, or the wire to a VFD.
pub struct UartPins {
    pub uart: Peri<'static, UART0>,
    pub tx: Peri<'static, PIN_0>,
    pub rx: Peri<'static, PIN_1>,
    /// See [`VFD_SENDS`].
    pub vfd_sends: Option<Output<'static>>,
}

/// The wire of UART drivers.
#[cfg(feature = "skr-pico")]
pub struct DriverWirePins {
    pub uart: Peri<'static, UART1>,
    pub tx: Peri<'static, PIN_8>,
    pub rx: Peri<'static, PIN_9>,
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
    pub enable: Enables,
    pub tool: ToolPins,
    pub controls: ControlPins,
    /// Not every board has one.
    pub led: Option<Output<'static>>,
    #[cfg(feature = "skr-pico")]
    pub driver_wire: DriverWirePins,
    pub usb: Peri<'static, USB>,
    pub uart: UartPins,
    pub watchdog: Peri<'static, WATCHDOG>,
    /// The DMA channels of the output watchdog.
    pub output_watchdog: CutOffChannels,
    pub flash: Peri<'static, FLASH>,
}

/// The pin of a motor's STEP.
#[inline(always)]
pub fn step(motor: usize) -> usize {
    pin_of(const { packed(STEP) }, motor)
}

/// The pin of a motor's DIR.
#[inline(always)]
pub fn dir(motor: usize) -> usize {
    pin_of(const { packed(DIR) }, motor)
}

/// The bits of a pin among [`packed`] ones.
const PIN_BITS: usize = 5;

/// The pins of all motors in a word. A table of them would be in flash, which code that keeps deadlines may not read.
const fn packed(pins: [usize; MOTORS]) -> u32 {
    let (mut packed, mut motor) = (0, 0);
    while motor < MOTORS {
        packed |= (pins[motor] as u32) << (PIN_BITS * motor);
        motor += 1;
    }
    packed
}

#[inline(always)]
fn pin_of(packed: u32, motor: usize) -> usize {
    (packed >> (PIN_BITS * motor)) as usize % (1 << PIN_BITS)
}

const fn mask(pins: &[usize]) -> u32 {
    let (mut mask, mut next) = (0, 0);
    while next < pins.len() {
        mask |= 1 << pins[next];
        next += 1;
    }
    mask
}

/// The first of some pins, in ascending order.
pub const fn ascending<const ALL: usize, const FIRST: usize>(pins: [usize; ALL]) -> [usize; FIRST] {
    let (mut sorted, mut count) = ([0; FIRST], 0);
    while count < FIRST {
        let mut place = count;
        while place > 0 && sorted[place - 1] > pins[count] {
            sorted[place] = sorted[place - 1];
            place -= 1;
        }
        sorted[place] = pins[count];
        count += 1;
    }
    sorted
}

/// Pins next to each other.
#[derive(Clone, Copy)]
pub struct Group {
    pub first: usize,
    pub pins: usize,
}

/// The groups of pins that ascend.
pub const fn groups<const COUNT: usize>(pins: &[usize]) -> [Group; COUNT] {
    let (mut groups, mut group, mut first) = ([Group { first: 0, pins: 0 }; COUNT], 0, 0);
    while first < pins.len() {
        let end = group_end(pins, first);
        groups[group] = Group { first: pins[first], pins: end - first };
        (group, first) = (group + 1, end);
    }
    groups
}

pub const fn count_groups(pins: &[usize]) -> usize {
    let (mut count, mut first) = (0, 0);
    while first < pins.len() {
        (count, first) = (count + 1, group_end(pins, first));
    }
    count
}

/// The end of the group that begins at `first`: at the first pin that is not next to the one before.
const fn group_end(pins: &[usize], first: usize) -> usize {
    let mut end = first + 1;
    while end < pins.len() && pins[end] == pins[end - 1] + 1 {
        end += 1;
    }
    end
}
