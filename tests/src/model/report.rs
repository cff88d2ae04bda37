//! The reports of the machine, compared with those of the model.

use std::collections::BTreeMap;

use super::bench::Difference;
use super::machine::{Model, Place, State};
use super::words::ONE;

/// An inch, mm.
const INCH_MM: f64 = 25.4;
/// The room that is reported at rest: moves, and bytes.
const ROOM_AT_REST: &str = "79,128";

/// The fields that come when their value is another than the last that was told.
const TOLD_ON_CHANGE: [&str; 4] = ["WCS", "H", "T", "TLR"];

/// The values of the fields that the reports have had so far: some come only when they have changed.
#[derive(Clone, Debug, Default)]
pub struct Report {
    state: String,
    fields: BTreeMap<String, String>,
}

impl Report {
    /// Takes in all status reports that came.
    pub fn read(&mut self, heard: &[String]) {
        for line in heard {
            if let Some(report) = line.strip_prefix('<').and_then(|line| line.strip_suffix('>')) {
                self.take_in(report);
            }
        }
    }

    fn take_in(&mut self, report: &str) {
        let mut fields = report.split('|');
        self.state = fields.next().unwrap_or_default().to_owned();
        let sometimes = |name: &str| matches!(name, "WCO" | "Ov" | "A") || TOLD_ON_CHANGE.contains(&name);
        self.fields.retain(|name, _| sometimes(name));
        for field in fields {
            let (name, value) = field.split_once(':').unwrap_or((field, ""));
            if name == "Ov" {
                self.fields.remove("A");
            }
            self.fields.insert(name.to_owned(), value.to_owned());
        }
    }

    fn field(&self, name: &str) -> Result<&str, Difference> {
        self.fields.get(name).map(String::as_str).ok_or_else(|| format!("no {name} in {self:?}"))
    }
}

/// Compares a report at rest.
///
/// # Errors
/// The difference.
pub fn compare(report: &Report, model: &Model) -> Result<(), Difference> {
    let state = match model.state {
        State::Idle => "Idle",
        State::Check => "Check",
        State::Alarm(_) | State::Unfit => "Alarm",
    };
    same("state", &report.state, state)?;
    let zero = model.work_zero();
    let mask = model.settings.get(10) as i64;
    compare_place("WCO", report.field("WCO")?, zero, model)?;
    if mask & 1 == 1 {
        compare_place("MPos", report.field("MPos")?, model.carriage, model)?;
    } else {
        let place = std::array::from_fn(|axis| model.carriage[axis] - zero[axis]);
        compare_place("WPos", report.field("WPos")?, place, model)?;
    }
    same("Bf", report.fields.get("Bf").map_or("", String::as_str), if mask & 2 == 2 { ROOM_AT_REST } else { "" })?;
    let overrides = model.overrides.map(|percent| percent.to_string()).join(",");
    same("Ov", report.field("Ov")?, &overrides)?;
    compare_told_on_change(report, model)?;
    if model.state == State::Check {
        return Ok(());
    }
    let mut accessories = String::new();
    let mut modes = model.modes;
    if matches!(model.state, State::Alarm(_)) {
        modes.stop_tool();
    }
    if modes.speed == 0 {
        modes.spindle = 5;
    }
    for (is_on, letter) in [(modes.spindle == 3, 'S'), (modes.spindle == 4, 'C'), (modes.flood, 'F'), (modes.mist, 'M')]
    {
        accessories.extend(is_on.then_some(letter));
    }
    same("A", report.fields.get("A").map_or("", String::as_str), &accessories)?;
    let speed = modes.speed as f64 / ONE as f64 * model.overrides[2] as f64 / 100.0;
    let expected = if modes.spindle == 5 { 0.0 } else { speed.min(model.settings.get(30)) };
    let feed_and_speed = report.field("FS")?;
    let reported = numbers(feed_and_speed);
    if reported[0] != 0.0 || (reported[1] - expected).abs() > 1.5 {
        return Err(format!("FS:{feed_and_speed}, S {expected} expected"));
    }
    Ok(())
}

/// Compares the fields that come when they have changed: a value that is not the first after a reset must have been told.
fn compare_told_on_change(report: &Report, model: &Model) -> Result<(), Difference> {
    let homed = (0..3).map(|axis| u8::from(model.homed[axis]) << axis).sum::<u8>();
    let home = format!("{},{homed}", u8::from(homed == 7));
    let expected = [("WCS", model.modes.system_name(), "G54"), ("T", model.in_spindle.to_string(), "0")];
    for (name, value, first) in expected.iter().map(|(name, value, first)| (*name, value.as_str(), *first)) {
        same(name, report.fields.get(name).map_or(first, String::as_str), value)?;
    }
    same("TLR", report.fields.get("TLR").map_or("0", String::as_str), "0")?;
    if model.settings.get(22) == 0.0 {
        return Ok(());
    }
    same("H", report.fields.get("H").map_or("0,0", String::as_str), &home)
}

/// Compares the reply to `$G`.
///
/// # Errors
/// The difference.
pub fn compare_modes(heard: &[String], model: &Model) -> Result<(), Difference> {
    let line = heard.first().and_then(|line| line.strip_prefix("[GC:")?.strip_suffix(']'));
    let Some((modes, values)) = line.and_then(|line| line.split_once(" F")) else {
        return Err(format!("$G: {heard:?}"));
    };
    let expected = model.modes.listed();
    // Which words of the tool an alarm has ended shows once it is over.
    let without_tool = |codes: &str| codes.split(' ').filter(|code| !code.starts_with('M')).collect::<String>();
    if matches!(model.state, State::Alarm(_)) {
        same("$G", &without_tool(modes), &without_tool(&expected))?;
    } else {
        same("$G", modes, &expected)?;
    }
    let inches = model.settings.get(13) != 0.0;
    let (feed, speed) = values.split_once(" S").ok_or_else(|| format!("$G: {heard:?}"))?;
    let (feed, speed): (f64, f64) = (feed.parse().unwrap_or(-1.0), speed.parse().unwrap_or(-1.0));
    let expected = model.modes.feed as f64 / ONE as f64 / if inches { INCH_MM } else { 1.0 };
    let is_same = (feed - expected).abs() < 0.51 && (speed - model.modes.speed as f64 / ONE as f64).abs() < 0.51;
    if is_same { Ok(()) } else { Err(format!("{heard:?}, F{expected} S{} expected", model.modes.speed / ONE)) }
}

/// Compares the reply to `$#`.
///
/// # Errors
/// The difference.
pub fn compare_parameters(heard: &[String], model: &Model) -> Result<(), Difference> {
    let mut expected: Vec<(String, Place)> = Vec::new();
    let names = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];
    expected.extend(names.iter().map(ToString::to_string).zip(model.systems));
    expected.extend([28, 30].into_iter().zip(model.places).map(|(number, place)| (format!("G{number}"), place)));
    expected.push(("G92".to_owned(), model.shift));
    let tools_at = expected.len();
    if heard.len() != tools_at + model.tools.len() + 3 {
        return Err(format!("$#: {heard:?}"));
    }
    for (line, (name, place)) in heard.iter().zip(expected) {
        let value = line.strip_prefix(&format!("[{name}:")).and_then(|line| line.strip_suffix(']'));
        compare_place(&name, value.ok_or_else(|| format!("{line}, {name} expected"))?, place, model)?;
    }
    let value = |line: &String, begins: &str| {
        let value = line.strip_prefix(begins).and_then(|line| line.strip_suffix(']'));
        value.map(str::to_owned).ok_or_else(|| format!("{line}, {begins} expected"))
    };
    let tools = &heard[tools_at..];
    for (line, (number, tool)) in tools.iter().zip(&model.tools) {
        let entry = value(line, &format!("[T:{number}|"))?;
        let [place, radius] = entry.split('|').collect::<Vec<_>>()[..] else { return Err(line.clone()) };
        compare_place("T", place, [0, 0, tool.length], model)?;
        compare_place("R", &format!("{radius},0,0"), [tool.radius, 0, 0], model)?;
    }
    let tools = &tools[model.tools.len()..];
    let length = value(&tools[0], "[TLO:")?;
    compare_place("TLO", &format!("{length},0,0"), [model.tool_length, 0, 0], model)?;
    let probed = value(&tools[1], "[PRB:")?;
    let (place, touched) = probed.rsplit_once(':').ok_or_else(|| probed.clone())?;
    same("PRB", touched, if model.probed.1 { "1" } else { "0" })?;
    compare_place("PRB", place, model.probed.0, model)
}

/// Compares the three coordinates of a place. They may be away by half a step and by half of the last digit.
fn compare_place(name: &str, reported: &str, place: Place, model: &Model) -> Result<(), Difference> {
    let inches = model.settings.get(13) != 0.0;
    for (axis, number) in numbers(reported).into_iter().enumerate() {
        let (reported_mm, digit_mm) = if inches { (number * INCH_MM, 1e-4 * INCH_MM) } else { (number, 1e-3) };
        let half_step_mm = match name {
            "MPos" | "WPos" | "PRB" => 0.5 / model.settings.get(100 + axis as u16),
            _ => 0.0,
        };
        let expected_mm = place[axis] as f64 / ONE as f64;
        if (reported_mm - expected_mm).abs() > half_step_mm + 0.51 * digit_mm + 1e-4 {
            return Err(format!("{name}:{reported}, {place:?} expected"));
        }
    }
    Ok(())
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(',').map(|number| number.parse().unwrap_or(f64::NAN)).collect()
}

fn same(what: &str, is: &str, expected: &str) -> Result<(), Difference> {
    if is == expected { Ok(()) } else { Err(format!("{what} is {is:?}, {expected:?} expected")) }
}
