//! The gantry on a Raspberry Pi Pico or Pico 2, which have the same pins, with a bare driver for each motor; see the table in `docs/bring-up.md`.
//!
//! A Pico 2 with four axes has a fifth motor, the second one of an axis. It is on the pins that a Pico leaves free, and its switch is where
//! the button for cycle start would be. On others one of these pins is the alarm of all drives, behind the limit switches, and the other says
//! when the board sends to a VFD; a proving image uses both otherwise.

/// Such a board, with what a fifth motor has, with another limit input, which is its switch or the alarm of drives, and with the button for
/// cycle start and the direction of RS-485 if they are there.
macro_rules! pico {
    (step: [$($step:ident)?], dir: [$($dir:ident)?], limit: [$($limit:ident)?], pio: [$($pio:ident)?], channels: [$($channel:ident),*], start: [$($start:ident)?], vfd_sends: [$($vfd_sends:ident)?]) => {
        board! {
            step: [PIN_2, PIN_4, PIN_6, PIN_21 $(, $step)?],
            dir: [PIN_3, PIN_5, PIN_7, PIN_22 $(, $dir)?],
            pio: [PIO0 $(, $pio)?],
            channels: [DMA_CH0, DMA_CH1, DMA_CH2, DMA_CH3, DMA_CH4, DMA_CH5, DMA_CH6, DMA_CH7 $(, $channel)*],
            enable: [PIN_8],
            limits: [PIN_9, PIN_10, PIN_11, PIN_26 $(, $limit)?],
            emergency_stop: PIN_12,
            tool: {
                pwm: PIN_13 of PWM_SLICE6,
                enable: PIN_14,
                direction: PIN_15,
                flood: PIN_16,
                mist: PIN_17,
                cut_off: [DMA_CH11],
            },
            probe: PIN_18,
            hold: PIN_19,
            start: [$($start)?],
            led: [PIN_25],
            driver_wire: [],
            vfd_sends: [$($vfd_sends)?],
        }
    };
}

#[cfg(drive_alarm)]
pico! { step: [], dir: [], limit: [PIN_27], pio: [], channels: [], start: [PIN_20], vfd_sends: [PIN_28] }
#[cfg(not(any(drive_alarm, five_motors)))]
pico! { step: [], dir: [], limit: [], pio: [], channels: [], start: [PIN_20], vfd_sends: [] }
#[cfg(five_motors)]
pico! { step: [PIN_27], dir: [PIN_28], limit: [PIN_20], pio: [PIO2], channels: [DMA_CH8, DMA_CH9], start: [], vfd_sends: [] }

pub const NAME: &str = crate::chip::PICO;
