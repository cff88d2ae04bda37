//! `flash` and `dist` with stand-ins for the programs that they call, which note how they were called. The one for cargo
//! makes an image of a page of flash: for which features it was built, then the words of the board.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use isostep::chip::Chip;

include!("../src/stand_in_elf.rs");

/// The features in an image.
const TEXT_BYTES: usize = 256 - WORDS.len();
/// The offset of a UF2 block's page of flash.
const PAGE: std::ops::Range<usize> = 32..32 + 256;

/// A folder with the programs, and what they have noted.
struct StandIns(PathBuf);

impl StandIns {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("isostep-stand-ins-{test}-{}", std::process::id()));
        fs::create_dir_all(folder.join("bin")).unwrap();
        let elf = elf(&[b' '; TEXT_BYTES], WORDS);
        let text = elf.windows(TEXT_BYTES).position(|bytes| bytes == [b' '; TEXT_BYTES]).unwrap();
        fs::write(folder.join("head"), &elf[..text]).unwrap();
        fs::write(folder.join("tail"), &elf[text + TEXT_BYTES..]).unwrap();
        let stand_ins = Self(folder);
        // The features are the last of cargo's words.
        let image = format!(
            "while [ \"$1\" != --target ]; do shift; done\nto=\"$folder/target/$2/release\"\n\
             for features; do :; done\nmkdir -p \"$to\"\n\
             {{ cat \"$folder/head\"; printf '%-{TEXT_BYTES}s' \"${{features#--features=}}\"; cat \"$folder/tail\"; }} \
             > \"$to/pico-gantry\""
        );
        stand_ins.add("stand-in-cargo", &image);
        stand_ins
    }

    /// A program that notes its name and its words, then does this. Without `probe-rs` and `picotool` nobody has them here.
    fn add(&self, name: &str, does: &str) {
        let path = self.0.join("bin").join(name);
        let folder = self.0.display();
        let script = format!(
            "#!/bin/sh\nfolder='{folder}'\n\
             echo \"{name} $*\" >> \"$folder/calls\"\n{does}\n"
        );
        fs::write(&path, script).unwrap();
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }

    /// Carries out a verb. What the desktop would mount for this user is in the folder.
    fn run(&self, verb: &str) -> Output {
        let path = std::env::var("PATH").unwrap();
        let mut xtask = Command::new(env!("CARGO_BIN_EXE_xtask"));
        xtask.args(verb.split(' ')).stdin(Stdio::null());
        xtask.env("PATH", format!("{}:{path}", self.0.join("bin").display())).env("USER", &self.0);
        xtask.env("CARGO", self.0.join("bin/stand-in-cargo")).env("CARGO_TARGET_DIR", self.0.join("target"));
        xtask.output().unwrap()
    }

    #[track_caller]
    fn succeeds(&self, verb: &str) -> String {
        let output = self.run(verb);
        assert!(output.status.success(), "{verb}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The calls since the last time, without the folder's name; of cargo only that it has built.
    fn calls(&self) -> Vec<String> {
        let calls = fs::read_to_string(self.0.join("calls")).unwrap();
        fs::remove_file(self.0.join("calls")).unwrap();
        let folders = ["thumbv6m-none-eabi", "thumbv8m.main-none-eabi"]
            .map(|target| format!("{}/target/{target}/release/", self.0.display()));
        let short = |call: &str| {
            let is_build = call.starts_with("stand-in-cargo build ");
            let without = || folders.iter().fold(call.to_owned(), |call, folder| call.replace(folder, ""));
            if is_build { "build".to_owned() } else { without() }
        };
        calls.lines().map(short).collect()
    }

    /// A Pico's boot drive that the desktop has mounted, or that somebody mounts elsewhere.
    fn drive(&self, name: &str) -> PathBuf {
        self.drive_that_says(name, "UF2 Bootloader v3.0\nModel: Raspberry Pi RP2\nBoard-ID: RPI-RP2\n")
    }

    fn drive_that_says(&self, name: &str, text: &str) -> PathBuf {
        let drive = self.0.join(name);
        fs::create_dir_all(&drive).unwrap();
        fs::write(drive.join("INFO_UF2.TXT"), text).unwrap();
        drive
    }
}

impl Drop for StandIns {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The features for which the image in a UF2 file was built, and what the words of the board say.
fn image(uf2: &Path) -> (BTreeSet<String>, BTreeSet<&'static str>) {
    let blocks = fs::read(uf2).unwrap();
    assert_eq!(blocks.len(), 512, "{}", uf2.display());
    let (text, words) = blocks[PAGE].split_at(TEXT_BYTES);
    let text = std::str::from_utf8(text).unwrap().trim_end();
    let features = text.split(',').filter(|feature| !feature.is_empty()).map(str::to_owned).collect();
    let (layout, values) = words.split_at(12);
    assert_eq!(layout, &WORDS[..12]);
    let says = values.chunks(4).zip(["nc", "tmc2209"]).filter_map(|(value, name)| match value {
        [0, 0, 0, 0] => None,
        [1, 0, 0, 0] => Some(name),
        other => panic!("{name}: {other:?}"),
    });
    (features, says.collect())
}

fn expected(features: &[&str], words: &[&'static str]) -> (BTreeSet<String>, BTreeSet<&'static str>) {
    (features.iter().map(|&feature| feature.to_owned()).collect(), words.iter().copied().collect())
}

const ONE_PROBE: &str = "[ \"$1\" = list ] && echo '[0]: Debug Probe (CMSIS-DAP) -- 2e8a:000c'";
const NO_PROBE: &str = "echo 'No debug probes were found.'";

#[test]
fn a_probe_writes_what_was_just_built_and_restarts_the_chip_last() {
    let stand_ins = StandIns::new("probe");
    stand_ins.add("probe-rs", &format!("{ONE_PROBE}\ntrue"));
    // A drive that is mounted is another board's.
    let drive = stand_ins.drive("RPI-RP2");
    stand_ins.succeeds("flash");
    let download = "probe-rs download --chip RP2040 pico-gantry";
    assert_eq!(stand_ins.calls(), ["build", "probe-rs list", download, "probe-rs reset --chip RP2040"]);
    stand_ins.succeeds("flash --logs");
    assert_eq!(stand_ins.calls(), ["build", "probe-rs list", "probe-rs run --chip RP2040 pico-gantry"]);
    stand_ins.succeeds("flash --logs --board pico2");
    assert_eq!(stand_ins.calls(), ["build", "probe-rs list", "probe-rs run --chip RP235x pico-gantry"]);
    assert!(!drive.join("firmware.uf2").exists());
}

#[test]
fn a_chip_that_was_not_written_is_not_restarted() {
    let stand_ins = StandIns::new("not-written");
    stand_ins.add("probe-rs", &format!("{ONE_PROBE}\n[ \"$1\" != download ]"));
    let output = stand_ins.run("flash");
    let reported = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && reported.contains("`probe-rs download --chip RP2040 "), "{reported}");
    assert_eq!(stand_ins.calls().len(), 3, "no reset");
    // Nor is anything done without a build.
    stand_ins.add("stand-in-cargo", "exit 101");
    assert!(!stand_ins.run("flash").status.success());
    assert_eq!(stand_ins.calls(), ["build"]);
}

#[test]
fn a_drive_gets_the_image_that_was_asked_for() {
    let stand_ins = StandIns::new("drive");
    stand_ins.add("probe-rs", NO_PROBE);
    stand_ins.add("picotool", "");
    let mounted = stand_ins.drive("RPI-RP2").join("firmware.uf2");
    stand_ins.succeeds("flash --driver tmc2209 --estop nc");
    assert_eq!(image(&mounted), expected(&[], &["tmc2209", "nc"]));
    assert_eq!(stand_ins.calls(), ["build", "probe-rs list"], "the drive comes before picotool");
    // One that is named comes before all others.
    let named = stand_ins.drive("elsewhere").join("firmware.uf2");
    stand_ins.succeeds(&format!("flash --axes 4 --drive {}", named.parent().unwrap().display()));
    assert_eq!(image(&named), expected(&["four-axes"], &[]));
    assert_eq!(stand_ins.calls(), ["build"]);
    // A Pico's is none for a Pico 2.
    fs::remove_file(&mounted).unwrap();
    let of_pico_2 =
        stand_ins.drive_that_says("RP2350", "UF2 Bootloader v1.0\nModel: Raspberry Pi RP2350\nBoard-ID: RP2350\n");
    stand_ins.succeeds("flash --board pico2");
    assert!(of_pico_2.join("firmware.uf2").exists() && !mounted.exists());
    let refused = stand_ins.run(&format!("flash --board pico2 --drive {}", named.parent().unwrap().display()));
    let reported = String::from_utf8(refused.stderr).unwrap();
    assert!(reported.contains("is not the boot drive of an RP2350 (no INFO_UF2.TXT that says RP2350)"), "{reported}");
    let refused = stand_ins.run(&format!("flash --drive {}", stand_ins.0.join("bin").display()));
    assert!(!refused.status.success() && !stand_ins.0.join("bin/firmware.uf2").exists());
}

#[test]
fn picotool_writes_compares_and_starts() {
    // It must not write to a drive that really is there.
    if isostep::boot_loader::mounted(Chip::Rp2040).is_some() {
        return;
    }
    let stand_ins = StandIns::new("picotool");
    stand_ins.add("probe-rs", NO_PROBE);
    stand_ins.add("picotool", "");
    stand_ins.succeeds("flash");
    let calls = ["build", "probe-rs list", "picotool info", "picotool load -u -v -x pico-gantry.uf2"];
    assert_eq!(stand_ins.calls(), calls);
    let refused = stand_ins.run("flash --logs");
    let reported = String::from_utf8(refused.stderr).unwrap();
    assert!(
        !refused.status.success() && reported.contains("--logs needs a debug probe: probe-rs sees none"),
        "{reported}"
    );
}

/// The image that a file should have by its name.
fn named_image(name: &str) -> (BTreeSet<String>, BTreeSet<&'static str>) {
    let parts: [(_, &[&str], &[&str]); 6] = [
        ("-timer", &["timer-port"], &[]),
        ("-prove-", &["prove"], &["tmc2209"]),
        ("-tmc2209", &[], &["tmc2209"]),
        ("-skr-pico", &["skr-pico"], &["tmc2209"]),
        ("-estop-nc", &[], &["nc"]),
        ("-4-axes", &["four-axes"], &[]),
    ];
    let parts = parts.into_iter().filter(|(part, ..)| name.contains(part));
    let (features, words): (Vec<_>, Vec<_>) = parts.map(|(_, features, words)| (features, words)).unzip();
    expected(&features.concat(), &words.concat())
}

#[test]
fn every_file_of_a_release_holds_what_its_name_says_and_has_its_sum_and_its_row() {
    let stand_ins = StandIns::new("dist");
    // What an earlier release has left is not a file of this one.
    let folder = stand_ins.0.join("target/dist");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("isostep-0.0.1-pio-drv8825.uf2"), "old").unwrap();
    let printed = stand_ins.succeeds("dist --only firmware");
    let files: BTreeSet<_> =
        fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    let images: BTreeSet<_> = files.iter().filter(|name| name.ends_with(".uf2")).cloned().collect();
    let others: Vec<_> = files.difference(&images).map(String::as_str).collect();
    assert_eq!(others, ["LICENCES.txt", "SHA256SUMS", "WHICH.md"]);
    assert_eq!(images.len(), 44);
    for name in &images {
        assert_eq!(image(&folder.join(name)), named_image(name), "{name}");
        let chip = if name.contains("-pico2") { Chip::Rp2350 } else { Chip::Rp2040 };
        assert_eq!(Chip::of_image(&folder.join(name)).unwrap(), chip, "{name}");
    }
    // What differs in the words of the board alone is linked once.
    assert_eq!(stand_ins.calls(), vec!["build"; 16]);

    let which = fs::read_to_string(folder.join("WHICH.md")).unwrap();
    let row = |line: &str| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned());
    assert_eq!(which.lines().filter_map(row).collect::<BTreeSet<_>>(), images);
    assert!(printed.ends_with(&which), "{printed}");

    let check =
        Command::new("sha256sum").args(["--check", "--strict", "SHA256SUMS"]).current_dir(&folder).output().unwrap();
    let checked = String::from_utf8(check.stdout).unwrap();
    assert!(check.status.success(), "{checked}{}", String::from_utf8_lossy(&check.stderr));
    let summed: BTreeSet<_> = checked.lines().map(|line| line.strip_suffix(": OK").unwrap().to_owned()).collect();
    let expected = files.into_iter().filter(|name| name != "SHA256SUMS").collect();
    assert_eq!(summed, expected);
    // And it is the bytes that are summed.
    let one = folder.join(images.first().unwrap());
    fs::write(&one, "other bytes").unwrap();
    let check =
        Command::new("sha256sum").args(["--check", "--status", "SHA256SUMS"]).current_dir(&folder).status().unwrap();
    assert!(!check.success());
}
