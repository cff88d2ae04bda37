//! `cargo xtask test`: runs all tests, the fast ones first.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Error, Result, anyhow, bail};
use isostep_trials::{AMOUNT_VARIABLE, Amount};

#[cfg(unix)]
use crate::clients::{cncjs, grbl_streamer, pymodbus};
use crate::footprint::Footprint;
use crate::process::{self, announce};
#[cfg(unix)]
use crate::python::missing;
use crate::toolchain::{self, cargo, cargo_xtask, firmware_cargo};
use crate::variant::{Axes, Board, Contact, Driver, Port, Variant};
use crate::{build, cpu, node, oracle, other_chip, publish, web, workspace};
use isostep::stopwatch::Stopwatch;

/// Run the tests: host, emulator, firmware size, emulated board, real senders
#[derive(clap::Args)]
#[command(after_help = "\
Of each random test a few cases are tried, with ISOSTEP_CASES=more as many as CI tries, or with --all every one. The first stage
that fails is the last, but not with --all, which tells what failed at its end:
  host tests       unit, property and end-to-end tests in virtual time
  emulator tests   the emulated board's own, and with ISOSTEP_CASES=more or --all the step program on it as on a published
                   emulator
  firmware         its build, and its size budgets
  emulated board   the firmware, unmodified, in an emulated RP2040; with ISOSTEP_CASES=more or --all the other images too: of
                   TimerPort, of the proof, of a normally closed emergency stop, of faster drivers, and a dozen tests each of
                   four axes and of an SKR Pico
  another board    the firmware of boards/qemu-lm3s6965 in QEMU, of three axes, and with ISOSTEP_CASES=more or --all of two;
                   skipped without qemu-system-arm
  another chip     the firmwares of boards/stm32g474 link for a Cortex-M4F; only with --all, and skipped where rustup cannot add
                   that target
  slow clock       the machine by a clock of 32,768 Hz; only with --all
  two axes         the machine of X and Y alone; only with --all
  four axes        the machine with A: its own tests, and its firmware on the emulated board; only with --all
  SKR Pico         its firmware on the emulated board, with its pins and drivers; only with --all
  Pico 2           its firmware on the emulated board, with its chip, an RP2350; with ISOSTEP_CASES=more some of the tests, with --all
                   each but those of other boards, its proof too, the emulated core against Unicorn's, which comes from PyPI, and its
                   doubles against this computer's
  page             what it makes of a machine's words; with --all also in Chromium, with the simulated machine and the emulated
                   board, skipped without Chromium
  another VFD      a slave of pymodbus, from PyPI, turns the spindle of the simulated machine; skipped without Python 3
  real senders     grbl-streamer from PyPI streams programs to the simulated machine and to the emulated board, as over a
                   serial port, with a laser and a spindle too; skipped without Python 3, unless --senders asks for it
  every image      clippy and rustdoc of every image of the firmware; only with --all
  audit            cargo xtask audit; only with --all
  worlds           a thousand of the swarm; only with --all
  mutants          20 of the console's; only with --all
  publishing       each crate that could be published compiles from what would be uploaded; only with --all
  release          cargo xtask dist; only with --all
  bench            cargo xtask bench --quick; only with --all

Examples:
  cargo xtask test --all                 every random case, not a few of each kind
  cargo xtask test --all --only firmware --only \"Pico 2\"
                                         two of the stages
  cargo xtask test --fast                the host tests alone
  cargo xtask test --senders             the real senders alone
  cargo xtask test --senders --cncjs     with cncjs, of which 230 MB are installed into target/clients")]
pub struct Args {
    /// All random cases, of which otherwise a few are tried
    #[arg(long)]
    all: bool,
    /// Only the host tests
    #[arg(long)]
    fast: bool,
    /// Only the real senders
    #[arg(long, conflicts_with = "fast")]
    senders: bool,
    /// cncjs from npm too, after the others
    #[arg(long)]
    cncjs: bool,
    /// Only this stage; may be given for several. Those of the emulated boards need `firmware` before them
    #[arg(long, value_name = "STAGE", conflicts_with_all = ["fast", "senders"])]
    only: Vec<String>,
}

type Stage = (&'static str, fn(Amount) -> Result<()>);

/// A verb of `cargo xtask`, which runs as it would by hand. The tests may have replaced the executable of this process.
macro_rules! verb {
    ($name:literal, $($arg:literal),+) => { ($name, |_| process::run(cargo_xtask().args([$($arg),+]))) };
}

/// `cargo test` that tries so many random cases.
fn cargo_test(amount: Amount) -> Command {
    let mut tests = cargo("test");
    tests.env(AMOUNT_VARIABLE, amount.value());
    if amount == Amount::All {
        tests.arg("--no-fail-fast");
    }
    tests
}

/// Everything is compiled once more for each of these three.
const SLOW_CLOCK: Stage = ("slow clock", slow_clock);
const TWO_AXES: Stage = ("two axes", two_axes);
const FOUR_AXES: Stage = ("four axes", four_axes);
/// Its firmware has pins of its own.
const SKR_PICO: Stage = ("SKR Pico", skr_pico);
/// Its firmware is for another chip.
const PICO_2: Stage = ("Pico 2", pico_2);

/// These need more than Rust and Node.
const PAGE: Stage = ("page", page);
const ANOTHER_BOARD: Stage = ("another board", another_board);
const ANOTHER_CHIP: Stage = ("another chip", another_chip);
const ANOTHER_VFD: Stage = ("another VFD", |_| pymodbus());
const SENDERS: Stage = ("real senders", senders);

/// The stages that a release needs besides, and take long.
const RELEASE: [Stage; 7] = [
    verb!("every image", "lint", "--all"),
    verb!("audit", "audit"),
    ("worlds", |_| worlds()),
    verb!("mutants", "mutants", "console", "--sample", "20", "--least", "80"),
    ("publishing", |_| publish::check()),
    verb!("release", "dist"),
    verb!("bench", "bench", "--quick"),
];

const STAGES: [Stage; 14] = [
    ("host tests", host),
    ("emulator tests", emulator),
    ("firmware", firmware),
    ("emulated board", emulated_board),
    ANOTHER_BOARD,
    ANOTHER_CHIP,
    SLOW_CLOCK,
    TWO_AXES,
    FOUR_AXES,
    SKR_PICO,
    PICO_2,
    PAGE,
    ANOTHER_VFD,
    SENDERS,
];

pub fn run(args: Args) -> Result<()> {
    let stages = match args {
        Args { fast: true, .. } => &STAGES[..1],
        Args { senders: true, .. } => &STAGES[STAGES.len() - 1..],
        Args { .. } => &STAGES[..],
    };
    let more: &[Stage] = if args.cncjs { &[("cncjs", |_| cncjs())] } else { &[] };
    let amount = if args.all { Amount::All } else { Amount::of_run().map_err(Error::msg)? };
    let release = if args.all && !args.fast && !args.senders { &RELEASE[..] } else { &[] };
    let stages: Vec<_> = stages.iter().chain(more).chain(release).collect();
    let stages = chosen(stages, &args.only)?;
    let mut summary = format!("{:<16} {:<8}{:>8}{:>8}\n", "stage", "", "wall s", "CPU s");
    let mut failures = Vec::new();
    let all = Watch::start();
    // Cargo has become this process, which so inherits the time of its compilers.
    if let Some(cpu_s) = all.cpu_s {
        summary += &format!("{:<16} {:<8}{:>8}{cpu_s:>8.1}\n", "cargo xtask", "built", "");
    }
    for (index, (name, stage)) in stages.iter().enumerate() {
        if !failures.is_empty() && !args.all {
            summary += &format!("{name:<16} not run\n");
            continue;
        }
        if let Some(why) = why_skipped(name, &args) {
            summary += &format!("{name:<16} skipped: {why}\n");
            continue;
        }
        announce(&format!("{name}, stage {} of {}", index + 1, stages.len()));
        let watch = Watch::start();
        let outcome = stage(amount);
        let verdict = if outcome.is_ok() { "ok" } else { "FAILED" };
        summary += &format!("{name:<16} {verdict:<8}{}\n", watch.spent());
        failures.extend(outcome.err().map(|error| format!("{name}: {error:#}")));
    }
    print!("\n{summary}{:<16} {:<8}{}\n", "the stages", "", all.spent());
    if failures.is_empty() { Ok(()) } else { Err(anyhow!("{}", failures.join("\n"))) }
}

/// The stages with these names, or all of them if there are no names.
fn chosen<'a>(stages: Vec<&'a Stage>, only: &[String]) -> Result<Vec<&'a Stage>> {
    let unknown = only.iter().find(|name| !stages.iter().any(|(stage, _)| stage == name));
    if let Some(unknown) = unknown {
        let names: Vec<_> = stages.iter().map(|(name, _)| *name).collect();
        bail!("--only {unknown}: there is no such stage here, but {}; some are only with --all", names.join(", "));
    }
    Ok(stages.into_iter().filter(|(stage, _)| only.is_empty() || only.iter().any(|name| name == stage)).collect())
}

/// A plain run leaves these out: they compile everything once more, or, as another chip, what the lints have compiled but for the
/// links.
const ONLY_WITH_ALL: [&str; 5] = [ANOTHER_CHIP.0, SLOW_CLOCK.0, TWO_AXES.0, FOUR_AXES.0, SKR_PICO.0];

/// Why a stage is left out: `--all` alone runs it, or this machine lacks what it needs.
fn why_skipped(stage: &str, args: &Args) -> Option<String> {
    if !args.all && ONLY_WITH_ALL.contains(&stage) {
        Some("--all runs it".into())
    } else if stage == ANOTHER_VFD.0 || stage == SENDERS.0 && !args.senders {
        missing().map(String::from)
    } else if stage == ANOTHER_BOARD.0 {
        let is_there = process::printed(Command::new("qemu-system-arm").arg("--version")).is_some();
        (!is_there).then(|| "install qemu-system-arm, on Debian by `apt-get install qemu-system-arm`".into())
    } else if stage == ANOTHER_CHIP.0 {
        other_chip::missing()
    } else if stage == PAGE.0 && args.all {
        web::missing().map(String::from)
    } else {
        None
    }
}

/// Time that something takes, and for how long it occupies a processor.
struct Watch {
    wall: Stopwatch,
    cpu_s: Option<f64>,
}

impl Watch {
    fn start() -> Self {
        Self { wall: Stopwatch::start(), cpu_s: cpu::spent_s() }
    }

    /// Two columns of the summary.
    fn spent(&self) -> String {
        let cpu_s = self.cpu_s.zip(cpu::spent_s()).map(|(start_s, now_s)| format!("{:.1}", now_s - start_s));
        format!("{:>8.1}{:>8}", self.wall.elapsed_s(), cpu_s.unwrap_or_default())
    }
}

fn host(amount: Amount) -> Result<()> {
    process::run(&mut cargo_test(amount))?;
    // What the firmware of a Pico has. Few random cases are enough here: what remains computes as it did above.
    let args = ["--package=isostep-console", "--no-default-features", "--lib", "--test=it"];
    process::run(cargo_test(Amount::Few).args(args))
}

fn emulator(amount: Amount) -> Result<()> {
    node::prepare()?;
    process::run(&mut node::npm("test"))?;
    if amount == Amount::Few {
        return Ok(());
    }
    // A plain `cargo test` does without what these compile, and they ignore what needs Node.
    process::run(cargo_test(amount).args(["--package=isostep-step-program", "--lib", "--", "--include-ignored"]))
}

/// The firmware with the other step port, tested like the default one.
const TIMER_PORT_ELF: &str = "timer-port";
const TIMER_PORT: Variant = Variant {
    board: Board::Pico,
    port: Port::Timer,
    driver: Some(Driver::Drv8825),
    estop: Contact::No,
    axes: Axes::Three,
    prove: false,
};

/// The firmware whose emergency stop opens when it is pressed.
const ESTOP_NC_ELF: &str = "estop-nc";

/// The firmware for faster drivers.
const TMC2209_ELF: &str = "tmc2209";

/// The firmware that measures itself.
const PROVE_ELF: &str = "prove";

/// Images of which CI runs a dozen emulated tests. The stage of each has all of them.
const FOUR_AXES_ELF: &str = "four-axes";
const SKR_PICO_ELF: &str = "skr-pico";

const PICO_2_ELF: &str = "pico2";
const PICO_2_PROVE_ELF: &str = "pico2-prove";

/// The firmware for another chip.
const OF_PICO_2: Variant = Variant {
    board: Board::Pico2,
    port: Port::Pio,
    driver: Some(Driver::Drv8825),
    estop: Contact::No,
    axes: Axes::Three,
    prove: false,
};

fn firmware(amount: Amount) -> Result<()> {
    if amount != Amount::Few {
        other_images()?;
    }
    check_footprint(Variant::default())
}

/// The images but for the default one, for which a person need not wait.
fn other_images() -> Result<()> {
    check_footprint(Variant { axes: Axes::Four, ..Variant::default() })?;
    build::keep(&Variant::default().elf(), FOUR_AXES_ELF)?;
    check_footprint(Variant { board: Board::SkrPico, ..Variant::default() })?;
    build::keep(&Variant::default().elf(), SKR_PICO_ELF)?;
    check_footprint(Variant { axes: Axes::Four, board: Board::SkrPico, ..Variant::default() })?;
    check_footprint(Variant::proving(Board::Pico, Port::Pio))?;
    build::keep(&Variant::default().elf(), PROVE_ELF)?;
    check_footprint(Variant::proving(Board::Pico2, Port::Pio))?;
    build::keep(&OF_PICO_2.elf(), PICO_2_PROVE_ELF)?;
    check_footprint(OF_PICO_2)?;
    build::keep(&OF_PICO_2.elf(), PICO_2_ELF)?;
    build::kept_firmware(TIMER_PORT, TIMER_PORT_ELF)?;
    build::kept_firmware(Variant { estop: Contact::Nc, ..Variant::default() }, ESTOP_NC_ELF)?;
    build::kept_firmware(Variant { driver: Some(Driver::Tmc2209), ..Variant::default() }, TMC2209_ELF)?;
    Ok(())
}

/// Builds a variant, and compares what it takes with its budgets.
fn check_footprint(variant: Variant) -> Result<()> {
    let footprint = Footprint::new(&build::firmware(variant)?, variant);
    print!("{}", footprint.table());
    footprint.check()
}

fn emulated_board(amount: Amount) -> Result<()> {
    // Not by its package: with the features of all packages it is compiled already.
    if amount == Amount::Few {
        let mut tests = cargo_test(amount);
        tests.env("ISOSTEP_ELF", Variant::default().elf());
        return process::run(tests.args(["--test=emulated", "--", "--ignored"]).args(NOT_WITH_FEW));
    }
    let elves = [Variant::default().elf(), build::kept_elf(TIMER_PORT_ELF), build::kept_elf(ESTOP_NC_ELF)];
    let mut tests = on_board(amount, &elves);
    tests.env("ISOSTEP_PROVE_ELF", build::kept_elf(PROVE_ELF));
    tests.env("ISOSTEP_TMC2209_ELF", build::kept_elf(TMC2209_ELF));
    tests.env("ISOSTEP_FOUR_AXES_ELF", build::kept_elf(FOUR_AXES_ELF));
    tests.env("ISOSTEP_SKR_PICO_ELF", build::kept_elf(SKR_PICO_ELF));
    tests.env("ISOSTEP_PICO_2_ELF", build::kept_elf(PICO_2_ELF));
    process::run(tests.args(["--test=emulated", "--", "--ignored"]))
}

/// The tests of images but for the default one: a test of theirs that is not named so fails without its image. And those that
/// take longest: where in flash the code of a line stands, and presses in each phase of homing and dialogues with crossed belts, which
/// the simulator has too.
const NOT_WITH_FEW: [&str; 10] = [
    "--skip=cached::",
    "--skip=presses_while_homing",
    "--skip=dialogues::core_xy::",
    "--skip=timer_port",
    "--skip=four_axes",
    "--skip=skr_pico",
    "--skip=pico_2",
    "--skip=broken_wire",
    "--skip=board_words::",
    "--skip=prove::",
];

/// Tests on the emulated board with these images: the default one, that of the timer port, and that of the emergency stop
/// which opens. A plain `cargo test` ignores them, because it must work without Node and does not build firmware.
fn on_board(amount: Amount, elves: &[PathBuf; 3]) -> Command {
    let mut tests = cargo_test(amount);
    tests.envs(["ISOSTEP_ELF", "ISOSTEP_TIMER_PORT_ELF", "ISOSTEP_ESTOP_NC_ELF"].into_iter().zip(elves));
    tests
}

fn another_board(amount: Amount) -> Result<()> {
    let (target, package) = (workspace::FIRMWARE_TARGET, workspace::TEMPLATE_BOARD);
    toolchain::add_target(target)?;
    let mut tests = cargo_test(amount);
    if amount == Amount::Few {
        tests.args(["--test=it", "qemu::", "--", "--ignored", "--skip=two_axes"]);
    } else {
        process::run(&mut firmware_cargo("build", target, package, &["two-axes"]))?;
        let two_axes = build::keep(&workspace::elf(target, package), "qemu-two-axes")?;
        tests.env("ISOSTEP_QEMU_TWO_AXES_ELF", two_axes);
        tests.args(["--test=it", "qemu::", "--", "--ignored"]);
    }
    process::run(&mut firmware_cargo("build", target, package, &[]))?;
    // Not by their package: with the features of all packages they are compiled already.
    process::run(tests.env("ISOSTEP_QEMU_ELF", workspace::elf(target, package)))
}

fn another_chip(_: Amount) -> Result<()> {
    process::run(&mut other_chip::cargo("build"))
}

fn slow_clock(amount: Amount) -> Result<()> {
    process::run(cargo_test(amount).args(["--package=isostep-tests", "--features=tick-hz-32_768", "--test=tick_rate"]))
}

fn two_axes(amount: Amount) -> Result<()> {
    let args = ["--package=isostep-tests", "--package=isostep", "--features=two-axes", "--test=two_axes"];
    process::run(cargo_test(amount).args(args))
}

/// The random cases of CI are enough here: that they hold at random places is seen with three axes.
fn four_axes(_: Amount) -> Result<()> {
    let of_host = ["--package=isostep-console", "--package=isostep-tests", FEATURE, "--test=four_axes"];
    process::run(cargo_test(Amount::More).args(of_host))?;
    let variants = [Variant::default(), TIMER_PORT, Variant { estop: Contact::Nc, ..Variant::default() }];
    let names = ["four-axes", "four-axes-timer-port", "four-axes-estop-nc"];
    for (variant, name) in variants.into_iter().zip(names) {
        build::kept_firmware(Variant { axes: Axes::Four, ..variant }, name)?;
    }
    let elves = names.map(build::kept_elf);
    let of_board = ["--package=isostep-tests", FEATURE, "--test=emulated"];
    let choice =
        ["--", "--ignored", "--skip=boot::", "--skip=output_watchdog::", "--skip=squared::", "--skip=five_motors::"];
    process::run(on_board(Amount::More, &elves).args(of_board).args(choice).args(OF_OTHERS))
}

const FEATURE: &str = "--features=four-axes";
/// The runs that the emulated board has made already with the images that they are for.
const OF_OTHERS: [&str; 3] = ["--skip=board_words::an_image", "--skip=skr_pico", "--skip=pico_2"];

/// The proving image is for a Pico only.
fn skr_pico(_: Amount) -> Result<()> {
    let variant = Variant { board: Board::SkrPico, ..Variant::default() };
    let variants = [variant, Variant { port: Port::Timer, ..variant }, Variant { estop: Contact::Nc, ..variant }];
    let names = ["skr-pico", "skr-pico-timer-port", "skr-pico-estop-nc"];
    for (variant, name) in variants.into_iter().zip(names) {
        build::kept_firmware(variant, name)?;
    }
    let elves = names.map(build::kept_elf);
    let mut tests = on_board(Amount::More, &elves);
    tests.env("ISOSTEP_BOARD", variant.board.name());
    tests.args(["--test=emulated", "--", "--ignored", "--skip=prove::", "--skip=four_axes::", "--skip=drive_alarm"]);
    process::run(tests.args(OF_OTHERS))
}

/// What CI runs on the chip of a Pico 2: its edges, stops, faults and store, the dialogues that every board has, and one test of its proving
/// image.
const SOME_OF_PICO_2: [&str; 9] = [
    "parking_is",
    "every_stop",
    "flowing::flowing",
    "a_port_that_runs_out",
    "nothing_is_stored",
    "evenly::",
    "boot_names_the_drive",
    "dialogues::both::",
    "prove::an_edge_that_comes_three_cycles_late",
];

/// Random operands of each kind of each function on doubles.
const DOUBLES: &str = "1000000";

fn pico_2(amount: Amount) -> Result<()> {
    let on_pico_2 = |elves: &[PathBuf; 3]| {
        let mut tests = on_board(Amount::More, elves);
        tests.env("ISOSTEP_BOARD", OF_PICO_2.board.name()).env("ISOSTEP_PROVE_ELF", build::kept_elf(PICO_2_PROVE_ELF));
        tests.args(["--test=emulated", "--", "--ignored"]);
        tests
    };
    let kept = build::kept_elf(PICO_2_ELF);
    match amount {
        Amount::Few => announce("nothing: the firmware of a Pico 2 is not linked without ISOSTEP_CASES=more"),
        Amount::More => {
            let mut tests = on_pico_2(&[kept.clone(), kept.clone(), kept]);
            process::run(tests.args(SOME_OF_PICO_2).args(["--skip=timer_port", "--skip=broken_wire"]))?;
        }
        Amount::All => {
            let timer_port = build::kept_firmware(Variant { port: Port::Timer, ..OF_PICO_2 }, "pico2-timer-port")?;
            let estop_nc = build::kept_firmware(Variant { estop: Contact::Nc, ..OF_PICO_2 }, "pico2-estop-nc")?;
            five_motors()?;
            let tests = &mut on_pico_2(&[kept.clone(), timer_port, estop_nc]);
            tests.args(["--skip=four_axes", "--skip=linked::"]);
            process::run(tests.args(OF_OTHERS))?;
            oracle::check(&kept)?;
            process::run(node::of_emulator("test/dcp.test.mjs").env("DCP_RANDOM", DOUBLES))?;
        }
    }
    Ok(())
}

/// A Pico 2 of four axes has the second motor of one, too: what is about either.
fn five_motors() -> Result<()> {
    let variant = Variant { axes: Axes::Four, ..OF_PICO_2 };
    check_footprint(variant)?;
    let five = build::keep(&variant.elf(), "pico2-four-axes")?;
    let timer_port = build::kept_firmware(Variant { port: Port::Timer, ..variant }, "pico2-four-axes-timer-port")?;
    let estop_nc = build::kept_firmware(Variant { estop: Contact::Nc, ..variant }, "pico2-four-axes-estop-nc")?;
    let tmc2209 =
        build::kept_firmware(Variant { driver: Some(Driver::Tmc2209), ..variant }, "pico2-four-axes-tmc2209")?;
    let mut tests = on_board(Amount::More, &[five, timer_port, estop_nc]);
    tests.env("ISOSTEP_TMC2209_ELF", tmc2209);
    tests.env("ISOSTEP_BOARD", variant.board.name()).args([
        "--package=isostep-tests",
        FEATURE,
        "--test=emulated",
        "--",
        "--ignored",
    ]);
    process::run(tests.args([
        "four_axes",
        "five_motors::",
        "squared::",
        "contract",
        "--skip=a_second_motor_is_refused",
        // One of them prints a figure of docs/figures.md.
        "--show-output",
    ]))
}

fn worlds() -> Result<()> {
    let seeds = isostep_trials::window(1_000_u32);
    process::run(cargo_xtask().args(["swarm", "--seeds=1000", &format!("--first={}", seeds.start)]))
}

fn page(amount: Amount) -> Result<()> {
    match amount {
        Amount::Few => web::test_values(),
        Amount::More => web::test_pictures(),
        Amount::All => web::test(),
    }
}

fn senders(_: Amount) -> Result<()> {
    grbl_streamer()
}

/// Does nothing: real senders and a real slave need a pseudo-terminal.
#[cfg(not(unix))]
fn grbl_streamer() -> Result<()> {
    announce("none: Windows has no pseudo-terminals");
    Ok(())
}

#[cfg(not(unix))]
fn missing() -> Option<&'static str> {
    None
}

#[cfg(not(unix))]
use grbl_streamer as cncjs;
#[cfg(not(unix))]
use grbl_streamer as pymodbus;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_chosen_by_name_in_their_own_order() {
        let names = |only: &[&str]| {
            let only: Vec<_> = only.iter().map(|&name| name.to_owned()).collect();
            let chosen = chosen(STAGES.iter().collect(), &only).map_err(|error| error.to_string());
            chosen.map(|stages| stages.iter().map(|(name, _)| *name).collect::<Vec<_>>())
        };
        assert_eq!(names(&["Pico 2", "firmware"]), Ok(vec!["firmware", "Pico 2"]));
        assert_eq!(names(&[]).map(|all| all.len()), Ok(STAGES.len()));
        let refused = names(&["bench"]).unwrap_err();
        assert!(refused.starts_with("--only bench: there is no such stage here, but host tests, "), "{refused}");
    }
}
