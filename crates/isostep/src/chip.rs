//! The chips that boards with Isostep have, and what a computer has to know of each to find it and to give it an image.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use anyhow::{Context, Result};

use crate::project;

/// A chip, which decides which images a board takes. An option calls it by the board from Raspberry Pi that has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Chip {
    /// Of a Pico and an SKR Pico.
    #[default]
    #[value(name = "pico", help = "A Raspberry Pi Pico, with an RP2040")]
    Rp2040,
    /// Of a Pico 2.
    #[value(name = "pico2", help = "A Raspberry Pi Pico 2, with an RP2350")]
    Rp2350,
}

/// The maker and the part in the register CHIP_ID of SYSINFO. Above them is the chip's revision.
const ID_WITHOUT_REVISION: u32 = 0x0FFF_FFFF;

impl Chip {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Rp2040, Self::Rp2350];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rp2040 => "RP2040",
            Self::Rp2350 => "RP2350",
        }
    }

    /// The clock of its core and of what makes the steps, as the firmware sets it.
    #[must_use]
    pub const fn clock_hz(self) -> u32 {
        match self {
            Self::Rp2040 => 125_000_000,
            Self::Rp2350 => 150_000_000,
        }
    }

    /// The duration of a cycle of this clock, ns.
    #[must_use]
    pub const fn cycle_ns(self) -> f64 {
        1e9 / self.clock_hz() as f64
    }

    /// The name of the drive that its boot loader is, which stands in a file on the drive, too.
    #[must_use]
    pub const fn drive(self) -> &'static str {
        match self {
            Self::Rp2040 => "RPI-RP2",
            Self::Rp2350 => "RP2350",
        }
    }

    /// The content of the register CHIP_ID of SYSINFO, without the chip's revision.
    const fn id(self) -> u32 {
        match self {
            Self::Rp2040 => 0x0000_2927,
            Self::Rp2350 => 0x0000_4927,
        }
    }

    /// The chip in whose register CHIP_ID of SYSINFO this stands, in any revision.
    #[must_use]
    pub fn of_id(id: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|chip| chip.id() == id & ID_WITHOUT_REVISION)
    }

    /// The vendor and the product by which USB knows the firmware: Raspberry Pi's for a serial port on this chip, as in
    /// boards/pico-gantry/src/chip.
    #[must_use]
    pub const fn usb_ids(self) -> (u16, u16) {
        match self {
            Self::Rp2040 => (0x2E8A, 0x000A),
            Self::Rp2350 => (0x2E8A, 0x0009),
        }
    }

    /// The family of UF2 files that its boot loader takes. It ignores others without a word. Of an RP2350 it is that of images for
    /// the Arm cores in secure state.
    #[must_use]
    pub const fn uf2_family(self) -> u32 {
        match self {
            Self::Rp2040 => 0xE48B_FF56,
            Self::Rp2350 => 0xE48B_FF59,
        }
    }

    /// The chip that a UF2 file is for, by its first block.
    ///
    /// # Errors
    /// When it cannot be read, or is for none of them.
    pub fn of_image(image: &Path) -> Result<Self> {
        const FAMILY_AT: u64 = 28;

        let mut family = [0; 4];
        File::open(image)
            .and_then(|mut file| file.seek(SeekFrom::Start(FAMILY_AT)).and_then(|_| file.read_exact(&mut family)))
            .with_context(|| format!("{} cannot be read: name a UF2 file", project::shown(image)))?;
        let family = u32::from_le_bytes(family);
        let chip = Self::ALL.into_iter().find(|chip| chip.uf2_family() == family);
        chip.with_context(|| format!("{} is no UF2 file for an RP2040 or an RP2350", project::shown(image)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chip_is_known_by_its_identity_in_any_revision() {
        let of = [0x1000_2927, 0x2000_2927, 0x2000_4927, 0x3000_4927].map(|id| Chip::of_id(id).unwrap());
        assert_eq!(of, [Chip::Rp2040, Chip::Rp2040, Chip::Rp2350, Chip::Rp2350]);
        assert_eq!(Chip::of_id(0x2000_5927), None);
    }

    #[test]
    fn an_image_says_for_which_chip_it_is() {
        let image = std::env::temp_dir().join(format!("isostep-image-{}.uf2", std::process::id()));
        let block = |family: u32| [&[0; 28][..], &family.to_le_bytes(), &[0; 480]].concat();
        let of = |bytes: &[u8]| {
            std::fs::write(&image, bytes).unwrap();
            Chip::of_image(&image).map_err(|error| error.to_string())
        };
        assert_eq!(Chip::ALL.map(|chip| of(&block(chip.uf2_family())).unwrap()), Chip::ALL);
        let refused = of(&block(0)).unwrap_err();
        assert!(refused.ends_with("is no UF2 file for an RP2040 or an RP2350"), "{refused}");
        let short = of(b"UF2").unwrap_err();
        std::fs::remove_file(&image).unwrap();
        assert!(short.ends_with("cannot be read: name a UF2 file"), "{short}");
    }
}
