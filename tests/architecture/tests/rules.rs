//! Rules of what must never be, from the section of that name in ARCHITECTURE.md, as far as sources show it. A rule that is
//! broken is reported with file, line, rule and why.
//!
//! `cargo test -p isostep-architecture` compiles nothing else.

use std::fs;
use std::path::{Path, PathBuf};

use isostep_architecture::{dependencies, files, read, root};

/// A rule of the house.
struct Rule {
    /// The rule in words.
    says: &'static str,
    /// The harm that it prevents.
    why: &'static str,
}

/// Places where a rule is broken: file, line and what stands there.
type Broken = Vec<(PathBuf, usize, String)>;

impl Rule {
    /// # Panics
    /// When the rule is broken anywhere.
    fn holds(&self, broken: &Broken) {
        let reported = broken.iter().map(|(file, line, text)| {
            let file = file.strip_prefix(root()).unwrap_or(file).display();
            format!("{file}:{line}: {}\n    {}\n    why: {}\n", text.trim(), self.says, self.why)
        });
        assert!(broken.is_empty(), "\n{}", reported.collect::<String>());
    }
}

fn crate_file(package: &str, file: &str) -> PathBuf {
    root().join("crates").join(package).join(file)
}

/// The Rust files of a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let rust = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "rs");
    files(folder).into_iter().filter(rust).collect()
}

/// The lines of the sources of these crates for which `is_wrong` holds.
fn lines_in(packages: &[&str], is_wrong: impl Fn(&str) -> bool) -> Broken {
    let files = packages.iter().flat_map(|package| sources(&crate_file(package, "src")));
    files.flat_map(|file| numbered(&file, &is_wrong)).collect()
}

fn numbered(file: &Path, is_wrong: &impl Fn(&str) -> bool) -> Broken {
    let text = read(file);
    let lines = text.lines().enumerate().filter(|(_, line)| is_wrong(line));
    lines.map(|(index, line)| (file.to_owned(), index + 1, line.to_owned())).collect()
}

#[test]
fn errors_and_figures_can_grow() {
    // Each of these is taken apart by another crate of the house, which is to miss nothing.
    const WHOLE: [&str; 3] = ["PlanError", "ProgramError", "SimError"];
    let packages = ["profile", "motion", "console", "controller", "sim", "report"];
    let grows = |line: &str| {
        let kind = line.strip_prefix("pub enum ").or_else(|| line.strip_prefix("pub struct "));
        let name = kind.and_then(|rest| rest.split(|c: char| !c.is_alphanumeric()).next()).unwrap_or_default();
        (name.ends_with("Error") && name != "Error" || name.ends_with("Figures")) && !WHOLE.contains(&name)
    };
    assert!(lines_in(&packages, grows).len() > 15);
    let without = |(file, number, _): &(PathBuf, usize, String)| {
        read(file).lines().nth(number - 2).is_none_or(|before| before != "#[non_exhaustive]")
    };
    let broken = lines_in(&packages, grows).into_iter().filter(without).collect();
    Rule { says: "it is `#[non_exhaustive]`", why: "users read it, and one case more would break them" }.holds(&broken);
}

#[test]
fn crates_depend_on_nothing_but_these() {
    let no_clock = "a plan is mathematics: with a clock, a pin or an executor it would need a chip to be tested";
    let no_chip = "it runs on any executor and any chip, so that another board is a crate of its own";
    let no_io = "the dialect is tested by strings alone, and any link can carry it";
    let allowed: &[(&str, &'static str, &[&str])] = &[
        ("profile", no_clock, &["defmt", "libm"]),
        ("generators", no_clock, &["isostep-profile", "libm"]),
        (
            "motion",
            no_chip,
            &[
                "critical-section",
                "defmt",
                "embassy-futures",
                "embassy-sync",
                "embassy-time",
                "embedded-hal",
                "embedded-hal-async",
                "heapless",
                "isostep-profile",
                "libm",
            ],
        ),
        ("console", no_io, &["heapless", "libm"]),
        ("program", no_io, &["libm", "thiserror"]),
        (
            "controller",
            no_chip,
            &[
                "embassy-futures",
                "embassy-sync",
                "embassy-time",
                "embedded-io-async",
                "embedded-storage-async",
                "heapless",
                "isostep-console",
                "isostep-motion",
                "isostep-profile",
                "sequential-storage",
                "modbus-core",
                "tmc2209",
            ],
        ),
    ];
    for (package, why, allowed) in allowed {
        let manifest = crate_file(package, "Cargo.toml");
        let used = dependencies(&manifest);
        assert!(!used.is_empty(), "{package} has dependencies");
        let extra = used.into_iter().filter(|(_, name)| !allowed.contains(&name.as_str()));
        let broken = extra.map(|(line, name)| (manifest.clone(), line, name)).collect();
        Rule { says: "the crate depends on nothing but what this test names", why }.holds(&broken);
    }
}

#[test]
fn nothing_but_the_tool_needs_what_serves_the_papers() {
    let folders = ["crates", "boards"].map(|folder| fs::read_dir(root().join(folder)).unwrap());
    let packages = folders.into_iter().flatten().map(|entry| entry.unwrap().path());
    let packages = packages.filter(|package| !package.ends_with("isostep"));
    let packages = packages.chain(["xtask", "tests"].map(|folder| root().join(folder)));
    let manifests = packages.map(|package| package.join("Cargo.toml"));
    let of_papers = |(_, name): &(usize, String)| name == "isostep-papers";
    let broken = manifests.flat_map(|manifest| {
        let named = dependencies(&manifest).into_iter().filter(of_papers);
        named.map(|(line, name)| (manifest.clone(), line, name)).collect::<Vec<_>>()
    });
    let why = "whoever takes a part of the project need not take the papers along";
    Rule { says: "only isostep depends on isostep-papers", why }.holds(&broken.collect());
}

#[test]
fn no_library_chooses_the_rate_of_the_clock() {
    let libraries = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let manifests = libraries.map(|library| library.join("Cargo.toml")).chain([root().join("Cargo.toml")]);
    let broken = manifests.flat_map(|manifest| numbered(&manifest, &|line| line.contains("tick-hz"))).collect();
    let says = "only a board chooses the tick rate";
    Rule { says, why: "a program has one clock; a library that chooses leaves no board a choice" }.holds(&broken);
}

/// The crates that run on a chip.
const ON_CHIP: [&str; 5] = ["profile", "generators", "motion", "console", "controller"];

#[test]
fn crates_for_the_chip_are_without_std_and_unsafe() {
    for (line, why) in [
        ("#![no_std]", "the crate runs on a chip without an operating system"),
        ("#![forbid(unsafe_code)]", "unsafe is for boards alone, each block with its reason"),
    ] {
        let libraries = ON_CHIP.map(|package| crate_file(package, "src/lib.rs"));
        let without = libraries.into_iter().filter(|library| !read(library).contains(line));
        let broken = without.map(|library| (library, 1, format!("no {line}"))).collect();
        Rule { says: "the library says so in its first lines", why }.holds(&broken);
    }
}

#[test]
fn crates_for_the_chip_do_not_allocate() {
    let broken = lines_in(&ON_CHIP, |line| line.contains("extern crate alloc"));
    let why = "memory that is not there is noticed when linking, not in the middle of a move";
    Rule { says: "nothing allocates", why }.holds(&broken);
}

#[test]
fn mathematics_and_dialect_do_not_await() {
    let broken = lines_in(&["profile", "generators", "console"], |line| line.contains(".await"));
    let why = "what they compute is the same at any time, and is tested without an executor";
    Rule { says: "profile, generators and console do not await", why }.holds(&broken);
}

/// Lines that may depend on `cfg(test)`: unit tests, the standard library for them, the README's examples.
const FOR_TESTS: [&str; 4] = ["mod tests", "extern crate std;", "#[path = ", "#[doc = include_str!"];

#[test]
fn no_task_has_a_twin_for_tests() {
    let files = ["profile", "motion", "console", "controller"].map(|package| sources(&crate_file(package, "src")));
    let broken = files.concat().into_iter().flat_map(|file| {
        let text = read(&file);
        let found: Broken = twins(&text).map(|(line, text)| (file.clone(), line, text.to_owned())).collect();
        found
    });
    let why = "tests are to see the code that ships";
    Rule { says: "nothing but unit tests depends on cfg(test)", why }.holds(&broken.collect());
}

/// The lines that `cfg(test)` includes or excludes, except those that are allowed, with their numbers.
fn twins(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().zip(text.lines().skip(1).chain([""])).enumerate();
    lines.filter_map(|(index, (line, next))| {
        let (line, next) = (line.trim(), next.trim());
        let is_attribute =
            line.starts_with("#[cfg(test") || line.starts_with("#[cfg(doctest") || line.starts_with("#[cfg(all(test");
        if is_attribute && FOR_TESTS.iter().any(|allowed| next.starts_with(allowed)) {
            return None;
        }
        let is_comment = line.starts_with("//");
        let is_conditional = ["cfg(test", "cfg(not(test", "cfg!(test", "cfg_attr(test", "cfg(doctest"]
            .iter()
            .any(|word| line.contains(word));
        (is_conditional && !is_comment).then_some((index + 1, line))
    })
}

#[test]
fn a_twin_is_found_and_unit_tests_are_not() {
    let found = |text| twins(text).map(|(line, _)| line).collect::<Vec<_>>();
    assert_eq!(found("#[cfg(test)]\nmod tests {\n    use super::*;\n}\n"), [0; 0]);
    assert_eq!(found("#[cfg(test)]\nmod tests;\n\nfn more() {}\n"), [0; 0]);
    assert_eq!(found("#[cfg(test)]\nasync fn run() {}\n#[cfg(not(test))]\nasync fn run() {}\n"), [1, 3]);
    assert_eq!(found("let wait = if cfg!(test) { 0 } else { 1 };"), [1]);
}

/// Files of tests in the folder of a package that nothing names: no `mod` beside or above them, and no manifest.
fn unnamed(package: &Path) -> Broken {
    let manifest = read(&package.join("Cargo.toml"));
    let files = sources(&package.join("tests"));
    let texts: Vec<_> = files.iter().map(|file| read(file)).collect();
    let is_named = |file: &PathBuf| {
        let name = file.file_stem().unwrap().to_string_lossy();
        let module = format!("mod {name};");
        let is_module = |text: &String| text.lines().any(|line| line.trim_start_matches("pub ") == module);
        let is_root = ["main", "mod"].contains(&&*name);
        is_root || texts.iter().any(is_module) || manifest.contains(&format!("path = \"tests/{name}.rs\""))
    };
    files.iter().filter(|file| !is_named(file)).map(|file| (file.clone(), 1, String::new())).collect()
}

#[test]
fn every_file_of_tests_is_compiled() {
    let rooms = ["", "crates"].map(|room| fs::read_dir(root().join(room)).unwrap());
    let packages = rooms.into_iter().flatten().map(|entry| entry.unwrap().path());
    let packages: Vec<_> = packages.filter(|package| package.join("tests/main.rs").is_file()).collect();
    assert!(packages.len() > 9, "{packages:?}");
    let broken = packages.iter().flat_map(|package| unnamed(package)).collect();
    Rule { says: "`tests/main.rs` or a module of it names it", why: "a test that nothing names never runs" }
        .holds(&broken);
}

#[test]
#[should_panic(expected = "/lib.rs:7: let x = alloc();\n    nothing allocates\n    why: memory")]
fn a_broken_rule_is_reported_with_its_place_and_why() {
    let rule = Rule { says: "nothing allocates", why: "memory" };
    rule.holds(&vec![(crate_file("motion", "src/lib.rs"), 7, "  let x = alloc();".to_owned())]);
}
