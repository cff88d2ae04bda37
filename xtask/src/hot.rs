//! The part of the code in RAM that runs while the machine moves: counted on the emulated board, function by function.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use serde::Deserialize;

use crate::process::{self, announce};
use crate::variant::Variant;
use crate::{node, workspace};

const RAM_START_ADDRESS: u64 = 0x2000_0000;
/// An instruction has four bytes if the first five bits of its first half-word are one of the three highest numbers.
const WIDE_SHIFT: u32 = 11;
const WIDE_LEAST: u16 = 0b11101;
const KIB: f64 = 1024.0;
/// A program that homes and moves all axes, and one with arcs and a laser; each with its settings.
const PROGRAMS: [(&str, &[&str]); 2] = [("parking.nc", &[]), ("engraving.nc", &["32=1"])];
/// The groups of code, by what the names of their functions contain. A function belongs to the group whose name comes
/// first in its own.
const GROUPS: [&str; 7] =
    ["isostep_profile", "isostep_motion", "isostep_console", "isostep_controller", "pico_gantry", "embassy", "libm"];
const OTHERS: &str = "others";
/// The number of functions listed that never run in motion.
const LISTED: usize = 8;

/// A function in RAM.
struct Function {
    name: String,
    address: u64,
    code: Vec<u8>,
    /// Bytes of its instructions that ran while the machine moved.
    hot_bytes: u64,
}

impl Function {
    fn bytes(&self) -> u64 {
        self.code.len() as u64
    }
}

/// A line of the emulator's profile.
#[derive(Deserialize)]
struct Executed {
    address: u64,
    in_motion: f64,
}

/// Runs a variant of the firmware, which has been built, on the emulated board. Returns a table of its code in RAM beside what of
/// it ran in motion.
pub fn table(variant: Variant) -> Result<String> {
    let mut functions = functions(&variant.elf())?;
    node::prepare()?;
    let mut hot = BTreeSet::new();
    for (program, settings) in PROGRAMS {
        announce(&format!("{program} on the emulated board"));
        let executed = run(variant, program, settings)?;
        hot.extend(executed.iter().filter(|executed| executed.in_motion > 0.0).map(|executed| executed.address));
    }
    hot.into_iter().for_each(|address| note(&mut functions, address));
    Ok(shown(&functions))
}

/// The functions in RAM, by address.
fn functions(elf: &Path) -> Result<Vec<Function>> {
    let bytes = fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).with_context(|| format!("{} is no firmware", elf.display()))?;
    let symbols = file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0);
    let in_ram = symbols.filter_map(|symbol| {
        // The lowest bit says that it is Thumb code.
        let address = symbol.address() & !1;
        let section = file.section_by_index(symbol.section_index().filter(|_| address >= RAM_START_ADDRESS)?).ok()?;
        let code = section.data_range(address, symbol.size()).ok()??.to_vec();
        Some(Function { name: symbol.name().unwrap_or_default().to_owned(), address, code, hot_bytes: 0 })
    });
    let mut functions: Vec<_> = in_ram.collect();
    functions.sort_by_key(|function| function.address);
    functions.dedup_by_key(|function| function.address);
    Ok(functions)
}

/// The instructions that the core has executed.
fn run(variant: Variant, program: &str, settings: &[&str]) -> Result<Vec<Executed>> {
    let profile = workspace::target_dir().join("profile.csv");
    let mut command = Command::new("node");
    command.arg(workspace::emulator_dir().join("run.mjs")).arg("--elf").arg(variant.elf());
    command.args(["--board", variant.board.name(), "--driver", variant.driver_name()]);
    command.arg("--program").arg(workspace::root().join("programs").join(program));
    command.args(settings.iter().flat_map(|setting| ["--set", setting])).arg("--profile").arg(&profile);
    process::output(&mut command, "install Node.js")?;
    let rows = csv::Reader::from_path(&profile).and_then(|file| file.into_deserialize().collect());
    rows.with_context(|| format!("the profile in {} cannot be read", profile.display()))
}

/// Counts the instruction at `address`, which ran while the machine moved.
fn note(functions: &mut [Function], address: u64) {
    let after = functions.partition_point(|function| function.address <= address);
    let Some(function) = after.checked_sub(1).and_then(|at| functions.get_mut(at)) else { return };
    let code = function.code.get((address - function.address) as usize..).unwrap_or_default();
    function.hot_bytes += instruction_bytes(code);
}

/// Bytes of the instruction with which this code begins: two or four; 0 where there is no code.
fn instruction_bytes(code: &[u8]) -> u64 {
    match code {
        [low, high, ..] if u16::from_le_bytes([*low, *high]) >> WIDE_SHIFT >= WIDE_LEAST => 4,
        [_, _, ..] => 2,
        _ => 0,
    }
}

fn group(name: &str) -> &'static str {
    let found = GROUPS.into_iter().filter_map(|group| name.find(group).map(|at| (at, group)));
    found.min().map_or(OTHERS, |(_, group)| group)
}

fn shown(functions: &[Function]) -> String {
    // All bytes, those of functions that run in motion, and those of instructions that do.
    let mut sums: BTreeMap<_, [u64; 3]> = BTreeMap::new();
    for function in functions {
        let touched = if function.hot_bytes > 0 { function.bytes() } else { 0 };
        for name in [group(&function.name), "all"] {
            let sum = sums.entry(name).or_default();
            *sum = [sum[0] + function.bytes(), sum[1] + touched, sum[2] + function.hot_bytes];
        }
    }
    let mut text =
        format!("{:<24}{:>8}{:>17}{:>22}\n", "functions in RAM, KiB", "all", "run in motion", "their instructions");
    for (name, sum) in &sums {
        let [all, touched, hot] = sum.map(|bytes| bytes as f64 / KIB);
        text += &format!("{name:<24}{all:>8.1}{touched:>17.1}{hot:>22.1}\n");
    }
    let mut cold: Vec<_> = functions.iter().filter(|function| function.hot_bytes == 0).collect();
    cold.sort_by_key(|function| (u64::MAX - function.bytes(), function.address));
    text += "\nThe largest that did not run in motion, bytes:\n";
    for function in cold.into_iter().take(LISTED) {
        text += &format!("{:>6}  {}\n", function.bytes(), function.name);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function of instructions of two bytes.
    fn function(name: &str, address: u64, bytes: usize) -> Function {
        Function { name: name.to_owned(), address, code: vec![0; bytes], hot_bytes: 0 }
    }

    #[test]
    fn an_instruction_counts_for_the_function_around_it() {
        let mut functions = [function("a", 0x2000_0000, 8), function("b", 0x2000_0010, 4)];
        for address in [0x1000_0000, 0x2000_0000, 0x2000_0006, 0x2000_0008, 0x2000_0014] {
            note(&mut functions, address);
        }
        assert_eq!(functions.map(|function| function.hot_bytes), [4, 0]);
    }

    #[test]
    fn an_instruction_counts_as_many_bytes_as_it_has() {
        // movs r0, #0; bl; add.w r0, r0, r0; b
        let halfwords: [u16; 6] = [0x2000, 0xF000, 0xF800, 0xEB00, 0x0000, 0xE7FE];
        let code = halfwords.iter().flat_map(|halfword| halfword.to_le_bytes()).collect();
        let mut functions = [Function { code, ..function("a", 0x2000_0000, 0) }];
        for (address, hot_bytes) in [(0x2000_0000, 2), (0x2000_0002, 6), (0x2000_0006, 10), (0x2000_000A, 12)] {
            note(&mut functions, address);
            assert_eq!(functions[0].hot_bytes, hot_bytes);
        }
    }

    #[test]
    fn a_function_belongs_to_the_crate_that_its_name_begins_with() {
        assert_eq!(group("_ZN14isostep_motion4flow55_$LT$impl$u20$isostep_profile..X$GT$4push17hE"), "isostep_motion");
        assert_eq!(group("_ZN4core3ptr40drop_in_place$LT$embassy_time..timer..Timer$GT$17hE"), "embassy");
        assert_eq!(group("__aeabi_memcpy"), "others");
    }

    #[test]
    fn the_table_has_sums_and_names_what_does_not_run() {
        let mut functions = [function("_ZN4libm3exp17hE", 0x2000_0000, 2_048), function("memcpy", 0x2000_0800, 1_024)];
        functions[1].hot_bytes = 512;
        let text = shown(&functions);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[1], "all                          3.0              1.0                   0.5");
        assert_eq!(lines[2], "libm                         2.0              0.0                   0.0");
        assert_eq!(lines[3], "others                       1.0              1.0                   0.5");
        assert_eq!(lines[6..], ["  2048  _ZN4libm3exp17hE"]);
    }
}
