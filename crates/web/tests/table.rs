//! The table from which a form of settings is made.

use std::collections::BTreeSet;

use isostep_sim::{Config, settings};
use isostep_web::table::{Kind, Row, refusal, rows};

fn row(number: u16) -> Row {
    rows().into_iter().find(|row| row.number == number).unwrap()
}

fn options(number: u16) -> Vec<(u16, String)> {
    row(number).options
}

#[test]
fn defaults_are_those_of_the_machine_and_work_together() {
    let lines: String = rows().iter().map(|row| format!("${}={}\n", row.number, row.default)).collect();
    let Config { port, driver, settings: expected, .. } = Config::default();
    assert_eq!(settings::read("defaults", lines.as_bytes(), port, driver), Ok(expected));
    assert_eq!(refusal(&lines), None);
}

#[test]
fn every_row_has_a_name_and_a_value_in_its_range() {
    let rows = rows();
    let numbers: BTreeSet<_> = rows.iter().map(|row| row.number).collect();
    assert_eq!(numbers.len(), rows.len());
    for row in &rows {
        let value: f32 = row.default.parse().unwrap();
        assert!((row.min..=row.max).contains(&value), "{row:?}");
        assert!(!row.name.is_empty() && !row.name.contains("mask:"), "{row:?}");
        assert_eq!(matches!(row.kind, Kind::Mask | Kind::Choice), !row.options.is_empty(), "{row:?}");
    }
}

#[test]
fn a_mask_has_all_its_bits_and_a_choice_all_its_values() {
    for row in rows() {
        let values: u16 = row.options.iter().map(|(value, _)| value).sum();
        match row.kind {
            Kind::Mask => assert_eq!(f32::from(values), row.max, "{row:?}"),
            Kind::Choice => assert_eq!(row.options.len() as f32, row.max - row.min + 1.0, "{row:?}"),
            Kind::Switch => assert_eq!((row.min, row.max), (0.0, 1.0), "{row:?}"),
            Kind::Whole | Kind::Number => {}
        }
    }
}

#[test]
fn rows_are_entered_by_what_they_are() {
    let words = |pairs: &[(u16, &str)]| pairs.iter().map(|&(value, word)| (value, word.to_owned())).collect::<Vec<_>>();
    assert_eq!(row(20).kind, Kind::Switch);
    assert_eq!(row(3).kind, Kind::Mask);
    assert_eq!(options(3), words(&[(1, "X"), (2, "Y"), (4, "Z")]));
    assert_eq!(options(6), words(&[(1, "contact is high"), (2, "no pull-up")]));
    assert_eq!(row(900).kind, Kind::Choice);
    assert_eq!(options(900), words(&[(0, "fastest"), (1, "thirds")]));
    assert_eq!((row(901).kind, row(901).remark.as_str()), (Kind::Whole, "1 X, 2 Y, 3 Z"));
    let top_of_y = row(111);
    assert_eq!((top_of_y.name.as_str(), top_of_y.unit, top_of_y.kind), ("Y top speed", "mm/min", Kind::Number));
    assert_eq!((row(11).name.as_str(), row(11).remark.as_str()), ("junction deviation", "0 stops at every corner"));
}

#[test]
fn settings_that_do_not_work_together_are_refused_whatever_their_order() {
    assert_eq!(refusal("$31=2000\n$30=3000\n"), None);
    let refused = refusal("$30=2000\n$31=3000\n").unwrap();
    assert_eq!(refused.line, Some(2));
    assert!(refused.words.contains("lower $31 or raise $30"), "{refused}");
    assert!(refusal("$110=-5\n").unwrap().words.contains("is negative"));
    assert_eq!(refusal("$110=60000\n$100=1000\n"), None, "another board may carry that");
}
