//! The gantry on a Raspberry Pi Pico 2 with four axes, one of which has a second motor: that is the fifth, on the pins that a Pico leaves
//! free, with the button for cycle start given up for its switch. All else is as in `pico`.

board! {
    step: [PIN_2, PIN_4, PIN_6, PIN_21, PIN_27],
    dir: [PIN_3, PIN_5, PIN_7, PIN_22, PIN_28],
    pio: [PIO0, PIO2],
    channels: [DMA_CH0, DMA_CH1, DMA_CH2, DMA_CH3, DMA_CH4, DMA_CH5, DMA_CH6, DMA_CH7, DMA_CH8, DMA_CH9],
    enable: [PIN_8],
    limits: [PIN_9, PIN_10, PIN_11, PIN_26, PIN_20],
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
    start: [],
    led: [PIN_25],
    driver_wire: [],
}

pub const NAME: &str = crate::chip::PICO;
