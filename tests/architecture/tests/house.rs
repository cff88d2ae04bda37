//! The picture of the house in ARCHITECTURE.md, and the links of all pages.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use isostep_architecture::{dependencies, files, read, root};

/// The folders of packages, and their packages in the picture.
const FOLDERS: [&str; 3] = ["crates", "boards", "tests"];

/// A package of the house.
struct Package {
    /// Its folder, from the root.
    folder: String,
    description: String,
    /// The folders of the packages that it names, without those that others of them bring along.
    stands_on: Vec<String>,
    /// 0 for one that stands on nothing, otherwise one more than the highest that it stands on.
    level: usize,
}

/// The value of a key of a manifest's first section.
fn value(manifest: &str, key: &str) -> String {
    let line = manifest.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
    line.unwrap_or_else(|| panic!("no {key} in\n{manifest}")).trim_matches('"').to_owned()
}

fn packages() -> Vec<Package> {
    let manifests = FOLDERS.into_iter().chain(["xtask"]).flat_map(|folder| files(&root().join(folder)));
    let manifests: Vec<PathBuf> = manifests.filter(|path| path.ends_with("Cargo.toml")).collect();
    let folder_of = |path: &Path| path.parent().unwrap().strip_prefix(root()).unwrap().display().to_string();
    let folders: BTreeMap<String, String> =
        manifests.iter().map(|path| (value(&read(path), "name"), folder_of(path))).collect();
    let named: BTreeMap<String, BTreeSet<String>> = manifests
        .iter()
        .map(|path| {
            let names = dependencies(path).into_iter().filter_map(|(_, name)| folders.get(&name).cloned());
            (folder_of(path), names.collect())
        })
        .collect();
    let package = |path: &PathBuf| {
        let folder = folder_of(path);
        let direct = &named[&folder];
        let brought = |one: &String| direct.iter().any(|other| other != one && below(other, &named).contains(one));
        let stands_on = direct.iter().filter(|one| !brought(one)).cloned().collect();
        let level = level(&folder, &named);
        Package { folder, description: value(&read(path), "description"), stands_on, level }
    };
    manifests.iter().map(package).collect()
}

fn below(folder: &str, named: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    named[folder].iter().flat_map(|one| below(one, named).into_iter().chain([one.clone()])).collect()
}

fn level(folder: &str, named: &BTreeMap<String, BTreeSet<String>>) -> usize {
    named[folder].iter().map(|one| level(one, named) + 1).max().unwrap_or_default()
}

/// The last word of a folder.
fn short(folder: &str) -> &str {
    folder.rsplit('/').next().unwrap_or(folder)
}

/// The picture: a line for each package, the highest first.
fn picture() -> String {
    let mut packages = packages();
    packages.sort_by_key(|package| std::cmp::Reverse(package.level));
    let mut picture = String::new();
    for top in FOLDERS.into_iter().chain(["xtask"]) {
        for package in packages.iter().filter(|package| package.folder.split('/').next() == Some(top)) {
            let stands_on: Vec<_> = package.stands_on.iter().map(|folder| short(folder)).collect();
            let arrow = if stands_on.is_empty() { String::new() } else { format!("-> {}", stands_on.join(", ")) };
            let line = format!("{:22} {arrow:43} {}", package.folder, package.description);
            writeln!(picture, "{}", line.trim_end()).unwrap();
        }
    }
    picture
}

#[test]
fn architecture_shows_the_house_as_the_manifests_have_it() {
    let picture = picture();
    let page = read(&root().join("ARCHITECTURE.md"));
    assert!(page.contains(&format!("```\n{picture}```\n")), "ARCHITECTURE.md is to show this picture:\n{picture}");
}

#[test]
fn every_folder_stands_in_architecture() {
    let page = read(&root().join("ARCHITECTURE.md"));
    let is_shown =
        |folder: &str| [format!("\n{folder} "), format!("`{folder}`")].iter().any(|name| page.contains(name));
    let all = FOLDERS.into_iter().flat_map(|top| files(&root().join(top)));
    let folders: BTreeSet<String> = all
        .filter_map(|path| {
            let path = path.strip_prefix(root()).unwrap().to_owned();
            let mut parts = path.iter().map(|part| part.to_str().unwrap());
            let (top, folder, file) = (parts.next()?, parts.next()?, parts.next());
            file.map(|_| format!("{top}/{folder}"))
        })
        .collect();
    assert!(folders.len() > 20, "{folders:?}");
    let missing: Vec<_> = folders.iter().filter(|folder| !is_shown(folder)).collect();
    assert!(missing.is_empty(), "ARCHITECTURE.md does not say what is in {missing:?}");
}

/// A path in the page leads from the root, from `crates`, or from the folder of sources that its row names.
#[test]
fn every_file_that_architecture_names_exists() {
    let all: Vec<String> = ["crates", "boards", "tests", "xtask"]
        .into_iter()
        .flat_map(|top| files(&root().join(top)))
        .map(|path| path.display().to_string())
        .collect();
    let page = read(&root().join("ARCHITECTURE.md"));
    let words = page.split('`').skip(1).step_by(2);
    let named: Vec<_> = words
        .filter(|word| [".rs", ".mjs"].iter().any(|end| word.ends_with(end)) && !word.contains(['*', ' ']))
        .collect();
    assert!(named.len() > 25, "{named:?}");
    let gone: Vec<_> =
        named.iter().filter(|name| !all.iter().any(|path| path.ends_with(&format!("/{name}")))).collect();
    assert!(gone.is_empty(), "ARCHITECTURE.md names files that are gone: {gone:?}");
}

/// The pages of the project, as far as people read them.
fn pages() -> Vec<PathBuf> {
    let tops = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|page| root().join(page));
    let below = ["docs", "crates", "boards", "tests", "web", "xtask"].map(|folder| files(&root().join(folder)));
    let is_page = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "md");
    tops.into_iter().chain(below.into_iter().flatten().filter(is_page)).collect()
}

/// The targets of the links of a page, without those on other sites.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1).filter_map(|behind| behind.split_once(')')).map(|(target, _)| target);
    targets.filter(|target| !target.starts_with("http") && !target.contains([' ', '\n']))
}

/// True if a link of a crate's README, which is part of its documentation, names an item of the code.
fn is_item(link: &str) -> bool {
    !link.contains(['.', '/', '#'])
}

/// The anchors of a page, as its host makes them of the headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let anchor = |heading: &str| {
        let kept = heading.to_lowercase().replace(' ', "-");
        kept.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut broken = String::new();
    let mut count = 0;
    for page in pages() {
        let text = read(&page);
        let is_crate = page.starts_with(root().join("crates"));
        for link in links(&text).filter(|link| !(is_crate && is_item(link))) {
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let is_there = target.exists() && (anchor.is_empty() || anchors(&read(&target)).contains(anchor));
            if !is_there {
                writeln!(broken, "{}: {link}", page.strip_prefix(root()).unwrap().display()).unwrap();
            }
        }
    }
    assert!(count > 200, "only {count} links were found");
    assert!(broken.is_empty(), "links that lead nowhere:\n{broken}");
}

#[test]
fn an_anchor_is_that_of_its_heading() {
    let page = "# A page\n## What is said, and what to do\n### `$n=v`: 1. It\n";
    assert_eq!(anchors(page), ["a-page", "nv-1-it", "what-is-said-and-what-to-do"].map(str::to_owned).into());
    assert_eq!(links("[a](b.md#c) [d](https://e) ![f](g.svg)").collect::<Vec<_>>(), ["b.md#c", "g.svg"]);
}
