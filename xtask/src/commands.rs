//! Every command that README and docs show is one that the tool takes; those that take no time are run.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use isostep::Verb;

use crate::workspace;

/// A placeholder for a word of the reader's, and a word for it.
const PLACEHOLDERS: [(&str, &str); 3] = [("NAME", "sine"), ("CRATE", "console"), ("N", "1")];
/// Files of the reader's, and those of ours that stand for them in a run.
const READERS: [(&str, &str); 4] = [
    ("FILE", "programs/square.nc"),
    ("my.nc", "programs/square.nc"),
    ("my.txt", "programs/machines/c.txt"),
    ("grbl.txt", "crates/report/tests/listings/laser-500.txt"),
];
/// Files that a verb writes, by option.
const WRITTEN: [&str; 6] = ["--write", "--trace", "--json", "--report", "--csv", "--plot"];

/// A command, as a page shows it.
struct Shown {
    /// `docs/programs.md:6`
    place: String,
    text: String,
}

#[test]
fn every_command_that_is_shown_is_taken() {
    let shown = all();
    assert!(shown.len() > 150, "only {} commands were found", shown.len());
    let refused: Vec<_> = shown
        .iter()
        .filter_map(|one| Some(format!("{}: `{}`\n{}", one.place, one.text, taken(&one.text).err()?)))
        .collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

#[test]
fn what_is_shown_and_takes_no_time_runs() {
    let folder = std::env::temp_dir().join(format!("isostep-commands-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let mut ran = 0;
    for one in all() {
        let Some(verb) = tool_words(&one.text).and_then(|words| quick(&words, &folder)) else { continue };
        verb.run().unwrap_or_else(|error| panic!("{}: `{}`: {error:#}", one.place, one.text));
        ran += 1;
    }
    assert!(ran > 20, "only {ran} ran");
    fs::remove_dir_all(folder).unwrap();
}

/// All commands of README and docs, in order.
fn all() -> Vec<Shown> {
    let root = workspace::root();
    let mut pages: Vec<PathBuf> = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.push(root.join("README.md"));
    pages.sort();
    pages.iter().flat_map(|page| shown(&workspace::shown(page), &fs::read_to_string(page).unwrap())).collect()
}

/// The commands of a page: lines of its code blocks, and what stands between backticks, on one line or on two.
fn shown(name: &str, text: &str) -> Vec<Shown> {
    let mut found = Vec::new();
    let (mut is_block, mut quoted) = (false, None::<(usize, String)>);
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim_start().starts_with("```") {
            is_block = !is_block;
        } else if is_block {
            found.push((number, line.to_owned()));
        } else {
            for (index, part) in line.split('`').enumerate() {
                if index > 0 {
                    match quoted.take() {
                        Some(one) => found.push(one),
                        None => quoted = Some((number, String::new())),
                    }
                }
                if let Some((_, text)) = &mut quoted {
                    text.push_str(part);
                }
            }
            if let Some((_, text)) = &mut quoted {
                text.push(' ');
            }
        }
    }
    let commands = found.into_iter().flat_map(|(number, text)| {
        let parts: Vec<_> = text.split(" && ").map(|part| command(part).to_owned()).collect();
        parts.into_iter().map(move |text| Shown { place: format!("{name}:{number}"), text })
    });
    commands.filter(|one| is_ours(&one.text)).collect()
}

/// The command of a line: without its prompt, the variables before it, where its output goes, and the remark behind it.
fn command(line: &str) -> &str {
    let mut text = line.trim().trim_start_matches("$ ");
    while let Some((first, rest)) = text.split_once(' ')
        && first.split_once('=').is_some_and(|(name, _)| name.chars().all(|c| c.is_ascii_uppercase() || c == '_'))
    {
        text = rest.trim_start();
    }
    ["  ", " > ", " | ", " #"].iter().fold(text, |text, end| text.split_once(end).map_or(text, |(text, _)| text))
}

fn is_ours(text: &str) -> bool {
    ["cargo xtask ", "cargo run ", "cargo test", "isostep "].iter().any(|begin| text.starts_with(begin))
}

/// The words of a command, as a shell has them.
fn words(text: &str) -> Vec<String> {
    let placeholder = |word: &str| {
        let word = word.trim_matches(['"', '\'']);
        let variables = word.split('/').map(|part| if part.starts_with('$') { "1" } else { part });
        let word = variables.collect::<Vec<_>>().join("/");
        PLACEHOLDERS.iter().find(|(name, _)| *name == word).map_or(word.clone(), |(_, value)| (*value).to_owned())
    };
    text.split_whitespace().map(placeholder).collect()
}

/// The arguments that the tool would be given, of a command that is a verb of it.
fn tool_words(text: &str) -> Option<Vec<String>> {
    let words = words(text);
    let from = match (words[0].as_str(), words.get(1).map(String::as_str)) {
        ("isostep", _) => 1,
        ("cargo", Some("xtask")) => 2,
        _ => words.iter().position(|word| word == "--").filter(|_| text.contains("-p isostep "))? + 1,
    };
    Some(words[from..].to_vec())
}

/// A command is one, by the parsers that would read it.
fn taken(text: &str) -> Result<(), String> {
    let words = words(text);
    if words[0] == "cargo" && words[1] != "xtask" {
        cargo(&words)?;
    }
    let Some(given) = tool_words(text) else { return Ok(()) };
    let parsed = if words[1] == "xtask" {
        crate::Cli::try_parse_from([vec!["cargo xtask".to_owned()], given].concat()).map(drop)
    } else {
        isostep::cli::Cli::try_parse_from([vec!["isostep".to_owned()], given].concat()).map(drop)
    };
    parsed.or_else(|answer| if answer.use_stderr() { Err(answer.to_string()) } else { Ok(()) })
}

/// The run or test exists: `cargo run` or `cargo test` finds what it names.
fn cargo(words: &[String]) -> Result<(), String> {
    let value = |names: &[&str]| {
        words
            .iter()
            .position(|word| names.contains(&word.as_str()))
            .and_then(|at| words.get(at + 1))
            .map(String::as_str)
    };
    let package = match value(&["-p", "--package"]) {
        Some(name) => package(name).ok_or(format!("there is no package {name}"))?,
        None => workspace::root().to_path_buf(),
    };
    let manifest = fs::read_to_string(package.join("Cargo.toml")).unwrap();
    for (option, folder) in [("--test", "tests"), ("--example", "examples")] {
        let Some(name) = value(&[option]) else { continue };
        let place = package.join(folder).join(name);
        let is_there = place.with_extension("rs").is_file() || place.join("main.rs").is_file();
        if !is_there {
            return Err(format!("{} has no {option} {name}", package.display()));
        }
    }
    // `chain::` chooses the tests of a file.
    let executable = package.join("tests").join(value(&["--test"]).unwrap_or("main")).with_extension("rs");
    if let Some(file) = words.iter().find_map(|word| word.strip_suffix("::"))
        && !fs::read_to_string(&executable).is_ok_and(|text| text.lines().any(|line| line == format!("mod {file};")))
    {
        return Err(format!("{} has no tests {file}::", executable.display()));
    }
    if let Some(feature) = value(&["--features"])
        && !manifest.lines().any(|line| line.starts_with(&format!("{feature} =")))
    {
        return Err(format!("{} has no feature {feature}", package.display()));
    }
    if words[1] == "run" && words.iter().any(|word| word == "-q" || word == "--quiet") {
        return Err("with -q nothing is said while it compiles, for a minute".to_owned());
    }
    Ok(())
}

/// The folder of a package of this workspace.
fn package(name: &str) -> Option<PathBuf> {
    let root = workspace::root();
    let folders = ["", "crates", "boards", "tests"].map(|folder| root.join(folder));
    let inside = folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    inside.into_iter().find(|folder| {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
        manifest.lines().any(|line| line == format!("name = \"{name}\""))
    })
}

/// A verb that is over in a moment, with the reader's files, and with what it writes in `folder`; `None` for others.
fn quick(words: &[String], folder: &Path) -> Option<Verb> {
    let is_quick = matches!(words.first().map(String::as_str), Some("sim" | "check" | "profile"))
        && words.len() > 1
        && !words.iter().any(|word| word == "--pty" || word.contains("FOLDER"));
    let mut given = vec!["isostep".to_owned()];
    for (index, word) in words.iter().enumerate().filter(|_| is_quick) {
        let is_written = index > 0 && WRITTEN.contains(&words[index - 1].as_str());
        let ours = READERS.iter().find(|(theirs, _)| theirs == word).map_or(word.as_str(), |(_, ours)| ours);
        let path = workspace::root().join(ours);
        let is_file = [".nc", ".txt"].iter().any(|end| ours.ends_with(end));
        // A file that the page has the reader make.
        if is_file && !is_written && !path.is_file() {
            return None;
        }
        let path = if is_written { folder.join(word) } else { path };
        given.push(if is_written || is_file { path.display().to_string() } else { word.clone() });
    }
    match isostep::cli::Cli::try_parse_from(given).ok()?.verb {
        isostep::cli::Verb::Shared(verb) if is_quick => Some(verb),
        _ => None,
    }
}
