//! The pages for users name each setting, error and alarm that the machine has.

use std::collections::BTreeSet;
use std::fs;

use isostep_console::{AlarmCode, Error, SETTING_TABLE, Setting};
use isostep_tests::root;

/// The pages that say what settings do.
const PAGES: [&str; 5] = ["bring-up.md", "console.md", "moves.md", "speed-profiles.md", "tool.md"];

fn page(name: &str) -> String {
    fs::read_to_string(root().join("docs").join(name)).unwrap()
}

/// The numbers of the settings that a page names, alone or in a range: `$27`, or `$120`-`$122`.
fn settings_named(page: &str) -> BTreeSet<u16> {
    let mut named = BTreeSet::new();
    let mut last = None;
    for (between, text) in page.split('$').scan("", |before, part| {
        let digits = part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len());
        let found = (*before, &part[..digits]);
        *before = &part[digits..];
        Some(found)
    }) {
        let Ok(number) = text.parse::<u16>() else {
            last = None;
            continue;
        };
        let first = last.filter(|_| matches!(between, "`-`" | "-" | "` to `" | " to "));
        named.extend(first.unwrap_or(number)..=number);
        last = Some(number);
    }
    named
}

/// The numbers in the first cells of the rows below a heading, but of those that say "never".
fn rows(page: &str, heading: &str) -> BTreeSet<u8> {
    let (_, section) = page.split_once(&format!("\n## {heading}\n")).expect(heading);
    let section = section.split("\n## ").next().unwrap_or_default();
    let cells = section.lines().filter_map(|row| row.strip_prefix("| ")?.split_once(" | "));
    cells.filter(|(_, why)| !why.starts_with("never")).filter_map(|(number, _)| number.parse().ok()).collect()
}

#[test]
fn every_setting_is_in_a_page() {
    let named = settings_named(&PAGES.map(page).concat());
    let missing: Vec<_> =
        SETTING_TABLE.iter().flat_map(Setting::numbers).filter(|number| !named.contains(number)).collect();
    assert!(missing.is_empty(), "none of {PAGES:?} names {missing:?}");
}

#[test]
fn every_error_and_alarm_has_a_row() {
    let page = page("console.md");
    assert_eq!(rows(&page, "Errors"), Error::ALL.iter().map(|error| error.code()).collect());
    assert_eq!(rows(&page, "Alarms"), AlarmCode::ALL.iter().map(|alarm| alarm.code()).collect());
}
