//! The drive that an RP2040 in its boot loader is: whoever copies a UF2 file onto it gives the chip a new image.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// The drive, if one is mounted in a usual place.
pub fn mounted() -> Option<PathBuf> {
    places().into_iter().find(|place| is_one(place))
}

/// Whether this folder is such a drive. Every RP2040 in BOOTSEL mode describes itself in a file.
pub fn is_one(place: &Path) -> bool {
    fs::read_to_string(place.join("INFO_UF2.TXT")).is_ok_and(|info| info.contains("RPI-RP2"))
}

/// The folders in which Linux, macOS and Windows mount a drive of this name.
fn places() -> Vec<PathBuf> {
    let user = env::var("USER").unwrap_or_default();
    let linux = ["/media", "/run/media"].map(|dir| Path::new(dir).join(&user).join("RPI-RP2"));
    let others = ["/media/RPI-RP2", "/mnt/RPI-RP2", "/Volumes/RPI-RP2"].map(PathBuf::from);
    let windows = ('D'..='Z').map(|letter| PathBuf::from(format!("{letter}:\\")));
    linux.into_iter().chain(others).chain(windows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_boot_drive_is_told_by_its_description() {
        let dir = env::temp_dir().join(format!("isostep-drive-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        assert!(!is_one(&dir));
        fs::write(dir.join("INFO_UF2.TXT"), "UF2 Bootloader v2.0\nModel: Raspberry Pi RP2\nBoard-ID: RPI-RP2\n")
            .unwrap();
        assert!(is_one(&dir));
        fs::remove_dir_all(dir).unwrap();
    }
}
