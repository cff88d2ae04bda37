//! The promises of the pages for users are tested: `tests/promises.txt` names the tests of each promise, and here it is
//! compared with the pages and with the tests that there are. So no name of a test needs to stand in a page.
//!
//! The file has the path of a page, then its headings, each with lines `promise -> tests`. The promise is the first cell
//! of a row, or words of the section.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use isostep_architecture::{files, read, root};

/// A page all of whose tables promise something.
const WHOLE: &str = "docs/console.md";
/// Pages about tests, which name them.
const ABOUT_TESTS: [&str; 3] = ["docs/testing.md", "docs/figures.md", "docs/swarm.md"];

/// A line of the file.
struct Promise {
    page: String,
    heading: String,
    words: String,
    tests: Vec<String>,
}

fn promises() -> Vec<Promise> {
    let (mut page, mut heading) = (String::new(), String::new());
    let mut found = Vec::new();
    for line in read(&root().join("tests/promises.txt")).lines().filter(|line| !line.is_empty()) {
        if let Some(text) = line.strip_prefix("## ") {
            text.clone_into(&mut heading);
        } else if let Some((words, tests)) = line.split_once(" -> ") {
            let tests = tests.split(", ").map(str::to_owned).collect();
            found.push(Promise { page: page.clone(), heading: heading.clone(), words: words.to_owned(), tests });
        } else {
            line.clone_into(&mut page);
        }
    }
    assert!(found.len() > 250, "only {} promises were read", found.len());
    found
}

/// The names of all tests: functions with `#[test]`, also with `#[ignore]`, those that a macro lists to make tests of, and
/// dialogues that are text, each below a line `=== name`.
fn tests() -> BTreeSet<String> {
    let folders = ["crates", "boards", "tests", "xtask"].map(|folder| files(&root().join(folder)));
    let has = |path: &Path, extension: &str| path.extension().is_some_and(|other| other == extension);
    let in_file = |path: PathBuf| match &path {
        path if has(path, "rs") => tests_in(&read(path)),
        path if has(path, "txt") => dialogues_in(&read(path)),
        _ => Vec::new(),
    };
    folders.into_iter().flatten().flat_map(in_file).collect()
}

fn dialogues_in(text: &str) -> Vec<String> {
    text.lines().filter_map(|line| line.strip_prefix("=== ")).map(str::to_owned).collect()
}

fn tests_in(code: &str) -> Vec<String> {
    let behind = code.split("#[test]").skip(1).filter_map(|behind| behind.split_once("fn "));
    let functions = behind.filter_map(|(_, name)| name.split_once('(')).map(|(name, _)| name);
    let lists =
        code.split("macro_rules!").skip(1).flat_map(str::lines).filter_map(|line| line.trim().strip_suffix(','));
    functions.chain(lists).map(str::to_owned).collect()
}

/// The sections of a page with their headings, lines joined by a space; a table's rows stay lines.
fn sections(page: &str) -> Vec<(String, String)> {
    let text = format!("\n{}", read(&root().join(page)));
    let parts = text.split("\n#").skip(1).filter_map(|part| part.split_once('\n'));
    parts.map(|(heading, body)| (heading.trim_matches(['#', ' ']).to_owned(), body.to_owned())).collect()
}

/// The rows of a section's tables that promise something, by their first cell.
fn rows(body: &str) -> Vec<String> {
    let rows = body.lines().collect::<Vec<_>>();
    let is_head = |index: usize| rows.get(index + 1).is_some_and(|next| next.starts_with("|---"));
    let promised = rows
        .iter()
        .enumerate()
        .filter(|(index, row)| row.starts_with("| ") && !is_head(*index) && !row.contains(" | never: "));
    promised.filter_map(|(_, row)| row[2..].split(" | ").next()).map(|cell| cell.trim().to_owned()).collect()
}

#[test]
fn every_promise_has_a_test_that_exists() {
    let tests = tests();
    let gone = promises().into_iter().flat_map(|promise| {
        let gone: Vec<_> = promise.tests.into_iter().filter(|test| !tests.contains(test)).collect();
        gone.into_iter()
            .map(move |test| format!("{}, {}: `{}` has no test {test}\n", promise.page, promise.heading, promise.words))
    });
    let gone: String = gone.collect();
    assert!(gone.is_empty(), "\n{gone}mend tests/promises.txt, or write the test");
}

#[test]
fn every_promise_stands_in_its_page() {
    let gone: String = promises()
        .iter()
        .filter(|promise| !stands(promise))
        .map(|promise| format!("{}, {}: `{}`\n", promise.page, promise.heading, promise.words))
        .collect();
    assert!(gone.is_empty(), "tests/promises.txt has what its page does not say:\n{gone}");
}

fn stands(promise: &Promise) -> bool {
    let in_line = |body: &str| body.split_whitespace().collect::<Vec<_>>().join(" ").contains(&promise.words);
    let section = sections(&promise.page).into_iter().find(|(heading, _)| *heading == promise.heading);
    section.is_some_and(|(_, body)| rows(&body).contains(&promise.words) || in_line(&body))
}

/// A row without a test is a promise that nothing holds. Where one row of a section has tests, each is to have some.
#[test]
fn every_row_has_its_promise() {
    let promises = promises();
    let pages: BTreeSet<&str> = promises.iter().map(|promise| promise.page.as_str()).collect();
    let mut without = String::new();
    for page in pages {
        for (heading, body) in sections(page) {
            let listed: Vec<_> = promises.iter().filter(|one| one.page == page && one.heading == heading).collect();
            let is_listed = |row: &String| listed.iter().any(|promise| promise.words == *row);
            let rows = rows(&body);
            if page == WHOLE || rows.iter().any(is_listed) {
                let missing = rows.iter().filter(|row| !is_listed(row));
                without += &missing.map(|row| format!("{page}, {heading}: {row}\n")).collect::<String>();
            }
        }
    }
    assert!(without.is_empty(), "tests/promises.txt names no test of\n{without}");
}

#[test]
fn no_page_for_users_names_a_test() {
    let tests = tests();
    let pages = files(&root().join("docs")).into_iter().chain([root().join("README.md")]);
    let pages =
        pages.filter(|page| page.extension().is_some_and(|extension| extension == "md") && !is_about_tests(page));
    let named = pages.flat_map(|page| {
        let text = read(&page);
        let words = text.split('`').skip(1).step_by(2).filter(|word| word.contains('_') && tests.contains(*word));
        words.map(|word| format!("{}: {word}\n", page.display())).collect::<Vec<_>>()
    });
    let named: String = named.collect();
    assert!(named.is_empty(), "names of tests belong into tests/promises.txt:\n{named}");
}

fn is_about_tests(page: &Path) -> bool {
    ABOUT_TESTS.iter().any(|name| page.ends_with(name))
}

#[test]
fn a_test_is_found_and_another_function_is_not() {
    let code = "#[test]\nfn one() {\n}\n#[test]\n#[ignore = \"it is long\"]\nfn two() {\n}\nfn three() {}\n\
        macro_rules! all {\n() => { all! {\n four,\n } };\n}\n";
    assert_eq!(tests_in(code), ["one", "two", "four"]);
    assert_eq!(dialogues_in("# A page\n=== three\nsend ?\n"), ["three"]);
    assert_eq!(rows("| a | b |\n|---|---|\n| 1 | x |\n| 6 | never: it cannot be | |\n"), ["1"]);
}
