//! Bytes, time and switches to the whole machine in the simulator.

use embassy_time::Duration;
use isostep_motion::{Axis, State};
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim, SwitchFault};

/// It lives no longer than that before the end, virtual time.
const LIFE_MS: u64 = 20_000;
/// What a reset may take: it brakes first, and a line that is stored takes its time.
const RESET_MS: u64 = 10_000;
const RESET: u8 = 0x18;

/// Sends `bytes` to a machine. Those that a console ignores do something else: 0xB0 to 0xBF let 0.1 ms to 3 s go by, 0xC0 to 0xCF
/// press or release an input.
///
/// # Panics
/// Where the machine falls silent, answers more lines than there are, loses or makes up a step, or leaves a tool on that has been
/// stopped.
pub fn run(bytes: &[u8]) {
    let mut config = Config { start_mm: [20.0, 30.0, 10.0], keep_record: false, ..Config::default() };
    // So that more of it happens within a life.
    config.settings.max_rate_mm_min = [12_000.0; 3];
    config.settings.accel_mm_s2 = [1_000.0; 3];
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
    /// Lines sent, and answers heard.
    lines: usize,
    answers: usize,
    is_pressed: [bool; 6],
    left_us: u64,
}

impl Bench {
    fn happens(&mut self, byte: u8) {
        match byte {
            // 100 us, twice as much, and so on.
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

    /// Lets go of everything; after a reset it says so, stands still where it says it does, and nothing is on.
    fn ends(mut self) {
        for input in 0..self.is_pressed.len() {
            if self.is_pressed[input] {
                self.press(input);
            }
        }
        // A line begun is not to be ended by what follows.
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
