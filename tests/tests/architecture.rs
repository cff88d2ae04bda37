//! What must never be, held: see ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use isostep_tests::root;
use serde_json::Value;

/// Each workspace package's own dependencies, dev-dependencies left out.
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
        // No clock, no pin, no executor.
        ("isostep-profile", &["defmt", "libm"]),
        ("isostep-generators", &["isostep-profile", "libm"]),
        // No executor, no chip.
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
        // No input, no output, no motion.
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

#[test]
fn no_task_has_a_twin_for_tests() {
    for package in ["motion", "controller"] {
        for path in sources(&root().join("crates").join(package).join("src")) {
            let text = fs::read_to_string(&path).unwrap();
            // Tests of a function, behind all else, are not in its place.
            let ships = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
            assert!(!ships.contains("cfg(test)"), "{}: the code that is tested is the code that ships", path.display());
        }
    }
}
