//! The page about the swarm on many machines: its first command, as it stands there.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The first block of shell in the page.
fn first_command() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/swarm.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, rest) = page.split_once("```sh\n").expect("a block of shell");
    rest.split_once("```").expect("it ends").0.to_owned()
}

/// Runs the command in a folder of its own, where `isostep` is the one under test.
#[test]
fn the_shards_of_gnu_parallel_are_all_worlds() {
    if Command::new("parallel").arg("--version").output().is_err() {
        eprintln!("skipped: GNU parallel is not installed");
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("swarm-shards");
    fs::create_dir_all(&folder).unwrap();
    let tool = Path::new(env!("CARGO_BIN_EXE_isostep")).parent().unwrap();
    let path = env::join_paths([tool.to_owned()].into_iter().chain(env::split_paths(&env::var_os("PATH").unwrap())));
    let mut command = Command::new("sh");
    command.args(["-ec", &first_command()]).current_dir(&folder).env("PATH", path.unwrap());
    assert!(command.status().unwrap().success());
    let lines = fs::read_to_string(folder.join("shards.jsonl")).unwrap();
    let shards: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: BTreeSet<_> = shards.iter().map(|shard| shard["shard"].as_str().unwrap()).collect();
    assert_eq!(names, BTreeSet::from(["1/4", "2/4", "3/4", "4/4"]));
    assert_eq!(shards.iter().map(|shard| shard["worlds"].as_u64().unwrap()).sum::<u64>(), 40);
    assert!(shards.iter().all(|shard| shard["failures"] == Value::Array(Vec::new())), "{lines}");
    assert!(shards.iter().all(|shard| shard["steps"].as_u64() > Some(0)), "{lines}");
}
