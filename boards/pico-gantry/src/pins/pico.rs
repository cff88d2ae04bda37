//! The gantry on a Raspberry Pi Pico or Pico 2, which have the same pins, with a bare driver for each motor; see the table in `docs/bring-up.md`.

board! {
    step: [PIN_2, PIN_4, PIN_6, PIN_21],
    dir: [PIN_3, PIN_5, PIN_7, PIN_22],
    pio: [PIO0],
    channels: [DMA_CH0, DMA_CH1, DMA_CH2, DMA_CH3, DMA_CH4, DMA_CH5, DMA_CH6, DMA_CH7],
    enable: [PIN_8],
    limits: [PIN_9, PIN_10, PIN_11, PIN_26],
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
    start: [PIN_20],
    led: [PIN_25],
    driver_wire: [],
}

pub const NAME: &str = crate::chip::PICO;
