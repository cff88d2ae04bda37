//! Prints the results of a check for people.

use isostep_report::check::{Row, fate, rows, without_dust};
use isostep_report::pace::LEAST_SHOWN_S;
use isostep_report::remarks;
use isostep_sim::AXES;

use super::look::{Checked, Machine};

/// The details of one program on each machine.
pub fn detail(checked: &Checked, all: bool) -> String {
    if let Some(why) = &checked.unreadable {
        return format!("{}: {why}\n", checked.program);
    }
    let mut text = String::new();
    for (index, on) in checked.on.iter().enumerate() {
        text += &format!("{}{} on {}\n", if index > 0 { "\n" } else { "" }, checked.program, on.machine);
        // One machine may refuse `$` lines that another accepts.
        let is_as_on_first = index > 0 && checked.on[0].check.survey.refused == on.check.survey.refused;
        let known = if is_as_on_first { fate(&on.check.survey, all).len() } else { 0 };
        rows(&on.check, all).iter().skip(known).for_each(|row| text += &lines(row));
    }
    text
}

/// The words under each name.
pub fn listing(rows: &[Row]) -> String {
    rows.iter().map(lines).collect()
}

fn lines(row: &Row) -> String {
    let places: String = row.places.iter().map(|place| format!("    {place}\n")).collect();
    format!("  {:<11}{}\n{places}", row.name, row.words)
}

/// A line for each of many programs.
pub fn table(checked: &[Checked], machines: &[Machine]) -> String {
    let folder = common_folder(checked);
    let name = |one: &Checked| one.program[folder.len()..].to_owned();
    let width = checked.iter().map(|one| name(one).chars().count()).max().unwrap_or(0).max("program".len());
    let mut text = format!("{:<width$} {:>7} {:>20} {:>20} {:>20}", "program", "lines", "X, mm", "Y, mm", "Z, mm");
    for machine in machines {
        text += &format!(" {:>11}", format!("{}, s", machine_name(machine, machines)));
    }
    text += "  refused, and what else is wrong\n";
    for one in checked {
        text += &format!("{:<width$} {}\n", name(one), cells(one));
    }
    text + "  X, Y, Z: where its moves are, from where it begins; *: without what is refused\n"
}

/// The folder that contains all programs, with the slash behind it; empty if they are in several folders.
fn common_folder(checked: &[Checked]) -> &str {
    let folder = |one: &'_ Checked| one.program.rfind('/').map_or(0, |slash| slash + 1);
    let Some(first) = checked.first() else { return "" };
    let common = &first.program[..folder(first)];
    if checked.iter().all(|one| one.program[..folder(one)] == *common) { common } else { "" }
}

fn machine_name(machine: &Machine, machines: &[Machine]) -> String {
    if machines.len() == 1 { "time".to_owned() } else { machine.name.clone() }
}

fn cells(one: &Checked) -> String {
    let Some(first) = one.on.first() else { return format!("{:>7} {}", "-", one.unreadable.as_deref().unwrap_or("-")) };
    let mut text = format!("{:>7}", first.check.survey.lines);
    for axis in 0..AXES {
        let extents = first.check.survey.extents_mm;
        let words = extents.map_or("-".to_owned(), |bounds| {
            let [low_mm, high_mm] = [bounds.low_mm, bounds.high_mm].map(|mm| without_dust(mm[axis]));
            format!("{low_mm:.2}..{high_mm:.2}")
        });
        text += &format!(" {words:>20}");
    }
    for on in &one.on {
        let mark = if on.check.survey.refused_total > 0 { "*" } else { " " };
        text += &format!(" {:>11}", on.check.time_s.map_or("-".to_owned(), |s| format!("{s:.3}{mark}")));
    }
    format!("{text}  {}", wrong(one))
}

fn wrong(one: &Checked) -> String {
    // A line that only one machine refuses is refused because of that machine's settings.
    let mut refused: Vec<String> = Vec::new();
    for on in one.on.iter().filter(|on| on.check.survey.refused_total > 0) {
        let words = remarks::by_word(&on.check.survey.refused_by_word);
        if !refused.contains(&words) {
            refused.push(words);
        }
    }
    let of_machines = one.on.iter().flat_map(|on| {
        let left = on
            .check
            .survey
            .outside
            .as_ref()
            .map(|outside| format!("leaves the travel of {} (line {})", on.machine, outside.line));
        let longer_s = on.check.pace.as_ref().map(|pace| pace.longer_on_board_s).filter(|s| *s >= LEAST_SHOWN_S);
        let longer = longer_s.map(|s| format!("the board takes {s:.3} s longer on {}", on.machine));
        let dark =
            remarks::dark_dwells(&on.check.survey).map(|_| format!("its laser is dark in dwells on {}", on.machine));
        let trouble = on.check.trouble.as_ref().map(|trouble| format!("on {}: {trouble}", on.machine));
        [left, longer, dark, trouble].into_iter().flatten()
    });
    let all: Vec<_> = refused.into_iter().chain(of_machines).collect();
    if all.is_empty() { "-".to_owned() } else { all.join("; ") }
}
