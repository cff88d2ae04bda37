//! Checks that the linker has put all code with a deadline into RAM, where it never waits for the cache of the flash.
//!
//! Every emulated run checks this for the code that runs. This test also covers code that no run reaches.

use std::{env, fs};

use isostep_tests::emulated::is_skr_pico;
use object::{Object, ObjectSymbol, SymbolKind};

const RAM_START: u64 = 0x2000_0000;
/// Every function of these crates may run in an interrupt, in a critical section, or while a port waits for segments.
const CRATES_IN_RAM: [&str; 10] = [
    "isostep_motion",
    "isostep_profile",
    "embassy_executor",
    "embassy_sync",
    "embassy_time",
    "embassy_time_queue_utils",
    "embassy_rp",
    "embassy_usb",
    "rp2040_gantry",
    "libm",
];
/// Code without a deadline, all of it in thread mode: it serves the consoles, their reports and arcs; answers a USB host
/// about the device; plans by the curved laws, ahead of time; homes; probes, at the contact and after it; takes an override;
/// gets a chain and a run ready; runs once before anything moves; or is named by a table of functions and called by nobody.
const MAY_WAIT: [&str; 58] = [
    "isostep_console",
    "isostep_controller",
    "rp2040_gantry..flash..Flash",
    "isostep_motion7machine6status",
    "isostep_motion7machine7Machine7emptied",
    "isostep_motion6config6Config12travel_steps",
    "isostep_motion9cold_path4poll",
    "isostep_motion6homing",
    "isostep_motion3run7streams",
    "isostep_motion7shaping48_$LT$impl$u20$isostep_motion..config..Config$GT$7shaping",
    "isostep_profile6shaper6Shaper",
    "isostep_profile6shaper8Impulses6mean_s",
    "12note_contact",
    "10stop_alarm",
    "14override_chain",
    "11begin_chain",
    "isostep_profile4plan",
    "isostep_profile7compile5spans5Spans9next_span",
    "isostep_profile4ramp6Bounds",
    "isostep_profile4ramp9over_time8OverTime6search",
    "isostep_profile4ramp17over_displacement",
    "isostep_profile4ramp4Ramp17over_displacement",
    "isostep_profile4ramp11logarithmic",
    "isostep_profile4ramp10mean_speed",
    "isostep_profile4ramp4trig",
    "isostep_profile7compile5cubic",
    "isostep_profile6shaper3sum3Sum10at_by_jerk",
    "isostep_profile6shaper3sum3Sum13turns_after_s",
    "isostep_profile6shaper6shaped15Shaped$LT$_$GT$4mean",
    "libm4math5atan2",
    "libm4math4atan",
    "libm4math3exp",
    "libm4math5log1p",
    "rp2040_gantry5start",
    "rp2040_gantry9cold_path4poll",
    "rp2040_gantry5touch",
    "embassy_usb7builder",
    "embassy_usb10descriptor",
    "embassy_usb14Inner",
    "embassy_usb4msos",
    "embassy_usb..descriptor_reader",
    "embassy_rp..usb..Bus",
    "embassy_executor3raw4util19UninitCell$LT$T$GT$14write_in_place",
    "rp2040_gantry8pio_port6config",
    "rp2040_gantry6motion11watch_limit",
    "embassy_rp..pwm..Pwm$u20$as$u20$core..ops..drop",
    "embassy_rp..uart..buffered..BufferedUartRx$u20$as$u20$core..ops..drop",
    "embassy_rp..uart..buffered..BufferedUartTx$u20$as$u20$core..ops..drop",
    "embassy_sync..watch..WatchBehavior",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$11send_modify",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$16send_if_modified",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$8poll_get",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$12poll_get_and",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$11try_changed",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$15try_changed_and",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$16poll_changed_and",
    "embassy_sync..watch..SealedWatchBehavior$LT$T$GT$$GT$5clear",
    "core..fmt..D",
];
const HANDLERS: [&str; 9] = [
    "TIMER_IRQ_0",
    "PIO1_IRQ_1",
    "IO_IRQ_BANK0",
    "SWI_IRQ_1",
    "SWI_IRQ_2",
    "DMA_IRQ_1",
    "PIO0_IRQ_1",
    "USBCTRL_IRQ",
    "UART0_IRQ",
];

/// Whether a mangled name belongs to a function of this crate: `name::f`, or `<name::T as Trait>::f`.
fn is_of(symbol: &str, name: &str) -> bool {
    let path = symbol.trim_start_matches("_ZN").trim_start_matches(|digit: char| digit.is_ascii_digit());
    let of = path.trim_start_matches("_$LT$").strip_prefix(name);
    // Another crate's name may begin with the same letters.
    let is_whole = of.is_some_and(|rest| !rest.starts_with(|next: char| next.is_ascii_lowercase() || next == '_'));
    symbol.starts_with("_ZN") && is_whole && !MAY_WAIT.into_iter().any(|cold| symbol.contains(cold))
}

/// Checks the firmware whose ELF file this variable names.
fn check(variable: &str, handlers: &[&str]) {
    let path = env::var_os(variable).unwrap_or_else(|| panic!("{variable}: run these by `cargo xtask test`"));
    let bytes = fs::read(path).unwrap();
    let elf = object::File::parse(&*bytes).unwrap();
    let functions: Vec<_> = elf
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
        .map(|symbol| (symbol.name().unwrap().to_owned(), symbol.address()))
        .collect();
    for handler in handlers {
        let (_, address) = functions.iter().find(|(name, _)| name == handler).unwrap_or_else(|| panic!("no {handler}"));
        assert!(*address >= RAM_START, "{variable}: the handler {handler} is in flash");
    }
    for hot in CRATES_IN_RAM {
        let own: Vec<_> = functions.iter().filter(|(name, _)| is_of(name, hot)).collect();
        assert!(!own.is_empty(), "{variable}: no function of {hot} is found");
        let in_flash: Vec<_> = own.iter().filter(|(_, address)| *address < RAM_START).collect();
        assert!(in_flash.is_empty(), "{variable}: {hot} has functions in flash, see memory.x: {in_flash:#?}");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_has_a_deadline_is_in_ram() {
    check("ISOSTEP_ELF", &HANDLERS);
    // Its steps are made by a task, not by DMA and PIO0.
    let made_by_task: Vec<_> =
        HANDLERS.into_iter().filter(|name| !["DMA_IRQ_1", "PIO0_IRQ_1"].contains(name)).collect();
    check("ISOSTEP_TIMER_PORT_ELF", &made_by_task);
}

/// Whether `name` has the parts of the pattern between its stars, in this order.
fn fits(pattern: &str, mut name: &str) -> bool {
    pattern.split('*').all(|part| {
        let found = name.split_once(part);
        found.into_iter().for_each(|(_, rest)| name = rest);
        found.is_some()
    })
}

/// A function that was given another name would go to another place without a word, and make each line of a program
/// slower.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_the_linker_script_names_exists() {
    let script = include_str!("../../../boards/rp2040-gantry/memory.x");
    let bytes = fs::read(env::var_os("ISOSTEP_ELF").expect("run these by `cargo xtask test`")).unwrap();
    let elf = object::File::parse(&*bytes).unwrap();
    let names: Vec<_> = elf.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned)).collect();
    let words = script.split(|end: char| end.is_whitespace() || "()".contains(end));
    let names_of = |word: &'static str| word.strip_prefix(".text.").or(word.strip_prefix(".rodata.*"));
    // Patterns with a class of characters are of many modules.
    let patterns: Vec<_> = words.filter_map(names_of).filter(|word| !word.contains('[')).collect();
    assert!(patterns.len() > 10, "{patterns:?}");
    // A Pico's drivers have no UART.
    let is_here = |pattern: &&str| is_skr_pico() || !pattern.contains("tmc2209");
    for pattern in patterns.into_iter().filter(is_here) {
        assert!(names.iter().any(|name| fits(pattern, name)), "memory.x: nothing has a name that fits `{pattern}`");
    }
}
