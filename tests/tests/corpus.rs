//! Runs the inputs that the fuzzers have kept, including those that once failed, without a fuzzer.

use std::fs;
use std::panic::catch_unwind;

use isostep_tests::fuzz::TARGETS;
use isostep_tests::root;

/// Minimum number of files. An empty folder would test nothing.
const FILES_MIN: usize = 10;

fn replay(name: &str) {
    let (_, target) = TARGETS.into_iter().find(|(other, _)| *other == name).expect("a target");
    let folder = root().join("tests/fuzz/corpus").join(name);
    let mut paths: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(paths.len() >= FILES_MIN, "{} files in {}", paths.len(), folder.display());
    for path in paths {
        let bytes = fs::read(&path).unwrap();
        assert!(catch_unwind(|| target(&bytes)).is_ok(), "again: cargo xtask fuzz {name} --file {}", path.display());
    }
}

#[test]
fn console() {
    replay("console");
}

#[test]
fn store() {
    replay("store");
}

#[test]
fn planner() {
    replay("planner");
}

#[test]
fn blends() {
    replay("blends");
}

#[test]
fn machine() {
    replay("machine");
}
