//! `cargo xtask lint`: checks formatting, clippy and the documentation. Warnings are errors.

use std::process::Command;

use anyhow::Result;

use crate::other_chip;
use crate::process::{announce, run as run_command};
use crate::toolchain::{self, cargo, firmware_cargo};
use crate::variant::{Axes, Board, Contact, Driver, Port, Variant};
use crate::{web, workspace};

/// Check formatting, clippy and the documentation; warnings are errors
#[derive(clap::Args)]
#[command(after_help = "\
The same checks run over the host's packages, over the page and over four images of the firmware, which differ in all that
can differ. The targets of the page and of boards/stm32g474 are left out in words where rustup cannot add them.")]
pub struct Args {
    /// The crates with other features too, every image of the firmware, and the other boards
    #[arg(long)]
    all: bool,
}

const DENY_WARNINGS: [&str; 3] = ["--", "-D", "warnings"];

pub fn run(Args { all }: Args) -> Result<()> {
    announce("cargo fmt --check");
    run_command(Command::new("cargo").current_dir(workspace::root()).args(["fmt", "--all", "--check"]))?;
    announce("clippy, host packages");
    run_command(cargo("clippy").arg("--all-targets").args(DENY_WARNINGS))?;
    announce("rustdoc, host packages");
    run_command(cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))?;
    for_browsers(&[])?;
    firmware()?;
    if all { what_tests_compile_too() } else { Ok(()) }
}

/// Variants left out otherwise, because a stage of the tests compiles them or something that differs from them in a few lines.
fn what_tests_compile_too() -> Result<()> {
    with_axes("four-axes", &["--test=four_axes", "--test=emulated"])?;
    with_axes("two-axes", &["--test=two_axes"])?;
    for_browsers(&web::FOUR_AXES)?;
    let [proving, proving_timer] = [Port::Pio, Port::Timer].map(|port| Variant::proving(Board::Pico, port));
    let five_motors = Variant { axes: Axes::Four, ..Variant::default() };
    for variant in [proving, proving_timer, on_pico_2(other()), on_pico_2(five_motors), on_pico_2(proving)] {
        Image::of(variant).clippy()?;
    }
    for variant in [other(), skr_pico(), proving, proving_timer, on_pico_2(Variant::default())] {
        Image::of(variant).rustdoc()?;
    }
    let others = [(workspace::BENCH_FIRMWARE, None), (workspace::TEMPLATE_BOARD, None)];
    let template = ["two-axes", "four-axes"].map(|feature| (workspace::TEMPLATE_BOARD, Some(feature)));
    for (package, feature) in others.into_iter().chain(template) {
        let image = Image { target: workspace::FIRMWARE_TARGET, package, features: feature.into_iter().collect() };
        image.clippy()?;
        image.rustdoc()?;
    }
    another_chip()
}

/// The crates and these tests with another number of axes.
fn with_axes(feature: &str, tests: &[&str]) -> Result<()> {
    announce(&format!("clippy, crates with {feature}"));
    let crates = ["console", "motion", "controller", "sim", "report"].map(|name| format!("--package=isostep-{name}"));
    let mut clippy = cargo("clippy");
    clippy.args(crates).args(["--package=isostep", "--package=isostep-tests", "--lib", "--bins"]).args(tests);
    run_command(clippy.arg(format!("--features={feature}")).args(DENY_WARNINGS))
}

fn another_chip() -> Result<()> {
    if let Some(why) = other_chip::missing() {
        announce(&format!("boards/stm32g474: left out, because {why}"));
        return Ok(());
    }
    announce("clippy, boards/stm32g474");
    run_command(other_chip::cargo("clippy").args(DENY_WARNINGS))?;
    announce("rustdoc, boards/stm32g474");
    run_command(other_chip::cargo("doc").arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
}

/// The machine on the page, with these arguments more.
fn for_browsers(more: &[&str]) -> Result<()> {
    match web::clippy() {
        Ok(mut clippy) => {
            announce("clippy, isostep-web for browsers");
            run_command(clippy.args(more).args(DENY_WARNINGS))
        }
        Err(why) => {
            announce(&format!("isostep-web for browsers: left out, because {why:#}"));
            Ok(())
        }
    }
}

/// The image of a release, and three that differ from it in all that can differ.
fn firmware() -> Result<()> {
    for variant in [Variant::default(), other(), skr_pico(), on_pico_2(Variant::default())] {
        toolchain::add_target(workspace::target(variant.chip()))?;
        Image::of(variant).clippy()?;
    }
    Image::of(Variant::default()).rustdoc()
}

fn other() -> Variant {
    Variant {
        board: Board::Pico,
        port: Port::Timer,
        driver: Some(Driver::Tmc2209),
        estop: Contact::Nc,
        axes: Axes::Four,
        prove: false,
    }
}

fn skr_pico() -> Variant {
    Variant { board: Board::SkrPico, ..Variant::default() }
}

fn on_pico_2(variant: Variant) -> Variant {
    Variant { board: Board::Pico2, ..variant }
}

/// An image of a board.
struct Image {
    target: &'static str,
    package: &'static str,
    features: Vec<&'static str>,
}

impl Image {
    /// A variant of the gantry's.
    fn of(variant: Variant) -> Self {
        Self { target: workspace::target(variant.chip()), package: workspace::FIRMWARE, features: variant.features() }
    }

    fn clippy(&self) -> Result<()> {
        run_command(self.cargo("clippy").args(DENY_WARNINGS))
    }

    fn rustdoc(&self) -> Result<()> {
        let mut doc = self.cargo("doc");
        run_command(doc.args(["--no-deps", "--document-private-items"]).env("RUSTDOCFLAGS", "-D warnings"))
    }

    /// `cargo VERB` for it, which is announced.
    fn cargo(&self, verb: &str) -> Command {
        let Self { target, package, features } = self;
        let with = features.iter().map(|feature| format!(" +{feature}")).collect::<String>();
        announce(&format!("{verb}, {package}{with} for {target}"));
        firmware_cargo(verb, target, package, features)
    }
}
