//! Judges a run: which lines were refused, where a person would have had to act, and whether every promise was kept.

use std::collections::BTreeMap;

use anyhow::{Result, bail, ensure};
use isostep_report::Figures;
use isostep_report::survey::stopping_word;
use isostep_sim::stream::{Pause, Refusal};
use isostep_sim::{ConsoleError, Outcome};

use isostep_report::remarks::{self, SHOWN_MAX, meaning, shortened};

/// The error code for G-code in Alarm.
const LOCKED: u8 = ConsoleError::Locked.code();

/// Prints where the program waited for a person, and which lines were refused.
pub fn print(outcome: &Outcome) {
    if !outcome.pauses.is_empty() {
        println!("\nwaiting for a person: here it was resumed at once, as by ~");
        reported(&outcome.pauses, |pause| format!("  {}", pause_words(pause)));
    }
    let probes = remarks::probes(outcome);
    if !probes.is_empty() {
        println!("\nprobed");
        probes.iter().for_each(|probe| println!("  {probe}"));
    }
    if !outcome.refusals.is_empty() {
        println!("\nrefused");
        print!("{}", refused(outcome));
    }
}

/// Prints the first ten, and how many more there are.
fn reported<T>(all: &[T], words: impl Fn(&T) -> String) {
    all.iter().take(SHOWN_MAX).for_each(|one| println!("{}", words(one)));
    if all.len() > SHOWN_MAX {
        println!("  and {} more", all.len() - SHOWN_MAX);
    }
}

fn pause_words(pause: &Pause) -> String {
    let Pause { line, text, t_ns, words, comment } = pause;
    let words = words.as_ref().map_or(String::new(), |words| format!(": {words}"));
    let comment = comment.as_ref().map_or(String::new(), |comment| format!(" ({comment})"));
    format!("line {line} `{}`{comment} at {:.3} s{words}", shortened(text), *t_ns as f64 * 1e-9)
}

/// The refused lines in words. Up to a number, each line is listed with its own remedy; the others are counted by word.
/// The last line says what was carried out after the first refusal, because it had been sent already.
fn refused(outcome: &Outcome) -> String {
    let (own, locked): (Vec<&Refusal>, Vec<_>) = outcome.refusals.iter().partition(|refusal| is_own(refusal, outcome));
    let mut text = String::new();
    for refusal in own.iter().take(SHOWN_MAX) {
        text += &format!("  line {} `{}`: {}\n", refusal.line, shortened(&refusal.text), why(refusal));
    }
    if own.len() > SHOWN_MAX {
        let mut counts = BTreeMap::new();
        for refusal in &own[SHOWN_MAX..] {
            let word = stopping_word(&refusal.text).unwrap_or_else(|| format!("error:{}", refusal.code));
            *counts.entry(word).or_default() += 1;
        }
        text += &format!("  and {} more: {}\n", own.len() - SHOWN_MAX, remarks::by_word(&counts));
    }
    if !locked.is_empty() {
        let first = locked[0].line;
        text +=
            &format!("  {} from line {first} on, as the machine was locked by then (error:9)\n", lines(locked.len()));
    }
    text + &own.first().map_or(String::new(), |first| carried_on(outcome, first))
}

/// A line was refused for its own text or for a jog before it, and not because an alarm had locked the machine.
fn is_own(refusal: &Refusal, outcome: &Outcome) -> bool {
    refusal.code != LOCKED || refusal.words.is_some() || outcome.alarm_code.is_none()
}

/// Says which lines were carried out after the first refusal. A sender that counts characters has sent more lines
/// before it receives the refusal.
fn carried_on(outcome: &Outcome, first: &Refusal) -> String {
    let refused = outcome.refusals.iter().filter(|refusal| refusal.sent_before > first.sent_before).count();
    match outcome.lines_sent - (first.sent_before + 1) - refused {
        0 => "  no line behind it was carried out\n".to_owned(),
        carried_out => format!(
            "  {} up to line {} had been sent by then and {} carried out: the machine stands where {} took it\n",
            lines(carried_out),
            outcome.program.number(outcome.lines_sent),
            if carried_out == 1 { "was" } else { "were" },
            if carried_out == 1 { "it" } else { "they" },
        ),
    }
}

fn lines(count: usize) -> String {
    format!("{count} line{}", if count == 1 { "" } else { "s" })
}

/// The machine's message about this very line. If there is none, the meaning of the error code.
fn why(refusal: &Refusal) -> String {
    let words = refusal.words.clone().unwrap_or_else(|| meaning(refusal.code));
    format!("error:{} {words}", refusal.code)
}

/// Returns success only for a run that kept every promise.
pub fn judge(figures: &Figures, outcome: &Outcome) -> Result<()> {
    let program = &figures.program;
    let place = |refusal: &Refusal| format!("{program}:{}: `{}`", refusal.line, shortened(&refusal.text));
    if let Some(code) = figures.alarm {
        // If a line raised the alarm, the message names that line.
        let raised = outcome.refusals.iter().find(|refusal| refusal.code == LOCKED && refusal.words.is_some());
        let place = raised.map_or(program.clone(), place);
        let words =
            raised.and_then(|refusal| refusal.words.as_ref()).map_or(String::new(), |words| format!(" ({words})"));
        match outcome.alarm() {
            Some(alarm) => bail!("{place}: ALARM:{code}: {alarm}{words}"),
            None => bail!("{place}: ALARM:{code} on the way, which the program has left{words}"),
        }
    }
    if let Some(refusal) = outcome.refusals.first() {
        let place = place(refusal);
        bail!("{place} was refused: {}; `isostep check {program}` lists every line that is", why(refusal));
    }
    let broken = figures.broken().count();
    ensure!(broken == 0, "{broken} of {} checks failed", figures.verdicts.len());
    Ok(())
}

#[cfg(test)]
mod tests {
    use isostep_sim::{Config, run};

    use super::*;

    fn outcome(program: &str) -> Outcome {
        run(program.as_bytes(), &Config::default()).unwrap()
    }

    fn verdict(outcome: &Outcome) -> String {
        judge(&Figures::new("my.nc", outcome), outcome).unwrap_err().to_string()
    }

    #[test]
    fn each_refused_line_has_its_own_remedy_and_what_was_sent_behind_it_is_reported() {
        let outcome = outcome("$100=-5\nG0 X1 X2\n$132=20000\nG0 X2\nG0 X3\n");
        let reported = [
            "  line 1 `$100=-5`: error:4 $100=-5 is negative: give 0 or more\n",
            "  line 2 `G0 X1 X2`: error:25 A word stands twice on the line: keep one.\n",
            "  line 3 `$132=20000`: error:2 $132=20000 is above the most, 10000 mm: lower it\n",
            "  2 lines up to line 5 had been sent by then and were carried out: the machine stands where they took it\n",
        ];
        assert_eq!(refused(&outcome), reported.concat());
        assert_eq!(outcome.position_mm[0], 3.0);
        let expected = "my.nc:1: `$100=-5` was refused: error:4 $100=-5 is negative: give 0 or more; `isostep check my.nc` \
                        lists every line that is";
        assert_eq!(verdict(&outcome), expected);
    }

    #[test]
    fn lines_are_those_of_the_file() {
        let outcome = outcome("G91\no1 repeat [2]\nD1\nG0 X[#1+1]\no1 endrepeat\n");
        let reported = refused(&outcome);
        assert!(reported.starts_with("  line 3 `D1`: error:20 D: "), "{reported}");
        let behind = "  2 lines up to line 4 had been sent by then and were carried out: the machine stands where they took it\n";
        assert!(reported.ends_with(behind), "{reported}");
        assert!(verdict(&outcome).starts_with("my.nc:3: `D1` was refused"), "{}", verdict(&outcome));
    }

    #[test]
    fn refusals_that_follow_from_an_alarm_are_counted() {
        let outcome = outcome("$H\nG0 X5\nG0 X-20\nG0 X6\nG0 X7\n");
        let reported = refused(&outcome);
        assert!(
            reported.starts_with("  line 3 `G0 X-20`: error:9 X-20.000 is outside the travel, 0.000 to 350.000 mm"),
            "{reported}"
        );
        assert!(reported.contains("  2 lines from line 4 on, as the machine was locked"), "{reported}");
        assert!(reported.ends_with("  no line behind it was carried out\n"), "{reported}");
        assert!(verdict(&outcome).contains("ALARM:2: "), "{}", verdict(&outcome));
    }

    /// The alarm is raised at the switch, 35 mm away, in the middle of the move of line 1.
    #[test]
    fn an_alarm_that_no_line_is_to_blame_for_names_none() {
        let outcome = outcome("G0 X-60\nG0 X1\nM2\n");
        let reported = refused(&outcome);
        assert!(
            reported.contains(" from line ") && reported.contains("locked") && !reported.contains("carried out"),
            "{reported}"
        );
        assert!(verdict(&outcome).starts_with("my.nc: ALARM:1: X limit switch closed"), "{}", verdict(&outcome));
    }

    #[test]
    fn an_alarm_is_not_the_fault_of_a_line_refused_before() {
        let outcome = outcome("G42\nG0 X-60\nM2\n");
        assert!(verdict(&outcome).starts_with("my.nc: ALARM:1: X limit switch closed"), "{}", verdict(&outcome));
        let left = self::outcome("G0 X-40\nG4 P0.1\n$H\nG0 X5\n");
        assert!(verdict(&left).starts_with("my.nc: ALARM:1 on the way"), "{}", verdict(&left));
    }

    #[test]
    fn what_a_jog_keeps_out_is_no_alarm() {
        let outcome = outcome("$J=X10 F500\nG4 P0.1\nM2\n");
        assert!(refused(&outcome).starts_with("  line 2 `G4 P0.1`: error:9 "), "{}", refused(&outcome));
        assert!(verdict(&outcome).starts_with("my.nc:2: `G4 P0.1` was refused: error:9 "), "{}", verdict(&outcome));
    }

    #[test]
    fn many_refusals_are_counted_by_word() {
        let reported = refused(&outcome(&"G41\nM9.5\n".repeat(9)));
        assert_eq!(reported.lines().count(), SHOWN_MAX + 2, "{reported}");
        assert!(reported.contains("line 1 `G41`: error:20 G41: no cutter compensation"), "{reported}");
        assert!(reported.contains("\n  and 8 more: G41 x 4, M9.5 x 4\n"), "{reported}");
    }

    #[test]
    fn a_program_is_resumed_where_it_waits_for_a_person() {
        let outcome = outcome("G0 X5\nM0 (look)\nG0 X6\nM2\n");
        let words: Vec<_> = outcome.pauses.iter().map(pause_words).collect();
        assert_eq!(words.len(), 1);
        assert!(words[0].starts_with("line 2 `M0` at 0."), "{words:?}");
        assert_eq!(outcome.position_mm[0], 6.0);
        judge(&Figures::new("my.nc", &outcome), &outcome).unwrap();
        let outcome = self::outcome("(T2 D=6 flat)\nG0 X5\nT2 M6\nM2\n");
        let words = pause_words(&outcome.pauses[0]);
        assert!(words.starts_with("line 3 `T2 M6` (D=6 flat) at ") && words.contains(": M6: put in tool 2"), "{words}");
    }
}
