//! `isostep prove` on the emulated board: its stamps are the emulator's own edges, and each fault is found and named.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use anyhow::Result;
use isostep::chip::Chip;
use isostep::prove::{self, Effort, How, Jumper, Link, Part, Proof, Stamps, Virtual};
use isostep::pty::{Emulated, Machine};
use isostep_tests::emulated::{board, cycles, is_pico_2};
use isostep_tests::root;
use isostep_trials::stride;

use crate::chip;

/// Of the move at 100,000 steps/s.
const STEPS: usize = 3_000;
const PADS: [u8; 3] = [2, 4, 6];

/// Some windows of the slowest rate; all edges by two stampers.
fn effort() -> Effort {
    Effort { rates: vec![100_000], windows: 1, pair_windows: 6, stops: 2, ..Effort::quick() }
}

fn how(part: Part) -> How {
    How { jumpers: Vec::new(), effort: effort(), laser: false, only: vec![part] }
}

/// The words on a link.
struct Overheard<L> {
    link: L,
    sent: Vec<u8>,
    /// The lines that arm stampers, move, and read stamps, each with the replies that followed.
    exchanges: Vec<(String, Vec<String>)>,
}

impl<L: Link> Link for Overheard<L> {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.sent.extend(bytes);
        while let Some(end) = self.sent.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.sent.drain(..=end).collect();
            let line = String::from_utf8_lossy(&line).trim_matches(['?', '\x18', '\n']).to_owned();
            self.exchanges.push((line, Vec::new()));
        }
        self.link.send(bytes)
    }

    fn line(&mut self, patience_s: f64) -> Result<Option<String>> {
        let line = self.link.line(patience_s)?;
        if let (Some(line), Some((_, replies))) = (&line, self.exchanges.last_mut()) {
            replies.push(line.clone());
        }
        Ok(line)
    }

    fn now_s(&self) -> f64 {
        self.link.now_s()
    }
}

struct Run {
    proof: Proof,
    exchanges: Vec<(String, Vec<String>)>,
    /// The cycles of each axis's edges, as the emulator has written them.
    edges: [Vec<u64>; 3],
}

/// The proving image pulls the pad as it hears of the stop. After that an edge rises only until the inhibit is on, and the axes
/// have one every 4 us. So there may be none, and the time from the pad to the last edge has no least value but 0.
const INHIBITED_US: f64 = 1.5;

impl Run {
    fn value(&self, key: &str) -> f64 {
        self.proof
            .found
            .figure(key)
            .and_then(|figure| figure.value)
            .unwrap_or_else(|| panic!("{key} in {:#?}", self.proof))
    }

    /// Checks that a figure is the longest time from the fall of the pad, the `falls`th of a move, to the last of the emulator's
    /// own edges of any axis, if it came later.
    fn stops_as_the_edges(&self, key: &str, falls: usize) {
        let own_us = self.own_latencies_us(falls);
        assert!(own_us.len() >= effort().stops as usize, "{own_us:?}");
        let longest_us = own_us.iter().copied().fold(0.0, f64::max);
        assert!(longest_us <= INHIBITED_US, "{key}: {own_us:?}");
        // Each of two stamps may be a unit of two cycles late, and stands for its middle.
        let most_us = 3.0 * chip().cycle_ns() * 1e-3;
        assert!((self.value(key) - longest_us).abs() <= most_us, "{key}: {} of {own_us:?}", self.value(key));
    }

    fn own_latencies_us(&self, falls: usize) -> Vec<f64> {
        let (mut begun, mut armed, mut latencies_us) = ([0; 3], Vec::new(), Vec::new());
        let mut stamps: Vec<Stamps> = Vec::new();
        for (line, replies) in &self.exchanges {
            if let Some(arming) = line.strip_prefix("$PROVE=ARM,") {
                armed = arming.split(',').map(|number| number.parse::<u32>().unwrap()).collect();
                stamps.clear();
            } else if line.starts_with("$PROVE=READ,") {
                stamps.push(Stamps::read(replies, armed[3]).unwrap());
            }
            if stamps.len() < 3 {
                continue;
            }
            let moves: [&[u64]; 3] = std::array::from_fn(|axis| one_move(&self.edges[axis][begun[axis]..]));
            begun = std::array::from_fn(|axis| begun[axis] + moves[axis].len());
            let seen = &stamps[..2];
            if seen.iter().all(|each| each.cycles.len() > 1 && each.counted.last() < Some(&(armed[3] + 512))) {
                let axis = PADS.iter().position(|pad| u32::from(*pad) == armed[0]).unwrap();
                let pulled = least_offset(moves[axis], &seen[0]) + u64::from(stamps[2].cycles[falls - 1]);
                let last = moves.iter().filter_map(|edges| edges.last()).max().unwrap();
                latencies_us.push(last.saturating_sub(pulled) as f64 * chip().cycle_ns() * 1e-3);
            }
            stamps.clear();
        }
        latencies_us
    }
}

/// The edges up to the next pause of 20 ms.
fn one_move(edges: &[u64]) -> &[u64] {
    let pause_cycles = cycles(20_000_000);
    edges.chunk_by(|one, next| next - one < pause_cycles).next().unwrap_or_default()
}

/// Proves the board that these options of the emulator make.
fn proved(name: &str, how: &How, options: &[&str]) -> Run {
    let elf = std::env::var_os("ISOSTEP_PROVE_ELF").expect("ISOSTEP_PROVE_ELF names the image: cargo xtask test");
    let folder = root().join("target/emulated").join(name);
    fs::create_dir_all(&folder).unwrap();
    let file: PathBuf = folder.join("edges");
    let mut command = Command::new("node");
    command.arg(root().join("tests/emulator/run.mjs")).arg("--elf").arg(elf).arg("--edges").arg(&file);
    command.args(["--board", &board()]);
    // A carriage that moves beyond its switch presses it.
    command.args(["--driver", "tmc2209", "--enable", "open", "--start", "900,900,900"]).args(options);
    let mut board = Emulated::start(&mut command, true, &[]).unwrap();
    board.set_open(true).unwrap();
    let link = Virtual::new(&mut board);
    let mut link = Overheard { link, sent: Vec::new(), exchanges: Vec::new() };
    let proof = prove::on(&mut link, how, &Arc::default(), &prove::Progress::begin()).unwrap();
    let exchanges = link.exchanges;
    board.close().unwrap();
    let mut edges: [Vec<u64>; 3] = Default::default();
    for word in fs::read(file).unwrap().chunks_exact(8) {
        let word = u64::from_le_bytes(word.try_into().unwrap());
        edges[(word >> 1 & 3) as usize].push(word >> 3);
    }
    Run { proof, exchanges, edges }
}

/// Each stamp is the emulator's edge of the same number, on its cycle or the next, by one offset for all stamps of a move.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn stamps_are_the_emulators_own_edges_one_by_one() {
    let run = proved("prove-stamps", &how(Part::Edges), &[]);
    assert_eq!((run.proof.found.broken(), &run.proof.found.remarks), (Vec::<String>::new(), &Vec::new()));
    let (mut moves, mut compared) = (0, 0);
    let (mut armed, mut stamped) = (Vec::new(), Vec::new());
    for (line, replies) in &run.exchanges {
        if let Some(arming) = line.strip_prefix("$PROVE=ARM,") {
            armed = arming.split(',').map(|number| number.parse::<u32>().unwrap()).collect();
            stamped.clear();
        } else if line.starts_with("G91 G0") {
            moves += 1;
        } else if line.starts_with("$PROVE=READ,") {
            let stamps = Stamps::read(replies, armed[3]).unwrap();
            assert!(!stamps.lost && stamps.cycles.len() > 100, "{line} after move {moves}");
            let axis = PADS.iter().position(|pad| u32::from(*pad) == armed[stamped.len()]).unwrap();
            stamped.push((axis, stamps));
            if stamped.len() == PADS.len() {
                let own = run.edges.each_ref().map(|edges| &edges[(moves - 1) * STEPS..moves * STEPS]);
                compared += compare(moves, own, &stamped);
            }
        }
    }
    // The first window of the move, and all of it by pairs: a move for each window and axis.
    assert_eq!((moves, compared > 20_000), (1 + 3 * 6, true), "{compared}");
}

/// Compares the stamps of a move, each with the axis that it is of, with that move's own edges. Returns how many there were.
fn compare(number_of_move: usize, own: [&[u64]; 3], stamped: &[(usize, Stamps)]) -> usize {
    // On a cruise a stamper may see each edge a cycle late; what sees it on its own cycle is another.
    let marked = stamped.iter().map(|(axis, stamps)| least_offset(own[*axis], stamps)).max().unwrap();
    let mut compared = 0;
    for (axis, stamps) in stamped {
        for (&cycle, &number) in stamps.cycles.iter().zip(&stamps.counted) {
            let from_mark = own[*axis][number as usize - 1] - marked;
            let late = i64::from(cycle) - from_mark as i64;
            assert!((0..=1).contains(&late), "edge {number} of axis {axis}, move {number_of_move}: {late} cycles off");
            compared += 1;
        }
    }
    compared
}

/// The cycle from which all stamps count, if none is earlier than its edge.
fn least_offset(own: &[u64], stamps: &Stamps) -> u64 {
    let offsets =
        stamps.cycles.iter().zip(&stamps.counted).map(|(cycle, number)| own[*number as usize - 1] - u64::from(*cycle));
    // On the edge's own cycle it is the largest.
    offsets.max().unwrap()
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_edge_that_comes_three_cycles_late_is_named() {
    // Y's pair is stamped in the third move.
    let shifted = format!("4:{}:3", 2 * STEPS + 300);
    let faults = proved("prove-shifted", &how(Part::Edges), &["--shift-edge", &shifted]).proof.found.faults;
    let late_ns = (3.0 * chip().cycle_ns()).round();
    assert_eq!(faults, [format!("at 3 x 100,000 steps/s: edge 300 of Y was {late_ns} ns late beside the others")]);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_edge_that_never_comes_is_named() {
    let faults = proved("prove-lost", &how(Part::Edges), &["--lose-edge", "6:400"]).proof.found.faults;
    assert_eq!(faults, ["at 3 x 100,000 steps/s: edge 400 of Z was lost"]);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_rate_that_the_board_cannot_make_is_named_with_its_alarm() {
    // The core of an RP2350 keeps up with every rate that the drivers' pulses allow, if it is as fast as is assumed.
    let slower: &[&str] = if is_pico_2() { &["--core-factor=2"] } else { &[] };
    let too_high = Effort { rates: vec![3_600_000], ..effort() };
    let faults = proved("prove-rate", &How { effort: too_high, ..how(Part::Edges) }, slower).proof.found.faults;
    let expected = "at 3 x 3,600,000 steps/s: the move ended in ALARM:22";
    assert!(faults.first().is_some_and(|fault| fault.starts_with(expected)), "{faults:?}");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn stops_by_a_wire_are_measured_and_a_wire_that_is_not_there_is_named() {
    let wired = How { jumpers: vec![Jumper::Limit], ..how(Part::Stops) };
    let run = proved("prove-wire", &wired, &["--jumper", "28:9"]);
    assert_eq!(run.proof.found.broken(), Vec::<String>::new(), "{:?}", run.proof.found.remarks);
    run.stops_as_the_edges("stop.9", 1);
    let pressed =
        proved("prove-estop", &How { jumpers: vec![Jumper::Estop], ..how(Part::Stops) }, &["--jumper", "28:12"]);
    assert_eq!((pressed.proof.found.broken(), &pressed.proof.found.remarks), (Vec::<String>::new(), &Vec::new()));
    pressed.stops_as_the_edges("stop.12", 1);
    let faults = proved("prove-no-wire", &wired, &[]).proof.found.faults;
    assert_eq!(faults, ["the limit switch did not stop the move: is the wire from GP28 to GP9 there?"]);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_second_reset_is_measured_and_the_crystal_is_found() {
    let both = How { only: vec![Part::Stops, Part::Crystal], ..how(Part::Stops) };
    // Frames that are longer make the chip's clock the faster one.
    let run = proved("prove-reset", &both, &["--frame-ppm=40"]);
    assert_eq!((run.proof.found.broken(), &run.proof.found.remarks), (Vec::<String>::new(), &Vec::new()));
    run.stops_as_the_edges("stop.reset", 2);
    assert!((run.value("crystal") - 40.0).abs() < 1.0, "{}", run.value("crystal"));
}

/// The board knows what its flash costs, whatever that is: within a twentieth.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_a_miss_costs_is_measured_by_the_board_itself() {
    let miss_cycles = match chip() {
        Chip::Rp2040 => 48.0,
        Chip::Rp2350 => 92.0,
    };
    for factor in [1.0, 2.0, 4.0].into_iter().step_by(stride(2)) {
        let run = proved("prove-miss", &how(Part::Cache), &[&format!("--miss-factor={factor}")]);
        let measured = run.proof.found.figure("cache.miss").and_then(|figure| figure.value).unwrap();
        let ratio = measured / (miss_cycles * factor);
        assert!((0.95..=1.05).contains(&ratio), "{measured} cycles at {factor} times");
    }
}
