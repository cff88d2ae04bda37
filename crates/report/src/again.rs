//! The same program once more, beside the run that was asked for: by the other rule at corners, blends where it was run by
//! Grbl's rule and Grbl's rule where it had blends; without shapers; or with each move made by itself.

use isostep_motion::{AXES, State};
use isostep_profile::SpeedProfile;

use isostep_sim::Outcome;
use isostep_sim::config::Config;
use isostep_sim::corners;
use isostep_sim::program::{Program, stripped};

/// The distance by which blends leave corners where neither `$904` nor `$11` says so, mm.
const DEVIATION_MM: f32 = 0.01;

/// The run once more: each line as `line` makes it, on the machine that `change` makes of its. None of a run with faults,
/// which come at an instant, and of one that did not reach its end.
fn again(outcome: &Outcome, change: impl FnOnce(&mut Config), line: fn(&[u8]) -> Vec<u8>) -> Option<(Program, Config)> {
    let is_whole = outcome.alarm_code.is_none() && outcome.state == State::Idle && !outcome.cut_short;
    if !is_whole || !outcome.config.faults.is_empty() {
        return None;
    }
    let mut config = Config { keep_waves: false, ..outcome.config.clone() };
    change(&mut config);
    let lines = outcome.program.iter().map(|text| line(text)).collect();
    Some((outcome.program.with_lines(lines), config))
}

/// The program and the machine that show how the loads swing without shapers; `None` if nothing was shaped, there is no
/// load, or the run cannot be made again.
pub fn unshaped(outcome: &Outcome) -> Option<(Program, Config)> {
    let is_shaped = outcome.moves.iter().any(|record| record.shaping.is_some());
    let has_load = outcome.config.springs.0.iter().any(Option::is_some);
    let change = |config: &mut Config| config.settings.shaper_kind = [0; AXES];
    (is_shaped && has_load).then(|| again(outcome, change, without_shaper))?
}

/// A line, empty if it sets the kind of a shaper.
fn without_shaper(line: &[u8]) -> Vec<u8> {
    let sets = |text: String| (950..950 + AXES).any(|number| text.starts_with(&format!("${number}=")));
    if stripped(line).is_ok_and(sets) { Vec::new() } else { line.to_vec() }
}

/// The program and the machine that show what the other rule would do, if it would do anything else: the outcome has blends,
/// or takes corners without a stop and could have blends there. `None` if the run cannot be made again.
///
/// Blends leave corners by `$904`; where that is 0, by `$11`.
pub fn other_rule(outcome: &Outcome) -> Option<(Program, Config)> {
    let has_blends = has_blends(outcome);
    if outcome.edges.is_empty() || !(has_blends || could_have_blends(outcome)) {
        return None;
    }
    let change = |config: &mut Config| {
        let settings = &mut config.settings;
        settings.blend_deviation_mm = match [settings.blend_deviation_mm, settings.junction_deviation_mm] {
            _ if has_blends => 0.0,
            [blend_mm, _] if blend_mm > 0.0 => blend_mm,
            [_, junction_mm] if junction_mm > 0.0 => junction_mm,
            _ => DEVIATION_MM,
        };
    };
    again(outcome, change, by_setting)
}

/// True if any corner is a blend.
fn has_blends(outcome: &Outcome) -> bool {
    outcome.moves.iter().any(|record| record.blend.is_some())
}

/// By which rule a run takes its corners.
pub struct Rule {
    /// True if it takes them by blends, where it can.
    pub blends: bool,
    /// Its name, and the setting that says how.
    pub name: String,
    /// True if the user has asked for this run.
    pub is_own: bool,
}

impl Rule {
    /// The rule of the user's run. If it has blends, its program says how far they may go, line by line.
    pub fn of(outcome: &Outcome) -> Self {
        let blends = has_blends(outcome);
        let name = if blends { "Blends (G64)".to_owned() } else { grbls(outcome) };
        Self { blends, name, is_own: true }
    }

    /// The rule of the run that [`other_rule`] asks for.
    pub fn of_other(outcome: &Outcome) -> Self {
        let deviation_mm = outcome.config.settings.blend_deviation_mm;
        let blends = deviation_mm > 0.0;
        let name = if blends { format!("Blends (G64 P{deviation_mm})") } else { grbls(outcome) };
        Self { blends, name, is_own: false }
    }

    /// The owner of the run, in words.
    pub fn whose(&self) -> &'static str {
        if self.is_own { "this run" } else { "for comparison" }
    }
}

fn grbls(outcome: &Outcome) -> String {
    format!("Grbl's rule (G61, $11={})", outcome.junction_deviation_mm as f32)
}

fn could_have_blends(outcome: &Outcome) -> bool {
    let starts_at_once = outcome.limits.iter().any(|limits| limits.start_speed_steps_s > 0.0);
    let jumps = corners::largest_jumps(outcome).into_iter().flatten();
    outcome.speed_profile == SpeedProfile::Trapezoid
        && !starts_at_once
        && jumps.map(|jump| jump.mm_s).sum::<f64>() > 0.001
}

/// A line with G64 alone where it says G61 or G64 P, and without a `$904` of its own, so that the setting at power-up
/// decides. G61.1 stays.
fn by_setting(line: &[u8]) -> Vec<u8> {
    let text = match stripped(line) {
        Ok(text) if text.starts_with("$904=") => return Vec::new(),
        Ok(text) if !text.starts_with('$') => text,
        _ => return line.to_vec(),
    };
    let words = words(&text);
    let blends = words.iter().any(|word| is(word, 'G', 64.0));
    if !blends && !words.iter().any(|word| is(word, 'G', 61.0)) {
        return line.to_vec();
    }
    let kept = words.into_iter().filter(|word| !(blends && word.starts_with('P')));
    kept.map(|word| if is(word, 'G', 61.0) { "G64" } else { word }).collect::<String>().into_bytes()
}

/// The program with no moves taken together (`Q0`). `deviation_mm` is `$904`, by which G64 alone leaves corners.
pub fn one_by_one(program: &Program, deviation_mm: f32) -> Program {
    let path = |inches: bool| {
        let (units, per_unit) = if inches { (20, 25.4) } else { (21, 1.0) };
        format!("G{units}G64P{}Q0", deviation_mm / per_unit).into_bytes()
    };
    let mut inches = false;
    let mut lines = vec![path(inches)];
    for line in program.iter() {
        let text = stripped(line).ok().filter(|text| !text.starts_with('$')).unwrap_or_default();
        let words = words(&text);
        let has =
            |letter: char, codes: &[f64]| words.iter().any(|word| codes.iter().any(|&code| is(word, letter, code)));
        inches = has('G', &[20.0]) || inches && !has('G', &[21.0]);
        let with_p = words.iter().any(|word| word.starts_with('P')) && !has('G', &[4.0, 10.0]);
        match has('G', &[64.0]) {
            true if with_p => {
                let kept = words.into_iter().filter(|word| !word.starts_with('Q'));
                lines.push(kept.chain(["Q0"]).collect::<String>().into_bytes());
            }
            true => {
                // Its other words are for what it asks for in the way that it sets.
                lines.push(path(inches));
                lines.push(words.into_iter().filter(|word| !is(word, 'G', 64.0)).collect::<String>().into_bytes());
            }
            false => {
                lines.push(line.clone());
                lines.extend(has('M', &[2.0, 30.0]).then(|| path(inches)));
            }
        }
    }
    lines.into()
}

/// True if a word is this letter with this number.
fn is(word: &str, letter: char, number: f64) -> bool {
    word.strip_prefix(letter).is_some_and(|text| text.parse() == Ok(number))
}

/// The words of a line without blanks: each a letter and its number.
fn words(text: &str) -> Vec<&str> {
    let starts = text.char_indices().filter(|(at, c)| *at == 0 || c.is_ascii_alphabetic()).map(|(at, _)| at);
    let mut starts: Vec<_> = starts.collect();
    starts.push(text.len());
    starts.windows(2).map(|ends| &text[ends[0]..ends[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::run;

    #[test]
    fn a_line_leaves_its_corners_to_the_setting() {
        for (line, expected) in [
            ("G1 X10 ; G61", "G1 X10 ; G61"),
            ("G64 P0.05 G1 X1 (G61)", "G64G1X1"),
            ("g61 x2", "G64X2"),
            ("G61.1 X2", "G61.1 X2"),
            ("G4 P0.5", "G4 P0.5"),
            ("G61 G4 P0.5", "G64G4P0.5"),
            ("$904=0.3", ""),
            ("$N0=G64 P1", "$N0=G64 P1"),
            ("$J=X10 F100", "$J=X10 F100"),
        ] {
            assert_eq!(String::from_utf8(by_setting(line.as_bytes())).unwrap(), expected, "{line}");
        }
    }

    #[test]
    fn one_by_one_every_g64_has_no_q() {
        let program = "G1 X1\nG64\nG20 G64 X1\ng64 p0.5 q.1 x2\nG64 G4 P2\nG61\nM30\nG21 G64 P1\n$N0=G64\nM02\n";
        let lines = one_by_one(&program.lines().map(|line| line.as_bytes().to_vec()).collect(), 0.0127);
        let [mm, inches] = ["G21G64P0.0127Q0", "G20G64P0.0005Q0"];
        let expected = format!(
            "{mm}\nG1 X1\n{mm}\n\n{inches}\nG20X1\nG64P0.5X2Q0\n{inches}\nG4P2\nG61\nM30\n{inches}\nG21G64P1Q0\n\
             $N0=G64\nM02\n{mm}"
        );
        assert_eq!(String::from_utf8(lines.join(&b'\n')).unwrap(), expected);
    }

    fn other(program: &str, change: fn(&mut Config)) -> Option<Outcome> {
        let mut config = Config::default();
        change(&mut config);
        let outcome = run(program.as_bytes(), &config).unwrap();
        let (lines, config) = other_rule(&outcome)?;
        Some(run(&lines.join(&b'\n'), &config).unwrap())
    }

    #[test]
    fn each_rule_has_the_other_beside_it() {
        let corner = "G1 X10 F1200\nY10\n";
        assert!(!has_blends(&other(corner, |_| {}).unwrap()));
        assert!(has_blends(&other(&format!("G61\n{corner}"), |_| {}).unwrap()));
        assert!(!has_blends(&other(&format!("G64 P0.1\n{corner}"), |_| {}).unwrap()));
        assert!(has_blends(&other(corner, |config| config.settings.blend_deviation_mm = 0.0).unwrap()));
    }

    #[test]
    fn without_a_corner_that_could_be_a_blend_there_is_no_other() {
        for program in ["G1 X10 F1200\nX20\n", "G61.1 G1 X10 F1200\nY10\n", "G1 X10 F1200\nG4 P0.1\nY10\n"] {
            assert!(other(program, |_| {}).is_none(), "{program}");
        }
        let corner = "G1 X10 F1200\nY10\n";
        assert!(other(corner, |config| config.settings.speed_profile = 2).is_none());
        assert!(other(corner, |config| config.faults = vec!["hold@0.1".parse().unwrap()]).is_none());
        assert!(other("G1 X10 F1200\nY10\nX-60\n", |_| {}).is_none());
    }
}
