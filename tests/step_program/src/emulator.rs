//! The two emulators: [rp2040-emu](https://github.com/0x4D44/picoem), by other authors, and the project's own.

use std::io::Write as _;
use std::mem;
use std::process::{Command, Stdio};

use rp2040_emu::{Config, EmulatorBuilder};

use crate::experiment::{Experiment, FLEVEL, IRQ, Seen, dir_pin, rxf, txf};

const FIFO_WORDS: u32 = 8;
const RAM: u32 = 0x2000_0000;
/// Two NOP instructions of one cycle each.
const NOPS: u32 = 0xBF00_BF00;

#[derive(Clone, Copy, Debug)]
pub enum Emulator {
    Published,
    Own,
}

/// Makes tests of functions of an emulator, on both.
macro_rules! on_both {
    ($($test:ident: $run:ident;)*) => {
        mod published {
            $(
                #[test]
                fn $test() {
                    super::$run($crate::emulator::Emulator::Published);
                }
            )*
        }

        mod own {
            $(
                #[test]
                #[ignore = "needs Node's packages: cargo xtask test"]
                fn $test() {
                    super::$run($crate::emulator::Emulator::Own);
                }
            )*
        }
    };
}
pub(crate) use on_both;

impl Emulator {
    /// The results of each state machine in each experiment.
    pub fn run(self, experiments: &[&Experiment]) -> Vec<Vec<Seen>> {
        match self {
            Self::Published => {
                experiments.iter().map(|experiment| Published::new(experiment).run(experiment)).collect()
            }
            Self::Own => own(experiments),
        }
    }

    /// The words that the only state machine puts into its RX FIFO, with their cycles.
    pub fn taken(self, experiment: &Experiment) -> Vec<(u64, u32)> {
        self.run(&[experiment]).remove(0).remove(0).taken
    }
}

struct Published {
    chip: rp2040_emu::Emulator,
    seen: Vec<Seen>,
    /// Number of words that each machine has received.
    fed: Vec<usize>,
    /// The levels of the pins, STEP and DIR.
    high: Vec<[bool; 2]>,
}

impl Published {
    fn new(experiment: &Experiment) -> Self {
        let chip = EmulatorBuilder::new(Config::default()).step_quantum(1).build().expect("a chip");
        let machines = experiment.pins.len();
        let seen = (0..machines).map(|_| Seen::default()).collect();
        Self { chip, seen, fed: vec![0; machines], high: vec![[false; 2]; machines] }
    }

    fn run(mut self, experiment: &Experiment) -> Vec<Seen> {
        self.chip.mmio_write32(RAM, NOPS);
        self.write(&experiment.setup);
        let mut writes = experiment.writes.iter().peekable();
        for cycle in 0..experiment.cycles {
            while let Some(&(_, address, value)) = writes.next_if(|write| write.0 == cycle) {
                self.chip.mmio_write32(address, value);
            }
            self.feed(&experiment.words);
            self.step();
            self.note(cycle + 1, &experiment.pins);
            if cycle >= experiment.takes_from {
                self.take(cycle + 1);
            }
        }
        self.write(&experiment.finish);
        for (machine, seen) in (0..).zip(&mut self.seen) {
            seen.count = self.chip.mmio_read32(rxf(machine));
        }
        self.seen
    }

    fn write(&mut self, writes: &[(u32, u32)]) {
        for &(address, value) in writes {
            self.chip.mmio_write32(address, value);
        }
    }

    fn feed(&mut self, words: &[Vec<u32>]) {
        let levels = self.chip.mmio_read32(FLEVEL);
        for (machine, (words, fed)) in (0..).zip(words.iter().zip(&mut self.fed)) {
            if levels >> (8 * machine) & 0xF < FIFO_WORDS && *fed < words.len() {
                self.chip.mmio_write32(txf(machine), words[*fed]);
                *fed += 1;
            }
        }
    }

    fn take(&mut self, cycle: u64) {
        let levels = self.chip.mmio_read32(FLEVEL);
        for (machine, seen) in (0..).zip(&mut self.seen) {
            if levels >> (8 * machine + 4) & 0xF != 0 {
                seen.taken.push((cycle, self.chip.mmio_read32(rxf(machine))));
            }
        }
    }

    /// Advances one cycle. Time passes only while the core runs, so the core is kept at the same NOP.
    fn step(&mut self) {
        self.chip.core_mut(0).regs.set_pc(RAM);
        assert_eq!(self.chip.step().expect("a step"), 1, "a NOP takes one cycle");
    }

    fn note(&mut self, cycle: u64, pins: &[u8]) {
        let flags = self.chip.mmio_read32(IRQ);
        for (machine, (&pin, seen)) in pins.iter().zip(&mut self.seen).enumerate() {
            let [step, dir] = &mut self.high[machine];
            if replaced(step, self.chip.gpio_read(pin)) {
                let edges = if *step { &mut seen.rises } else { &mut seen.falls };
                edges.push(cycle);
            }
            if replaced(dir, self.chip.gpio_read(dir_pin(pin))) {
                seen.turns.push((cycle, *dir));
            }
            if flags >> machine & 1 != 0 {
                seen.halt.get_or_insert(cycle);
            }
        }
    }
}

/// Sets the level to `now`. Returns whether it has changed.
fn replaced(level: &mut bool, now: bool) -> bool {
    mem::replace(level, now) != now
}

/// Runs the experiments on the project's own emulator by its script.
fn own(experiments: &[&Experiment]) -> Vec<Vec<Seen>> {
    let mut node = Command::new("node");
    node.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../emulator/support/pio-words.mjs"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
    let mut node = node.spawn().expect("node runs");
    let mut stdin = node.stdin.take().expect("a pipe");
    let input = serde_json::to_vec(experiments).expect("numbers");
    // The process may have ended already. Its error is reported below.
    let sent = stdin.write_all(&input);
    drop(stdin);
    let output = node.wait_with_output().expect("node runs");
    assert!(output.status.success(), "node says above what is wrong; `cargo xtask test` installs what it needs");
    sent.expect("node reads the experiments");
    let seen: Vec<Vec<Seen>> = serde_json::from_slice(&output.stdout).expect("what the machines did");
    assert_eq!(seen.len(), experiments.len());
    seen
}
