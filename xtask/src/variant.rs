//! The variants in which the gantry's firmware is built.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::ValueEnum;
use isostep::chip::Chip;
pub use isostep_bench::{Model as Board, Port};

use crate::board_words::BoardWords;
use crate::workspace;

/// The feature of every package that has axes.
pub const FOUR_AXES: &str = "four-axes";

/// A build of the firmware.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Variant {
    /// The board
    #[arg(long, value_enum, default_value_t)]
    pub board: Board,
    /// Step port
    #[arg(long, value_enum, default_value_t)]
    pub port: Port,
    /// The stepper drivers whose timing is kept [default: drv8825; those of an SKR Pico are tmc2209]
    #[arg(long, value_enum)]
    pub driver: Option<Driver>,
    /// Wiring of the emergency stop to ground
    #[arg(long, value_enum, default_value_t)]
    pub estop: Contact,
    /// Number of axes: with 4, A has the pins of the second motor, but for a Pico 2, which has both
    #[arg(long, value_enum, default_value_t)]
    pub axes: Axes,
    /// The image that measures itself, for `isostep prove`; it never energises a motor
    #[arg(long)]
    pub prove: bool,
}

/// The stepper driver. Its number is that of the firmware's word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Driver {
    /// STEP high and low 1.9 us each, 250,000 steps/s at most
    #[default]
    Drv8825,
    /// STEP high and low 104 ns each
    Tmc2209,
}

/// The number of axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Axes {
    /// X, Y and Z, one of which may have a second motor
    #[default]
    #[value(name = "3")]
    Three,
    /// X, Y, Z and A, which may be rotary
    #[value(name = "4")]
    Four,
}

/// The contact of the emergency stop. Its number is that of the firmware's word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Contact {
    /// normally open: closed while it is pressed
    #[default]
    No,
    /// normally closed: open while it is pressed, so that a broken wire is a press
    Nc,
}

impl Variant {
    /// The image that measures this board. Its pulses are as short as they may be, for the highest rates: no motor is driven.
    pub fn proving(board: Board, port: Port) -> Self {
        Self { board, port, driver: Some(Driver::Tmc2209), prove: true, ..Self::default() }
    }

    /// # Errors
    /// Parts that the board does not have.
    pub fn check(self) -> Result<()> {
        let is_skr_pico = self.board == Board::SkrPico;
        ensure!(
            !is_skr_pico || self.driver() == Driver::Tmc2209,
            "--driver drv8825: the drivers of an SKR Pico are TMC2209, and cannot be changed: leave --driver out"
        );
        ensure!(!is_skr_pico || !self.prove, "--prove: the image that measures itself is for --board pico or pico2");
        Ok(())
    }

    /// The chip of the board.
    pub fn chip(self) -> Chip {
        self.board.chip()
    }

    /// The firmware with its symbols. Each build for a chip overwrites the previous one.
    pub fn elf(self) -> PathBuf {
        workspace::elf(workspace::target(self.chip()), workspace::FIRMWARE)
    }

    /// The firmware in the format of the board's boot drive.
    pub fn uf2(self) -> PathBuf {
        self.elf().with_extension("uf2")
    }

    pub fn driver(self) -> Driver {
        self.driver.unwrap_or(if self.board == Board::SkrPico { Driver::Tmc2209 } else { Driver::Drv8825 })
    }

    /// The board's cargo features. These and no others are to be built, its default ones neither.
    pub fn features(self) -> Vec<&'static str> {
        let board = (self.board == Board::SkrPico).then_some("skr-pico");
        let port = (self.port == Port::Timer).then_some("timer-port");
        let axes = (self.axes == Axes::Four).then_some(FOUR_AXES);
        let prove = self.prove.then_some("prove");
        board.into_iter().chain(port).chain(prove).chain(axes).collect()
    }

    /// The words that are written into the image after it is linked.
    pub fn words(self) -> BoardWords {
        BoardWords { contact: self.estop, driver: self.driver() }
    }

    /// The name of the emergency stop's contact for the emulated board's options.
    pub fn contact_name(self) -> &'static str {
        match self.estop {
            Contact::No => "no",
            Contact::Nc => "nc",
        }
    }

    /// The driver's name for the emulated board's options.
    pub fn driver_name(self) -> &'static str {
        match self.driver() {
            Driver::Drv8825 => "drv8825",
            Driver::Tmc2209 => "tmc2209",
        }
    }
}
