//! Runs that are shaped by a box, whose acceleration changes all the time: each step takes a root of a cubic, and no port runs out of
//! steps.

use std::fmt::Write as _;

use isostep_sim::{AXES, Port};
use isostep_tests::emulated::Board;

/// A path of lines.
struct Path {
    name: &'static str,
    steps_per_mm: u32,
    accel_mm_s2: u32,
    box_hz: u32,
    /// The words of its corners.
    words: &'static str,
    /// The length of its shortest and of its longest line, mm.
    length_mm: [f64; 2],
    lines: u32,
    /// The most by which it turns at a corner, rad.
    turn: f64,
}

impl Path {
    /// Its corners, mm from its beginning. They come back to it.
    fn corners_mm(&self) -> Vec<[f64; 3]> {
        let [shortest_mm, longest_mm] = self.length_mm;
        let (mut angle, mut at_mm) = (0.0_f64, [0.0_f64; 3]);
        let along = (1..=self.lines / 2).map(|line| {
            let chance = f64::from(line * line) * 1.7;
            let length_mm = shortest_mm + (longest_mm - shortest_mm) * (0.5 + 0.5 * (chance * 3.1).cos());
            angle += self.turn * chance.sin();
            let [x, y, z] = [angle.cos(), angle.sin(), 0.4 * (0.7 * chance).sin()].map(|share| share * length_mm);
            at_mm = [at_mm[0] + x, at_mm[1] + y, at_mm[2] + z];
            at_mm
        });
        let there: Vec<_> = along.collect();
        let back: Vec<_> = there.iter().rev().skip(1).copied().chain([[0.0; 3]]).collect();
        [there, back].concat()
    }

    fn script(&self) -> String {
        let settings = [(950, 5), (960, self.box_hz), (100, self.steps_per_mm), (110, 12_000), (120, self.accel_mm_s2)];
        let mut script = "expect Grbl\n".to_owned();
        for (first, value) in settings {
            (0..AXES as u32).for_each(|axis| writeln!(script, "send ${}={value}\nexpect ok", first + axis).unwrap());
        }
        writeln!(script, "send G92 X0 Y0 Z0\nexpect ok\nsend G90 G1 F12000 {}\nexpect ok", self.words).unwrap();
        for [x, y, z] in self.corners_mm() {
            writeln!(script, "send X{x:.4} Y{y:.4} Z{z:.4}").unwrap();
        }
        script += &"expect ok\n".repeat(self.lines as usize);
        script + "wait-idle\nbytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000\n"
    }
}

/// Of each kind that was too much for the chip once: steps close together, slow and steep ones, and many moves in a box.
const PATHS: [Path; 3] = [
    Path {
        name: "long",
        steps_per_mm: 1_000,
        accel_mm_s2: 2_000,
        box_hz: 100,
        words: "",
        length_mm: [10.0, 20.0],
        lines: 4,
        turn: 1.0,
    },
    Path {
        name: "steep",
        steps_per_mm: 400,
        accel_mm_s2: 5_000,
        box_hz: 100,
        words: "G64 P0.05",
        length_mm: [0.02, 0.3],
        lines: 120,
        turn: 1.0,
    },
    Path {
        name: "tiny",
        steps_per_mm: 80,
        accel_mm_s2: 1_000,
        box_hz: 40,
        words: "G64 P0.02 Q0",
        length_mm: [0.013, 0.03],
        lines: 200,
        turn: 0.1,
    },
];

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_box_is_never_too_much_for_the_processor() {
    for path in PATHS {
        let name = format!("box-{}", path.name);
        let run = Board::stepped_by(Port::Pio, &name).with(&["--start", "300,300,300"]).script(&path.script());
        assert!(run.ok && !run.printed.contains("ALARM"), "{name}: {}", run.printed);
        let last_ns = run.edges.last().expect("it moves").t_ns;
        println!("{name}: {:.3} s of moves (emulated)", (last_ns - run.edges[0].t_ns) as f64 * 1e-9);
    }
}
