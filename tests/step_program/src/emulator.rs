//! The emulators: [rp2040-emu and rp2350-emu](https://github.com/0x4D44/picoem), by other authors, and the project's own.
//!
//! The PIO of an RP2350 takes the programs of an RP2040's, so the experiments are the same, with registers in other places.

use std::io::Write as _;
use std::mem;
use std::process::{Command, Stdio};

use crate::experiment::{
    EXECCTRL, Experiment, FLEVEL, IRQ, MACHINE_BYTES, SIO_OE, STATUS_OF_RX, Seen, dir_pin, rxf, txf,
};

const FIFO_WORDS: u32 = 8;
/// Those of the four state machines.
const EXECCTRL_FIRST: u32 = EXECCTRL;
const EXECCTRL_LAST: u32 = EXECCTRL + 3 * MACHINE_BYTES;
const RAM: u32 = 0x2000_0000;
/// Two NOP instructions of one cycle each.
const NOPS: u32 = 0xBF00_BF00;

#[derive(Clone, Copy, Debug)]
pub enum Emulator {
    Published,
    PublishedRp2350,
    Own,
}

/// Makes tests of functions of an emulator, on all of them.
macro_rules! on_each {
    ($($test:ident: $run:ident;)*) => {
        $crate::emulator::on_rp2040! { $($test: $run;)* }

        mod published_rp2350 {
            $(
                #[test]
                fn $test() {
                    super::$run($crate::emulator::Emulator::PublishedRp2350);
                }
            )*
        }
    };
}
pub(crate) use on_each;

/// The same, on those of an RP2040. In the other one the level of a pin reaches the state machines without the two cycles of the
/// synchroniser.
macro_rules! on_rp2040 {
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
pub(crate) use on_rp2040;

impl Emulator {
    /// The results of each state machine in each experiment.
    pub fn run(self, experiments: &[&Experiment]) -> Vec<Vec<Seen>> {
        match self {
            Self::Published => {
                experiments.iter().map(|experiment| of_rp2040::Published::new(experiment).run(experiment)).collect()
            }
            Self::PublishedRp2350 => {
                experiments.iter().map(|experiment| of_rp2350::Published::new(experiment).run(experiment)).collect()
            }
            Self::Own => own(experiments),
        }
    }

    /// The words that the only state machine puts into its RX FIFO, with their cycles.
    pub fn taken(self, experiment: &Experiment) -> Vec<(u64, u32)> {
        self.run(&[experiment]).remove(0).remove(0).taken
    }
}

/// An emulator by others, of a chip.
macro_rules! published {
    ($module:ident, $emulator:ident, $place:path, $before:expr, $is_a_cycle:expr) => {
        mod $module {
            use super::*;

            pub struct Published {
                chip: $emulator::Emulator,
                seen: Vec<Seen>,
                /// Number of words that each machine has received.
                fed: Vec<usize>,
                /// The levels of the pins, STEP and DIR.
                high: Vec<[bool; 2]>,
            }

            impl Published {
                pub fn new(experiment: &Experiment) -> Self {
                    let builder = $emulator::EmulatorBuilder::new($emulator::Config::default());
                    let Ok(mut chip) = builder.step_quantum(1).build() else { panic!("no chip") };
                    for (address, value) in $before {
                        chip.mmio_write32(address, value);
                    }
                    let machines = experiment.pins.len();
                    let seen = (0..machines).map(|_| Seen::default()).collect();
                    Self { chip, seen, fed: vec![0; machines], high: vec![[false; 2]; machines] }
                }

                pub fn run(mut self, experiment: &Experiment) -> Vec<Seen> {
                    self.chip.mmio_write32(RAM, NOPS);
                    self.write(&experiment.setup);
                    let mut writes = experiment.writes.iter().peekable();
                    for cycle in 0..experiment.cycles {
                        while let Some(&(_, address, value)) = writes.next_if(|write| write.0 == cycle) {
                            self.set(address, value);
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
                        self.set(address, value);
                    }
                }

                /// Writes a register of an RP2040's, where this chip has it.
                fn set(&mut self, address: u32, value: u32) {
                    let (address, value) = $place(address, value);
                    self.chip.mmio_write32(address, value);
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
                    assert!(self.chip.step().is_ok_and($is_a_cycle), "a NOP takes one cycle");
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
        }
    };
}

published!(of_rp2040, rp2040_emu, as_it_is, [(0_u32, 0_u32); 0], |cycles| cycles == 1);
// Its peripherals are reset at first. It tells all cycles since the beginning, and always advances by one.
published!(of_rp2350, rp2350_emu, in_rp2350, [(0x4002_0000, 0)], |_| true);

fn as_it_is(address: u32, value: u32) -> (u32, u32) {
    (address, value)
}

/// Where an RP2350 has a register of an RP2040's, and the bits of it.
fn in_rp2350(address: u32, value: u32) -> (u32, u32) {
    match address {
        EXECCTRL_FIRST..=EXECCTRL_LAST if (address - EXECCTRL_FIRST).is_multiple_of(MACHINE_BYTES) => {
            // STATUS_SEL is a bit further up, behind a wider STATUS_N.
            (address, value & !STATUS_OF_RX | (value & STATUS_OF_RX) << 1)
        }
        // The control registers and the pads of the pins. A pad is not isolated if its bit is 0.
        0x4001_4000..0x4001_8000 => (address - 0x4001_4000 + 0x4002_8000, value),
        0x4001_C000..0x4002_0000 => (address - 0x4001_C000 + 0x4003_8000, value),
        // Between the registers of SIO are those of pins above 31.
        SIO_OE => (0xD000_0030, value),
        _ => (address, value),
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
