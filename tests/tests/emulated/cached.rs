//! Checks that what every line of a program passes through in flash stands together in `memory.x`, in less than the cache holds.
//!
//! Anything else of flash that a line needs would drive some of it out, or not, by where the linker has put it: a third fewer moves
//! a second in one image than in the next.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::{env, fs};

use isostep_sim::Port;
use isostep_tests::emulated::Board;
use object::{Object, ObjectSymbol};

const FLASH: std::ops::Range<u64> = 0x1000_0000..0x1100_0000;
/// The lines of each kind.
const LINES: usize = 400;
const SETTINGS: &str = "$11=1\n$100=80\n$101=80\n$102=80\n$110=60000\n$111=60000\n$112=60000\n$120=10000\n$121=10000\n$122=10000\n\
    $32=1\n$30=1000\nG92 X500 Y500 Z500\nG21 G91 G94 G1 F60000 G64 P0.05\n";

/// Moves of 0.2 mm of three axes with a blend at every corner, too many for the chip, so that each is also planned alone.
fn blends() -> String {
    (0..LINES).fold(SETTINGS.to_owned(), |mut lines, line| {
        let [x, z] = [[0.1, 0.08], [0.08, -0.08]][line % 2];
        writeln!(lines, "X{x} Y{:.2} Z{z}", 0.18 - x).unwrap();
        lines
    })
}

/// Pixels of a laser.
fn raster(mode: &str) -> String {
    (0..LINES).fold(format!("{SETTINGS}{mode} S0\nG1 X5\n"), |mut lines, line| {
        writeln!(lines, "X0.1 S{}", 100 + line % 9 * 100).unwrap();
        lines
    })
}

/// The functions of flash through which the lines of this program pass, and which do not stand together.
fn strays(board: Board, variable: &str, name: &str, program: &str) -> Vec<String> {
    let file = |name: &str| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let (job, profile) = (file(&format!("{name}.nc")), file(&format!("{name}.csv")));
    fs::write(&job, program).unwrap();
    let run =
        board.with(&["--stream=counting", "--poll-hz=0", &format!("--profile={}", profile.display())]).program(&job);
    assert!(run.ok, "{name}: {}", run.printed);
    let elf = fs::read(env::var_os(variable).unwrap()).unwrap();
    let elf = object::File::parse(&*elf).unwrap();
    let place = |name: &str| elf.symbol_by_name(name).unwrap_or_else(|| panic!("memory.x: no {name}")).address();
    let together = place("__line_start")..place("__line_end");
    let rows = fs::read_to_string(profile).unwrap();
    let seen: Vec<(u64, usize)> = rows
        .lines()
        .skip(1)
        .map(|row| row.split(',').collect::<Vec<_>>())
        .map(|fields| (fields[0].parse().unwrap(), fields[2].parse().unwrap()))
        .filter(|&(address, times)| FLASH.contains(&address) && times >= LINES * 3 / 4)
        .collect();
    assert!(seen.iter().filter(|(address, _)| together.contains(address)).count() > 1_000, "{name}: no line is seen");
    let outside = seen.iter().filter(|(address, _)| !together.contains(address));
    let mut strays: Vec<_> = outside
        .map(|&(address, _)| {
            let of = |symbol: &object::Symbol<'_, '_>| {
                let begin = symbol.address() & !1;
                (begin..begin + symbol.size()).contains(&address)
            };
            elf.symbols().find(of).map_or_else(|| format!("{address:#x}"), |symbol| symbol.name().unwrap().to_owned())
        })
        .collect();
    strays.dedup();
    // Drivers reply as often as lines come, whatever these are. A long jump stands beside what takes it.
    strays.retain(|name| !["7drivers", "driver_wire", "tmc2209", "LongThunk"].iter().any(|part| name.contains(part)));
    strays
}

fn stand_together(variable: &str, board: fn(&str) -> Board) {
    for (name, program) in [("blends", blends()), ("constant", raster("M3")), ("by-speed", raster("M4"))] {
        let name = format!("cached-{name}-{variable}");
        let strays = strays(board(&name), variable, &name, &program);
        assert!(strays.is_empty(), "{name}: name these between __line_start and __line_end in memory.x: {strays:#?}");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_every_line_passes_through_stands_together() {
    stand_together(Board::elf_variable(Port::Pio), Board::new);
}

mod skr_pico {
    use super::*;

    #[test]
    #[ignore = "needs the firmware: cargo xtask test"]
    fn what_every_line_passes_through_stands_together() {
        stand_together("ISOSTEP_SKR_PICO_ELF", Board::of_skr_pico);
    }
}
