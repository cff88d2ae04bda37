//! The position contract on the emulated board: the cases that the simulator has too, and those that only a chip has.

use std::{env, fs};

use isostep_sim::Port;
use isostep_tests::contract::{self, Case, On};
use isostep_tests::dialogue;
use isostep_tests::emulated::Board;
use isostep_trials::cases;
use object::{Object, ObjectSymbol};

/// A function of the standard library that panics and takes only the location to report as an argument.
const PANICS: &str = "4core6option13unwrap_failed";

/// The address of a function that panics, in hexadecimal.
fn panic_address(port: Port) -> String {
    let elf = fs::read(env::var_os(Board::elf_variable(port)).expect("the firmware: cargo xtask test")).unwrap();
    let elf = object::File::parse(&*elf).unwrap();
    let symbol = elf.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains(PANICS)));
    format!("{:x}", symbol.expect("a function that panics").address())
}

/// Unless all cases are tried, what the simulator has too is left to it.
fn held_to_the_contract(port: Port) {
    let has_all = cases(0, 1) == 1;
    let knows = |case: &Case| case.on == On::Every && has_all || case.on == On::Board || case.on == On::BoardBy(port);
    let machine = "with emulator --second X,0\n";
    contract::keep(dialogue::On::Board(port), machine, knows, &panic_address(port));
}

/// The same with crossed belts. What only a chip has is the same there, so that is only for all cases, too.
fn held_to_the_contract_with_crossed_belts(port: Port) {
    let has_all = cases(0, 1) == 1;
    let is_for = |on| on == On::BoardBy(port) || has_all && matches!(on, On::Every | On::Board);
    let knows = |case: &Case| !case.is_squared() && is_for(case.on);
    contract::keep(dialogue::On::Board(port), "with $907=1\n", knows, &panic_address(port));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_way_to_end_keeps_the_contract() {
    held_to_the_contract(Port::Pio);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_way_to_end_keeps_the_contract_by_the_timer_port() {
    held_to_the_contract(Port::Timer);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_way_to_end_keeps_the_contract_with_crossed_belts() {
    held_to_the_contract_with_crossed_belts(Port::Pio);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_way_to_end_keeps_the_contract_with_crossed_belts_by_the_timer_port() {
    held_to_the_contract_with_crossed_belts(Port::Timer);
}
