//! Random lines as people send them to a machine. Most of them are valid, some are not.

use std::fmt::Write;

use isostep_console::{AXIS_NAMES, Settings};
use isostep_motion::AXES;

use super::Random;
use super::scenario::PROBED;

/// Generates lines for one machine.
pub(super) struct Lines {
    /// True if the machine was homed before, so that positions are known.
    pub is_homed: bool,
    travel_mm: [f64; AXES],
    /// 1 if the travel is above zero, otherwise -1.
    side: [f64; AXES],
}

impl Lines {
    pub fn new(settings: &Settings) -> Self {
        let is_negative = |axis: usize| settings.homing_direction_mask & 1 << axis != 0;
        Self {
            is_homed: false,
            travel_mm: settings.travel_mm.map(f64::from),
            side: std::array::from_fn(|axis| if is_negative(axis) { 1.0 } else { -1.0 }),
        }
    }

    /// The next line, without its line end.
    pub fn next(&mut self, random: &mut Random) -> String {
        match random.below(40) {
            0..18 => self.movement(random),
            18..21 => self.arc(random),
            21..24 => self.jog(random),
            24..26 => format!("G4 P{:.3}", random.between(0.001, 0.5)),
            26..28 => tool(random),
            28 => self.probe(random),
            29..31 => offset(random),
            31 => random.of(&["G90", "G91", "G20", "G21", "G93", "G94", "G61.1", "G61", "G28.1", "G30.1"]).to_owned(),
            32 => random.of(&["$H", "$HX", "$HZ", "$H", "G28", "G30"]).to_owned(),
            33..35 => random.of(&["$$", "$#", "$G", "$I", "$N", "?", "$", "(what)", "", "%", "$X"]).to_owned(),
            35 => setting(random),
            36 => random.of(&["M0", "M1", "M2", "M30", "M6 T1", "$C", "$SLP", "$RST=#"]).to_owned(),
            37 => random
                .of(&["G1", "G2 X1", "X1e9", "G0 X-", "$999=1", "$J=", "G5", "$N0=G0X0", "G10 L2", "$J=X1"])
                .to_owned(),
            38 => "G1 X1 ".repeat(1 + random.below(30) as usize),
            _ => format!("N{} {}", random.below(10_000_000), self.movement(random)),
        }
    }

    fn place(&self, axis: usize, random: &mut Random) -> f64 {
        if self.is_homed {
            // A few targets are outside the travel.
            let far = if random.one_in(60) { 1.2 } else { 1.0 };
            self.side[axis] * self.travel_mm[axis] * far * random.0.rand_float()
        } else {
            // Around the start position, in the middle of the travel.
            self.travel_mm[axis] * 0.25 * (random.0.rand_float() * 2.0 - 1.0)
        }
    }

    pub fn movement(&self, random: &mut Random) -> String {
        let mut line = random.of(&["G0", "G1", "G1", "G90 G1", "G90 G0"]).to_owned();
        for (axis, letter) in AXIS_NAMES.into_iter().enumerate() {
            if random.below(5) < 3 {
                write!(line, " {letter}{:.3}", self.place(axis, random)).expect("a String takes all");
            }
        }
        if random.below(3) > 0 {
            write!(line, " F{:.1}", random.between(100.0, 20_000.0)).expect("a String takes all");
        }
        if random.one_in(4) {
            write!(line, " S{:.0}", random.0.rand_float() * 1_000.0).expect("a String takes all");
        }
        line
    }

    fn arc(&self, random: &mut Random) -> String {
        let turn = random.of(&["G2", "G3"]);
        let [x, y, i] = [0, 1, 0].map(|axis| self.place(axis, random));
        let feed = random.between(200.0, 5_000.0);
        match random.below(3) {
            0 => format!("G17 {turn} I{:.3} J0 F{feed:.0}", i / 4.0),
            1 => format!("G17 {turn} X{x:.3} Y{y:.3} R{:.3} F{feed:.0}", random.between(1.0, 30.0)),
            _ => format!("G18 {turn} I{:.3} K0.5 F{feed:.0}", i / 5.0),
        }
    }

    fn jog(&self, random: &mut Random) -> String {
        let axis = random.below(AXES as u64) as usize;
        let how = random.of(&["G91", "G91", "G90", "G53"]);
        let mm = if how == "G91" { random.0.rand_float() * 4.0 - 2.0 } else { self.place(axis, random) };
        format!("$J={how} G21 {}{mm:.3} F{:.0}", AXIS_NAMES[axis], random.between(60.0, 6_000.0))
    }

    fn probe(&self, random: &mut Random) -> String {
        let how = random.of(&["G38.2", "G38.3", "G38.4", "G38.5"]);
        let place_mm = self.place(PROBED as usize, random);
        format!("G90 {how} {PROBED}{place_mm:.3} F{:.0}", random.between(60.0, 600.0))
    }
}

fn tool(random: &mut Random) -> String {
    let how = random.of(&["M3", "M4", "M5", "M3", "M4", "M7", "M8", "M9", "M3 M8"]);
    if how.starts_with("M3") || how == "M4" { format!("{how} S{}", random.below(1_001)) } else { how.to_owned() }
}

fn offset(random: &mut Random) -> String {
    let mm = random.0.rand_float() * 2.0 - 1.0;
    match random.below(6) {
        0 => format!("G92 X{mm:.3}"),
        1 => "G92.1".to_owned(),
        2 => format!("G10 L2 P{} X{mm:.3} Y{mm:.3}", 1 + random.below(6)),
        3 => format!("G10 L20 P0 Z{mm:.3}"),
        4 => format!("G43.1 Z{mm:.3}"),
        _ => format!("G5{}", 4 + random.below(6)),
    }
}

/// A setting that may change at any time without making it another machine.
fn setting(random: &mut Random) -> String {
    let axis = random.below(3);
    match random.below(7) {
        0 => format!("$12{axis}={:.0}", random.between(50.0, 2_000.0)),
        1 => format!("$11{axis}={:.0}", random.between(600.0, 3_600.0)),
        2 => format!("$11={:.3}", random.between(0.001, 0.1)),
        3 => format!("$900={}", random.below(2)),
        4 => format!("$940={}", random.below(3)),
        5 => format!("$21={}", random.below(2)),
        _ => format!("$10={}", random.below(4)),
    }
}
