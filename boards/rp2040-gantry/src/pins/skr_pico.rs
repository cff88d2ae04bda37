//! The BIGTREETECH SKR Pico V1.0, with four TMC2209; see the table in `docs/bring-up.md`.
//!
//! The maker's names of its terminals: X, Y, Z and E0 motors and stops; FAN3 is the spindle's or laser's PWM, FAN1 its enable,
//! FAN2 its direction, HB flood, HE0 mist; PROBE the probe; RGB the emergency stop, next to the Z stop so that one state
//! machine watches both; THB feed hold and TH0 cycle start, whose pull-ups and filters are on the board. It has no plain LED.

board! {
    step: [PIN_11, PIN_6, PIN_19, PIN_14],
    dir: [PIN_10, PIN_5, PIN_28, PIN_13],
    enable: [PIN_12, PIN_7, PIN_2, PIN_15],
    limits: [PIN_4, PIN_3, PIN_25, PIN_16],
    emergency_stop: PIN_24,
    tool: {
        pwm: PIN_20 of PWM_SLICE2,
        enable: PIN_17,
        direction: PIN_18,
        flood: PIN_21,
        mist: PIN_23,
        cut_off: [DMA_CH11, DMA_CH10, DMA_CH9],
    },
    probe: PIN_22,
    hold: PIN_26,
    start: PIN_27,
    led: [],
}

pub const NAME: Option<&str> = Some("BTT SKR Pico V1.0");
