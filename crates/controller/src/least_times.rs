//! The times that moves last at least, of boards: so the firmware of one and the machine that is simulated like it have the same.

use isostep_motion::{LeastTimes, RampTimes};

/// An RP2040 of 125 MHz, emulated: `cargo xtask bench --least-times` measures all but those of the curved speed profiles and of moves
/// whose steps the processor makes. These are from the cycles of moves of 4 to 360 steps of three axes from corner to corner, `flow.*` of
/// `cargo xtask bench`.
pub const RP2040: LeastTimes = LeastTimes {
    straight_s: 0.59e-3,
    blend_s: 1.04e-3,
    join_s: 0.25e-3,
    together_s: 0.75e-3,
    shaped_s: 1.72e-3,
    box_s: 3.6e-3,
    box_root_step_s: 0.7e-3,
    queued_s: 0.6e-3,
    curved: [
        // S-curve, sine, linear, quadratic, sinusoidal, and the logarithmic one, which costs most.
        of_ms(1.0, 2.3),
        of_ms(2.0, 2.5),
        of_ms(1.0, 2.2),
        of_ms(1.0, 2.0),
        of_ms(6.0, 2.6),
        of_ms(14.0, 3.8),
    ],
};

/// An RP2350 of 150 MHz, emulated: each is at least a tenth more than `cargo xtask bench --least-times --board pico2` finds if what
/// flash's cache does not hold takes twice as long, because the timing of this core is assumed. That of a shaped run is a tenth more than
/// the 0.67 ms in which there is room for what ZV keeps of a move: the core is awake for 92 % then. Those that are not measured, of the
/// curved speed profiles and of moves whose steps the processor makes, are an RP2040's: 0.6 of them, as of moves without a blend and with
/// one, are too little for the quadratic profile.
pub const RP2350: LeastTimes = LeastTimes {
    straight_s: 0.35e-3,
    blend_s: 0.62e-3,
    join_s: 0.11e-3,
    together_s: 0.32e-3,
    shaped_s: 0.74e-3,
    box_s: 1.4e-3,
    box_root_step_s: 0.27e-3,
    queued_s: RP2040.queued_s,
    curved: RP2040.curved,
};

const fn of_ms(ramps_ms: f64, root_step_ms: f64) -> RampTimes {
    RampTimes { ramps_s: ramps_ms * 1e-3, root_step_s: root_step_ms * 1e-3 }
}
