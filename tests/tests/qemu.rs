//! The controller on a board of another architecture and another maker: `boards/qemu-lm3s6965`, in QEMU. The simulator
//! with the same step port says what it is to answer and where its steps are to be.
//!
//! `cargo xtask test` builds the board and runs these tests if `qemu-system-arm` is there. A plain `cargo test` ignores
//! them.

use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

use embassy_futures::block_on;
use isostep_controller::{Settings, Store};
use isostep_sim::flash::WordFlash;
use isostep_sim::{Config, Port, Sim};

/// QEMU's virtual time stands still while it waits for bytes, so nothing here depends on how fast the host is.
const PATIENCE: Duration = Duration::from_secs(60);
/// The variables that name the images of three axes and of two.
const IMAGE: &str = "ISOSTEP_QEMU_ELF";
const TWO_AXES_IMAGE: &str = "ISOSTEP_QEMU_TWO_AXES_ELF";
/// The place where the board's flash for settings begins, and its length.
const FLASH_BEGIN: u32 = 0x3_C000;
const FLASH_BYTES: u32 = 16 << 10;
/// The board's clock.
const TICKS_PER_US: f64 = 20.0;
/// The emulated processor takes 8 ns an instruction, as an RP2040 does, and some hundred of them from the clock to the pin.
const LATE_MAX_US: f64 = 10.0;

struct Board {
    qemu: Child,
    input: ChildStdin,
    lines: Receiver<String>,
    trace: PathBuf,
}

/// A rise of STEP.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    t_us: f64,
    axis: usize,
    direction: i32,
}

impl Board {
    /// Switches the board on. `test` names the file of its trace.
    fn new(test: &str) -> Self {
        Self::with(IMAGE, test, None)
    }

    /// The board with the image that this variable names, and with these contents of its flash for settings.
    fn with(image: &str, test: &str, flash: Option<&[u8]>) -> Self {
        let elf = env::var_os(image).expect("`cargo xtask test` sets it");
        let file = |end: &str| Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("qemu-{test}.{end}"));
        let trace = file("trace");
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args(["-M", "lm3s6965evb", "-nographic", "-monitor", "none", "-icount", "shift=3,sleep=off,align=off"]);
        qemu.arg("-kernel").arg(elf).args(["-serial", "stdio", "-serial"]).arg(format!("file:{}", trace.display()));
        if let Some(flash) = flash {
            let path = file("flash");
            fs::write(&path, flash).unwrap();
            qemu.arg("-device").arg(format!("loader,file={},addr={FLASH_BEGIN:#x},force-raw=on", path.display()));
        }
        qemu.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut qemu = qemu.spawn().expect("qemu-system-arm is installed");
        let (input, output) = (qemu.stdin.take().unwrap(), BufReader::new(qemu.stdout.take().unwrap()));
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        let mut board = Self { qemu, input, lines, trace };
        while !board.line().starts_with("Grbl") {}
        board
    }

    fn line(&mut self) -> String {
        self.lines.recv_timeout(PATIENCE).expect("the board answers")
    }

    fn send(&mut self, bytes: &[u8]) {
        self.input.write_all(bytes).unwrap();
        self.input.flush().unwrap();
    }

    /// Sends a line; returns what the board says to it.
    fn say(&mut self, line: &str) -> Vec<String> {
        self.send(format!("{line}\n").as_bytes());
        let mut said = Vec::new();
        loop {
            said.push(self.line());
            if said.last().is_some_and(|last| last == "ok" || last.starts_with("error:")) {
                return said;
            }
        }
    }

    /// Carries out lines that are all there before the first begins. So no corner waits for the next line, however slow the
    /// host is. Nothing is sent in motion: if QEMU takes a byte just when the processor goes to sleep, it may count the time
    /// since it woke twice, and steps are late.
    fn together(&mut self, lines: &[&str]) {
        self.send(format!("M0\n{}\nG4 P0.1\n", lines.join("\n")).as_bytes());
        self.until("<Hold");
        self.send(b"~");
        for _ in 0..lines.len() + 2 {
            while self.line() != "ok" {}
        }
    }

    /// A status report.
    fn status(&mut self) -> String {
        self.send(b"?");
        loop {
            let line = self.line();
            if line.starts_with('<') {
                return line;
            }
        }
    }

    /// The status, once it begins so.
    fn until(&mut self, state: &str) -> String {
        loop {
            let status = self.status();
            assert!(status.starts_with(state) || !status.starts_with("<Alarm"), "{status}");
            if status.starts_with(state) {
                return status;
            }
        }
    }

    fn edges(&self) -> Vec<Edge> {
        let trace = fs::read(&self.trace).unwrap();
        let of = |edge: &[u8]| {
            let word = u64::from_le_bytes(edge.try_into().unwrap());
            let direction = if word & 0x80 == 0 { -1 } else { 1 };
            Edge { t_us: (word >> 8) as f64 / TICKS_PER_US, axis: (word & 0x7F) as usize, direction }
        };
        trace.chunks_exact(8).map(of).collect()
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

/// The edges of each axis, us from the first of all, and where it stands after each.
fn by_axis(edges: &[Edge]) -> [Vec<(f64, i32)>; 3] {
    let first_us = edges.first().map_or(0.0, |edge| edge.t_us);
    [0, 1, 2].map(|axis| {
        let mut steps = 0;
        let of_axis = edges.iter().filter(|edge| edge.axis == axis);
        let place = |edge: &Edge| {
            steps += edge.direction;
            (edge.t_us - first_us, steps)
        };
        of_axis.map(place).collect()
    })
}

fn simulated(lines: &[&str]) -> Sim {
    let mut sim = Sim::new(&Config { port: Port::Timer, ..Config::default() });
    sim.run_until_idle().unwrap();
    sim.replies();
    for line in lines {
        sim.send(format!("{line}\n").as_bytes());
        sim.run_until_idle().unwrap();
    }
    sim
}

/// Every kind of line, and lines that are wrong.
const DIALECT: [&str; 24] = [
    "$G",
    "$#",
    "$N",
    "$100",
    "G20",
    "G21",
    "G90 G91",
    "G1",
    "G1 X1",
    "D1",
    "G54 G55",
    "G2 X1 Y1",
    "G4",
    "M2",
    "G10 L20 P2 X5",
    "G92 X3",
    "G92.1",
    "G38.2 X1",
    "T3",
    "S100",
    "$J=X1",
    "$E20",
    "$A1",
    "(a comment)",
];

#[test]
#[ignore = "needs QEMU and the board's image"]
fn it_says_what_the_simulator_says() {
    let mut board = Board::new("dialect");
    let mut sim = simulated(&[]);
    for line in DIALECT {
        sim.send(format!("{line}\n").as_bytes());
        sim.run_until_idle().unwrap();
        let mut said = board.say(line);
        // Nothing that it is told outlives a power cycle: QEMU's flash cannot be written.
        said.retain(|said| !said.starts_with("[MSG:The flash has refused"));
        let said: Vec<_> = said.iter().map(|said| said.replace("error:7", "ok")).collect();
        assert_eq!(said, sim.replies(), "{line}");
    }
}

#[test]
#[ignore = "needs QEMU and the board's image"]
fn corners_arcs_curved_ramps_and_blends_are_where_the_simulators_are() {
    let mut board = Board::new("program");
    let program = ["G1 X8 Y3 F1200", "X8.5 Y6", "G2 X4 Y6 I-2.25", "G1 Z2 F300", "X0 Y0 Z0 F1500"];
    // The third of these takes its corners by blends, and the last shapes them.
    for speed_profile in [&["$940=1"][..], &["$940=0"], &["G64 P0.05"], &["G64 P0.05", "$950=1"]] {
        let before = board.edges().len();
        for line in speed_profile.iter().chain(&["$11=0.02"]) {
            let said = board.say(line);
            assert!(said == ["ok"] || line.starts_with('$'), "{line}: {said:?}");
        }
        board.together(&program);
        let lines: Vec<_> = speed_profile.iter().copied().chain(["$11=0.02"]).chain(program).collect();
        let speed_profile = speed_profile.join(", ");
        let status = board.status();
        assert!(status.starts_with("<Idle|MPos:0.000,0.000,0.000"), "{status}");
        let mut sim = simulated(&[lines.join("\n").as_str()]);
        assert!(sim.replies().iter().all(|said| said == "ok"));
        let expected = sim.outcome().edges;
        let expected = expected.iter().map(|edge| Edge {
            t_us: edge.t_ns as f64 * 1e-3,
            axis: edge.axis,
            direction: edge.direction,
        });
        let (made, expected) = (by_axis(&board.edges()[before..]), by_axis(&expected.collect::<Vec<_>>()));
        for (axis, (made, expected)) in made.iter().zip(&expected).enumerate() {
            assert_eq!(made.len(), expected.len(), "{speed_profile}: axis {axis}");
            let mut worst_us = 0.0_f64;
            for (step, planned) in made.iter().zip(expected) {
                assert_eq!(step.1, planned.1, "{speed_profile}: axis {axis}");
                worst_us = worst_us.max((step.0 - planned.0).abs());
            }
            println!("{speed_profile}, axis {axis}: {} edges, at most {worst_us:.1} us off", made.len());
            assert!(worst_us < LATE_MAX_US, "{speed_profile}: axis {axis} is {worst_us} us off");
        }
    }
}

#[test]
#[ignore = "needs QEMU and the board's image"]
fn it_homes_and_a_limit_switch_stops_it() {
    let mut board = Board::new("homing");
    assert_eq!(board.say("$H"), ["ok"]);
    assert!(board.until("<Idle").starts_with("<Idle|MPos:0.000,0.000,0.000"));
    // A carriage is 6 mm from its switch at power-up.
    assert!(by_axis(&board.edges()).iter().all(|steps| steps.iter().any(|(_, steps)| *steps == -300)));
    board.say("$20=0");
    board.send(b"G0 X-20\n");
    while !board.line().starts_with("ALARM:1") {}
    // Once it is debounced.
    while !board.until("<Alarm").contains("Pn:X") {}
}

#[test]
#[ignore = "needs QEMU and the board's image"]
fn a_hold_and_a_reset_lose_no_step() {
    let mut board = Board::new("hold");
    assert_eq!(board.say("G1 X20 Y10 F600"), ["ok"]);
    while !board.status().starts_with("<Run|MPos:1.") {}
    board.send(b"!");
    board.until("<Hold:0");
    let held = board.edges().len();
    assert!(held > 0 && held < 1_500, "{held}");
    board.send(b"~");
    assert!(board.until("<Idle").starts_with("<Idle|MPos:20.000,10.000,0.000"));
    assert_eq!(board.say("G1 X0 Y0"), ["ok"]);
    while !board.status().starts_with("<Run|MPos:1") {}
    board.send(b"\x18");
    while !board.line().starts_with("Grbl") {}
    let [x, y, _] = by_axis(&board.edges()).map(|steps| steps.last().map_or(0, |(_, steps)| *steps));
    let [x_mm, y_mm] = [x, y].map(|steps| f64::from(steps) / 50.0);
    let status = board.until("<Idle");
    assert!(status.starts_with(&format!("<Idle|MPos:{x_mm:.3},{y_mm:.3},0.000")), "{status}");
}

/// The flash of a board with these start-up lines. It is read inverted.
fn flash_with(startup: [&str; 2]) -> Vec<u8> {
    let flash = WordFlash::<4, 1024>::blank();
    let mut store = Store::new(flash.clone(), 0..FLASH_BYTES, Settings::DEFAULT);
    block_on(store.load()).unwrap();
    let mut kept = store.kept().clone();
    kept.parameters.startup = startup.map(|line| line.try_into().unwrap());
    block_on(store.save(true, |item| kept.value(item))).unwrap();
    flash.bytes()[..FLASH_BYTES as usize].iter().map(|byte| !byte).collect()
}

/// The program comes from the flash: what comes by the link does so when the host gets to it. Three runs, because QEMU itself
/// may count time twice in one (see [`Board::together`]).
#[test]
#[ignore = "needs QEMU and the board's image"]
fn runs_are_the_same_to_the_byte() {
    let flash = flash_with(["G91G2X8Y4I4J2Z1F1200", "G4P0.1"]);
    let runs = ["first", "second", "third"].map(|run| {
        let mut board = Board::with(IMAGE, run, Some(&flash));
        let mut said = vec![board.line()];
        while !said.last().unwrap().starts_with(">G4") {
            said.push(board.line());
        }
        (said, fs::read(&board.trace).unwrap())
    });
    let [first @ (said, trace), second, third] = &runs;
    assert_eq!(said, &[">G91G2X8Y4I4J2Z1F1200:ok", ">G4P0.1:ok"]);
    assert_eq!(trace.len() % 8, 0);
    assert!(trace.len() > 8 * 800, "{}", trace.len());
    assert!(first == second || first == third || second == third);
}

/// Whatever is there in the place of the third axis takes no part in what the first two do.
#[test]
#[ignore = "needs QEMU and the board's images"]
fn a_board_of_two_axes_steps_as_one_of_three_of_which_one_stands() {
    let lines = ["$H", "G1 X8 Y3 F1200", "X8.5 Y6", "G2 X4 Y6 I-2.25", "G64 P0.05 G1 X0 Y0"];
    let [two, three] = [TWO_AXES_IMAGE, IMAGE].map(|image| {
        let mut board = Board::with(image, image, None);
        for line in lines {
            assert_eq!(board.say(line), ["ok"], "{image}: {line}");
        }
        assert!(board.until("<Idle").starts_with("<Idle|MPos:0.000,0.000,0.000"));
        let axes = board.say("$I").contains(&"[AXS:2:XY]".to_owned());
        assert_eq!(axes, image == TWO_AXES_IMAGE);
        by_axis(&board.edges()).map(|steps| steps.iter().map(|(_, place)| *place).collect::<Vec<_>>())
    });
    assert!(two[2].is_empty() && two[0].len() > 1_000);
    assert_eq!(two[..2], three[..2]);
}
