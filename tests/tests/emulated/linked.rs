//! Checks that the linker has put all code with a deadline into RAM, where it never waits for the cache of the flash.
//!
//! Every emulated run checks this for the code that runs. This test also covers code that no run reaches.

use std::path::Path;
use std::{env, fs};

use isostep_sim::AXES;
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
    "pico_gantry",
    "libm",
];
/// The sources of those of them in which functions are marked `#[cold]`.
const SOURCES: [(&str, &str); 3] = [
    ("isostep_motion", "crates/motion/src"),
    ("isostep_profile", "crates/profile/src"),
    ("pico_gantry", "boards/pico-gantry/src"),
];
const SCRIPT: &str = include_str!("../../../boards/pico-gantry/memory.x");
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

/// True if a mangled name belongs to a function of this crate: `name::f`, or `<name::T as Trait>::f`.
fn is_of(symbol: &str, name: &str) -> bool {
    let path = symbol.trim_start_matches("_ZN").trim_start_matches(|digit: char| digit.is_ascii_digit());
    let of = path.trim_start_matches("_$LT$").strip_prefix(name);
    // Another crate's name may begin with the same letters.
    let is_whole = of.is_some_and(|rest| !rest.starts_with(|next: char| next.is_ascii_lowercase() || next == '_'));
    symbol.starts_with("_ZN") && is_whole
}

/// True if a mangled name has this element, with its length before it.
fn has_element(symbol: &str, element: &str) -> bool {
    let mut found = symbol.match_indices(element);
    found.any(|(at, _)| !symbol[..at].ends_with(|before: char| before.is_ascii_digit()))
}

/// The functions that are marked `#[cold]` in a folder of sources, as they stand in mangled names.
fn marked(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            names.extend(marked(&path));
        } else {
            let text = fs::read_to_string(&path).unwrap();
            names.extend(text.split("#[cold]").skip(1).map(|after| {
                let (_, name) = after.split_once("fn ").unwrap();
                let name = &name[..name.find(['(', '<']).unwrap()];
                format!("{}{name}", name.len())
            }));
        }
    }
    names
}

/// The patterns of the linker script by which code lies in flash: no classes of characters, and not all cold functions.
fn patterns() -> Vec<&'static str> {
    let words = SCRIPT.split(|end: char| end.is_whitespace() || "()".contains(end));
    let names = words.filter_map(|word| word.strip_prefix(".text.").or(word.strip_prefix(".rodata.*")));
    names.filter(|word| !word.contains('[') && !word.starts_with("unlikely") && *word != "*").collect()
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
    let patterns = patterns();
    for hot in CRATES_IN_RAM {
        let source = SOURCES.iter().find(|(name, _)| *name == hot);
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let marked = source.map_or_else(Vec::new, |(_, folder)| marked(&root.join(folder)));
        let may_wait = |name: &str| {
            marked.iter().any(|cold| has_element(name, cold)) || patterns.iter().any(|pattern| fits(pattern, name))
        };
        let own: Vec<_> = functions.iter().filter(|(name, _)| is_of(name, hot)).collect();
        assert!(!own.is_empty(), "{variable}: no function of {hot} is found");
        let in_flash: Vec<_> = own.iter().filter(|(name, address)| *address < RAM_START && !may_wait(name)).collect();
        assert!(
            in_flash.is_empty(),
            "{variable}: {hot} has functions in flash that are neither `#[cold]` nor named in memory.x: {in_flash:#?}"
        );
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_has_a_deadline_is_in_ram() {
    check("ISOSTEP_ELF", &HANDLERS);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_has_a_deadline_is_in_ram_by_the_timer_port_too() {
    // Its steps are made by a task, not by DMA and PIO0.
    let made_by_task: Vec<_> =
        HANDLERS.into_iter().filter(|name| !["DMA_IRQ_1", "PIO0_IRQ_1"].contains(name)).collect();
    check("ISOSTEP_TIMER_PORT_ELF", &made_by_task);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_has_a_deadline_is_in_ram_of_a_pico_2_too() {
    let of_rp2350 = HANDLERS.map(|name| if name == "TIMER_IRQ_0" { "TIMER0_IRQ_0" } else { name });
    check("ISOSTEP_PICO_2_ELF", &of_rp2350);
}

/// True if `name` has the parts of the pattern between its stars, in this order.
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
    let bytes = fs::read(env::var_os("ISOSTEP_ELF").expect("run these by `cargo xtask test`")).unwrap();
    let elf = object::File::parse(&*bytes).unwrap();
    let names: Vec<_> = elf.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned)).collect();
    let patterns = patterns();
    assert!(patterns.len() > 10, "{patterns:?}");
    // A Pico's drivers have no UART, through which a reset has a second function that waits for it. Without a fourth axis none
    // turns.
    let of_uart = |pattern: &str| ["tmc2209", "driver_wire", "Resets"].iter().any(|name| pattern.contains(name));
    let is_here = |pattern: &&str| (is_skr_pico() || !of_uart(pattern)) && (AXES == 4 || !pattern.contains("rotary"));
    for pattern in patterns.into_iter().filter(is_here) {
        assert!(names.iter().any(|name| fits(pattern, name)), "memory.x: nothing has a name that fits `{pattern}`");
    }
}
