//! Sends bytes to the whole machine in the simulator, lets time pass, and presses its switches.

use crate::axes::xyz_a;
use embassy_time::Duration;
use isostep_motion::{Axis, State};
use isostep_sim::AXES;
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim, SwitchFault};

/// The longest virtual time before the end of a case.
const LIFE_MS: u64 = 20_000;
/// The longest time of a reset: the machine brakes first, and storing a line takes time.
const RESET_MS: u64 = 10_000;
const RESET: u8 = 0x18;

/// Sends `bytes` to a machine. Bytes that a console ignores have another effect: 0xB0 to 0xBF let 0.1 ms to 3 s pass,
/// 0xC0 to 0xCF press or release an input.
///
/// # Panics
/// When the machine does not answer, answers more lines than were sent, loses or invents a step, or leaves a tool on
/// after a stop.
pub fn run(bytes: &[u8]) {
    let mut config = Config { start_mm: xyz_a([20.0, 30.0, 10.0], 10.0), keep_record: false, ..Config::default() };
    // Faster than the default, so that more happens in a case.
    config.settings.max_rate_mm_min = [12_000.0; AXES];
    config.settings.accel_mm_s2 = [1_000.0; AXES];
    config.settings.homing_seek_mm_min = 3_000.0;
    let mut bench =
        Bench { sim: Sim::new(&config), lines: 0, answers: 0, is_pressed: [false; 6], left_us: LIFE_MS * 1_000 };
    for &byte in bytes {
        bench.happens(byte);
    }
    bench.ends();
}

struct Bench {
    sim: Sim,
    /// Number of lines sent, and of answers received.
    lines: usize,
    answers: usize,
    is_pressed: [bool; 6],
    left_us: u64,
}

impl Bench {
    fn happens(&mut self, byte: u8) {
        match byte {
            // 100 us, 200 us, and so on.
            0xB0..=0xBF => self.passes(100 << (byte - 0xB0)),
            0xC0..=0xCF => self.press(usize::from(byte - 0xC0) % self.is_pressed.len()),
            _ => {
                self.lines += usize::from(matches!(byte, b'\r' | b'\n'));
                self.sim.send(&[byte]);
            }
        }
    }

    fn passes(&mut self, us: u64) {
        let us = us.min(self.left_us);
        self.left_us -= us;
        self.runs_for(Duration::from_micros(us));
    }

    fn runs_for(&mut self, time: Duration) {
        self.sim.run_for(time).unwrap_or_else(|error| panic!("{error}"));
        let heard = self.sim.replies();
        self.answers += heard.iter().filter(|line| *line == "ok" || line.starts_with("error:")).count();
        assert!(self.answers <= self.lines, "{} answers to {} lines: {heard:?}", self.answers, self.lines);
    }

    fn press(&mut self, input: usize) {
        let pressed = !self.is_pressed[input];
        self.is_pressed[input] = pressed;
        match input {
            0 => self.sim.set_emergency_stop(pressed),
            1 => self.sim.set_hand_input(Wire::Probe, pressed),
            2 => self.sim.set_hand_input(Wire::Hold, pressed),
            3 => self.sim.set_hand_input(Wire::Start, pressed),
            _ => {
                let fault = if pressed { SwitchFault::StuckClosed } else { SwitchFault::None };
                self.sim.set_switch(Axis::ALL[input - 4], fault);
            }
        }
    }

    /// Releases all inputs and sends a reset. The machine must then send its welcome, stand still at the position that
    /// it reports, and have all outputs off.
    fn ends(mut self) {
        for input in 0..self.is_pressed.len() {
            if self.is_pressed[input] {
                self.press(input);
            }
        }
        // Time passes so that the next byte does not end a line that has begun.
        self.runs_for(Duration::from_millis(100));
        self.sim.send(&[RESET]);
        self.sim.run_for(Duration::from_millis(RESET_MS)).unwrap_or_else(|error| panic!("{error}"));
        let heard = self.sim.replies();
        assert!(heard.iter().any(|line| line.starts_with("Grbl")), "no welcome: {heard:?}");
        let state = self.sim.machine().state();
        assert!(matches!(state, State::Idle | State::Alarm(_)), "{state:?} after a reset");
        let (steps, position) = (self.sim.counted_steps(), self.sim.machine().position_steps());
        self.sim.send(b"?");
        self.sim.run_for(Duration::from_millis(100)).unwrap_or_else(|error| panic!("{error}"));
        let heard = self.sim.replies();
        assert!(heard.iter().any(|line| line.starts_with('<')), "no report: {heard:?}");
        assert_eq!(self.sim.counted_steps(), steps, "it moves after a reset");
        assert_eq!(position, steps, "steps were lost or made up");
        assert_eq!(self.sim.tool()[..2], [0, 0], "a tool is on after a reset");
    }
}
