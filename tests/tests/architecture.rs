//! Tests for the section "What must never be" of ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use isostep_tests::root;
use serde_json::Value;

/// The direct dependencies of each workspace package, without dev-dependencies.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version=1", "--no-deps", "--offline"])
        .current_dir(root())
        .output()
        .unwrap();
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let of = |package: &Value| {
        let used = package["dependencies"].as_array().unwrap().iter().filter(|used| used["kind"].is_null());
        used.map(|used| text(&used["name"])).collect()
    };
    metadata["packages"].as_array().unwrap().iter().map(|package| (text(&package["name"]), of(package))).collect()
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] })
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .collect()
}

#[test]
fn packages_depend_on_nothing_but_these() {
    let allowed: &[(&str, &[&str])] = &[
        // These need no clock, no pin and no executor.
        ("isostep-profile", &["defmt", "libm"]),
        ("isostep-generators", &["isostep-profile", "libm"]),
        // This needs no executor and no chip.
        (
            "isostep-motion",
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
        // This needs no input, no output and no motion.
        ("isostep-console", &["heapless", "libm"]),
        (
            "isostep-controller",
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
            ],
        ),
    ];
    let used = dependencies();
    for (package, allowed) in allowed {
        let allowed = allowed.iter().map(ToString::to_string).collect();
        let extra: Vec<_> = used[*package].difference(&allowed).collect();
        assert!(extra.is_empty(), "{package} must not depend on {extra:?}");
    }
}

/// A program has one clock, and one tick rate of it. If a library chose that, no board could choose another.
#[test]
fn no_library_chooses_the_rate_of_the_clock() {
    let libraries = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    for manifest in libraries.map(|library| library.join("Cargo.toml")).chain([root().join("Cargo.toml")]) {
        let text = fs::read_to_string(&manifest).unwrap();
        assert!(!text.contains("tick-hz"), "{} chooses a tick rate, which only a board may", manifest.display());
    }
}

#[test]
fn chip_crates_neither_allocate_nor_await_where_they_must_not() {
    for package in ["profile", "generators", "motion", "console", "controller"] {
        let library = fs::read_to_string(root().join("crates").join(package).join("src/lib.rs")).unwrap();
        assert!(library.contains("#![no_std]"), "{package} is for the chip too");
        assert!(library.contains("#![forbid(unsafe_code)]"), "{package} needs no unsafe");
        for path in sources(&root().join("crates").join(package).join("src")) {
            let text = fs::read_to_string(&path).unwrap();
            assert!(!text.contains("extern crate alloc"), "{} must not allocate", path.display());
            let is_sync = ["profile", "generators", "console"].contains(&package);
            assert!(!(is_sync && text.contains(".await")), "{} must not await", path.display());
        }
    }
}

/// Lines that may depend on `cfg(test)`: unit tests, the standard library for them, the README's examples.
const FOR_TESTS: [&str; 4] = ["mod tests", "extern crate std;", "#[path = ", "#[doc = include_str!"];

/// A task, and anything that a task uses, must not have a second version for tests: the tested code is the code that
/// ships. Unit tests inside a crate are allowed.
#[test]
fn no_task_has_a_twin_for_tests() {
    for package in ["profile", "motion", "console", "controller"] {
        for path in sources(&root().join("crates").join(package).join("src")) {
            let text = fs::read_to_string(&path).unwrap();
            let found: Vec<&str> = twins(&text).collect();
            assert!(
                found.is_empty(),
                "{}: {found:?} differ in tests: tests are to see the code that ships",
                path.display()
            );
        }
    }
}

/// The lines that `cfg(test)` includes or excludes, except those that are allowed.
fn twins(text: &str) -> impl Iterator<Item = &str> {
    let lines = text.lines().zip(text.lines().skip(1).chain([""]));
    lines.filter_map(|(line, next)| {
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
        (is_conditional && !is_comment).then_some(line)
    })
}

#[test]
fn a_twin_is_found_and_unit_tests_are_not() {
    let found = |text| twins(text).count();
    assert_eq!(found("#[cfg(test)]\nmod tests {\n    use super::*;\n}\n"), 0);
    assert_eq!(found("#[cfg(test)]\nmod tests;\n\nfn more() {}\n"), 0);
    assert_eq!(found("#[cfg(test)]\nasync fn run() {}\n#[cfg(not(test))]\nasync fn run() {}\n"), 2);
    assert_eq!(found("let wait = if cfg!(test) { 0 } else { 1 };"), 1);
}
