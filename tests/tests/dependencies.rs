//! Compares the dependencies with deny.toml: sources, licences and duplicates, as far as `cargo metadata` and lock files report them.
//! The other checks need cargo-deny, which takes long to build, and are made by `cargo xtask audit`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use isostep_tests::root;
use serde_json::Value;

struct Package {
    name: String,
    version: String,
    /// The licence in its Cargo.toml.
    licence: String,
    /// `None` for packages of the workspace.
    source: Option<String>,
}

/// Every package in Cargo.lock, for all platforms.
fn packages() -> Vec<Package> {
    let mut metadata = Command::new(env!("CARGO"));
    metadata.args(["metadata", "--format-version=1", "--locked"]).current_dir(root());
    let output = metadata.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let package = |package: &Value| Package {
        name: text(&package["name"]).unwrap(),
        version: text(&package["version"]).unwrap(),
        licence: text(&package["license"]).unwrap_or_default(),
        source: text(&package["source"]),
    };
    metadata["packages"].as_array().unwrap().iter().map(package).collect()
}

/// The first quoted word of each line of the list `key` of deny.toml.
fn listed(key: &str) -> BTreeSet<String> {
    let policy = fs::read_to_string(root().join("deny.toml")).unwrap();
    let (_, behind) = policy.split_once(&format!("\n{key} = [")).unwrap_or_else(|| panic!("deny.toml has no {key}"));
    let (list, _) = behind.split_once(']').unwrap();
    let lines = list.lines().filter(|line| !line.trim_start().starts_with('#'));
    lines.filter_map(|line| line.split('"').nth(1).map(str::to_owned)).collect()
}

/// True if all licences that apply can be chosen from the allowed ones. A slash is an old way to write OR.
fn is_allowed(licence: &str, allowed: &BTreeSet<String>) -> bool {
    let is_choice = |part: &str| {
        let part = part.trim_matches(['(', ')', ' ']).replace('/', " OR ");
        part.split(" OR ").any(|one| allowed.contains(one.trim()))
    };
    licence.split(" AND ").all(is_choice)
}

#[test]
fn every_package_is_of_crates_io_or_our_own() {
    let allowed = listed("allow-registry");
    for package in packages() {
        let is_known = package
            .source
            .as_ref()
            .is_none_or(|source| source.strip_prefix("registry+").is_some_and(|registry| allowed.contains(registry)));
        assert!(is_known, "{} {} comes from {:?}", package.name, package.version, package.source);
    }
}

#[test]
fn every_licence_is_allowed() {
    let allowed = listed("allow");
    for Package { name, version, licence, .. } in packages() {
        assert!(is_allowed(&licence, &allowed), "{name} {version}: `{licence}` is not allowed by deny.toml");
    }
}

#[test]
fn a_choice_of_licences_takes_one_and_a_sum_takes_all() {
    let allowed = ["MIT", "Zlib"].map(str::to_owned).into();
    for good in ["MIT", "GPL-3.0-only OR MIT", "Apache-2.0/MIT", "(GPL-3.0-only OR MIT) AND Zlib"] {
        assert!(is_allowed(good, &allowed), "{good}");
    }
    for bad in ["", "GPL-3.0-only", "MIT AND GPL-3.0-only", "MITX"] {
        assert!(!is_allowed(bad, &allowed), "{bad}");
    }
}

#[test]
fn every_older_version_beside_a_newer_one_has_its_reason() {
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in packages() {
        versions.entry(package.name).or_default().insert(package.version);
    }
    let known = listed("skip");
    let mut several = BTreeSet::new();
    for (name, versions) in versions.iter().filter(|(_, versions)| versions.len() > 1) {
        let (older, others): (Vec<_>, Vec<_>) =
            versions.iter().map(|version| format!("{name}@{version}")).partition(|one| known.contains(one));
        assert_eq!(others.len(), 1, "{others:?}: all but one are to be in `skip` of deny.toml, with their reasons");
        several.extend(older);
    }
    assert_eq!(several, known, "what `skip` of deny.toml names is gone, or is the only version");
}

/// The packages that a lock file of npm names: where each lies in node_modules, and what is said of it.
fn of_npm(folder: &str) -> Vec<(String, Value)> {
    let lock = fs::read_to_string(root().join(folder).join("package-lock.json")).unwrap();
    let lock: Value = serde_json::from_str(&lock).unwrap();
    let packages = lock["packages"].as_object().unwrap();
    packages.iter().filter(|(place, _)| !place.is_empty()).map(|(place, said)| (place.clone(), said.clone())).collect()
}

#[test]
fn every_package_of_npm_is_of_a_registry_with_its_hash_and_a_licence_that_is_allowed() {
    let allowed = listed("allow");
    for folder in ["web", "tests/emulator"] {
        let packages = of_npm(folder);
        assert!(!packages.is_empty(), "{folder}");
        for (place, said) in packages {
            let text = |key: &str| said[key].as_str().unwrap_or_default().to_owned();
            let (from, hash, licence) = (text("resolved"), text("integrity"), text("license"));
            // Without an address it comes from the registry that npm is set to, and the hash says whether it is the same.
            let is_of_registry = from.is_empty() || from.starts_with("https://registry.npmjs.org/");
            assert!(is_of_registry && said["link"].is_null(), "{folder}/{place} comes from `{from}`");
            assert!(hash.starts_with("sha512-"), "{folder}/{place} has the hash `{hash}`");
            assert!(is_allowed(&licence, &allowed), "{folder}/{place}: `{licence}` is not allowed by deny.toml");
        }
    }
}

#[test]
fn every_package_of_the_other_workspaces_is_of_crates_io_with_its_hash() {
    let allowed = listed("allow-registry");
    for folder in ["web/bindgen", "tests/fuzz"] {
        let lock = fs::read_to_string(root().join(folder).join("Cargo.lock")).unwrap();
        let mut count = 0;
        for package in lock.split("[[package]]").filter(|package| package.contains("\nsource = ")) {
            let value =
                |key: &str| package.split_once(&format!("\n{key} = \"")).and_then(|(_, rest)| rest.split('"').next());
            let registry = value("source").and_then(|source| source.strip_prefix("registry+"));
            assert!(registry.is_some_and(|registry| allowed.contains(registry)), "{folder}: {package}");
            assert!(value("checksum").is_some_and(|hash| hash.len() == 64), "{folder}: {package}");
            count += 1;
        }
        assert!(count > 5, "{folder} names {count} packages");
    }
}
