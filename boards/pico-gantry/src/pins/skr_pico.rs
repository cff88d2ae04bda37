//! The BIGTREETECH SKR Pico V1.0, with four TMC2209; see the table in `docs/bring-up.md`.
//!
//! By the maker's names of the terminals: the motors X, Y, Z and E0, and the stops X, Y and Z. The emergency stop is on E0-STOP,
//! and the fourth motor's switch on THB, whose pin is next to that of Z-STOP, so that three state machines watch all. LASER is
//! the PWM, FAN1 enable, FAN2 direction, HB flood, HE mist. SERVOS is feed hold and TH0 cycle start. RGB is no input, as a buffer
//! drives it: it is high while the board sends to a VFD. It has no plain LED.

use isostep_controller::DriverHardware;

board! {
    step: [PIN_11, PIN_6, PIN_19, PIN_14],
    dir: [PIN_10, PIN_5, PIN_28, PIN_13],
    pio: [PIO0],
    channels: [DMA_CH0, DMA_CH1, DMA_CH2, DMA_CH3, DMA_CH4, DMA_CH5, DMA_CH6, DMA_CH7],
    enable: [PIN_12, PIN_7, PIN_2, PIN_15],
    limits: [PIN_4, PIN_3, PIN_25, PIN_26],
    emergency_stop: PIN_16,
    tool: {
        pwm: PIN_20 of PWM_SLICE2,
        enable: PIN_17,
        direction: PIN_18,
        flood: PIN_21,
        mist: PIN_23,
        cut_off: [DMA_CH11, DMA_CH10, DMA_CH9],
    },
    probe: PIN_22,
    hold: PIN_29,
    start: [PIN_27],
    led: [],
    driver_wire: [PIN_8, PIN_9],
    vfd_sends: [PIN_24],
}

/// The board's own addresses, and the resistors that it has.
pub const DRIVERS: DriverHardware = DriverHardware { addresses: [0, 2, 1, 3], sense_milliohms: 110 };

pub const NAME: &str = "BTT SKR Pico V1.0";
