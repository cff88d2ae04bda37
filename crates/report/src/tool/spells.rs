//! When a tool was on, and with which duty: the changes of its outputs as spells of constant duty.

use isostep_sim::tool::{ToolChange, ToolOutput};

/// A time in which an output is on and does not change.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Spell {
    /// When it begins, ns since power-up.
    pub begin_ns: u64,
    /// When it ends.
    pub end_ns: u64,
    /// Duty of the PWM output, from 0 to 1.
    pub duty_ratio: f64,
}

impl Spell {
    /// Its duration, s.
    pub fn span_s(&self) -> f64 {
        (self.end_ns - self.begin_ns) as f64 * 1e-9
    }
}

/// When the spindle was enabled or a laser on, up to `end_ns`. The spells are in order, and none is empty.
pub fn of_spindle(changes: &[ToolChange], is_laser: bool, end_ns: u64) -> Vec<Spell> {
    let (mut duty_ratio, mut enabled) = (0.0, false);
    let works = |duty_ratio: f64, enabled: bool| enabled && (duty_ratio > 0.0 || !is_laser);
    let mut spells = Vec::new();
    let mut begin_ns = 0;
    for change in changes {
        if works(duty_ratio, enabled) {
            add(&mut spells, Spell { begin_ns, end_ns: change.t_ns, duty_ratio });
        }
        begin_ns = change.t_ns;
        match change.output {
            ToolOutput::Pwm => duty_ratio = change.duty_ratio(),
            ToolOutput::Enable => enabled = change.duty > 0,
            _ => {}
        }
    }
    if works(duty_ratio, enabled) {
        add(&mut spells, Spell { begin_ns, end_ns, duty_ratio });
    }
    spells
}

/// Adds a spell. If it continues the last one with the same duty, they become one.
fn add(spells: &mut Vec<Spell>, spell: Spell) {
    match spells.last_mut() {
        _ if spell.begin_ns >= spell.end_ns => {}
        Some(last) if last.end_ns == spell.begin_ns && last.duty_ratio == spell.duty_ratio => {
            last.end_ns = spell.end_ns
        }
        _ => spells.push(spell),
    }
}

/// The time that an output was on, up to `end_ns`, s.
pub fn on_s(changes: &[ToolChange], output: ToolOutput, end_ns: u64) -> f64 {
    let mut since_ns = None;
    let mut total_ns = 0;
    for change in changes.iter().filter(|change| change.output == output) {
        total_ns += since_ns.take().map_or(0, |since_ns| change.t_ns - since_ns);
        since_ns = (change.duty > 0).then_some(change.t_ns);
    }
    total_ns += since_ns.map_or(0, |since_ns| end_ns.saturating_sub(since_ns));
    total_ns as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: u16 = u16::MAX;

    fn changes() -> Vec<ToolChange> {
        let change = |t_ns, output, duty| ToolChange { t_ns, output, duty };
        vec![
            change(1_000, ToolOutput::Enable, FULL),
            change(2_000, ToolOutput::Pwm, FULL),
            change(2_000, ToolOutput::Mist, FULL),
            change(5_000, ToolOutput::Pwm, 0),
            change(6_000, ToolOutput::Pwm, FULL),
            change(7_000, ToolOutput::Enable, 0),
        ]
    }

    fn spans(is_laser: bool) -> Vec<(u64, u64, f64)> {
        let spells = of_spindle(&changes(), is_laser, 9_000);
        spells.iter().map(|spell| (spell.begin_ns, spell.end_ns, spell.duty_ratio)).collect()
    }

    #[test]
    fn a_laser_shines_while_it_is_enabled_and_has_a_duty() {
        assert_eq!(spans(true), [(2_000, 5_000, 1.0), (6_000, 7_000, 1.0)]);
    }

    #[test]
    fn a_spindle_is_on_while_it_is_enabled() {
        let all = [(1_000, 2_000, 0.0), (2_000, 5_000, 1.0), (5_000, 6_000, 0.0), (6_000, 7_000, 1.0)];
        assert_eq!(spans(false), all);
    }

    #[test]
    fn what_stays_on_is_on_to_the_end() {
        assert!((on_s(&changes(), ToolOutput::Mist, 9_000) - 7e-6).abs() < 1e-12);
        assert!((on_s(&changes(), ToolOutput::Enable, 9_000) - 6e-6).abs() < 1e-12);
        assert_eq!(on_s(&changes(), ToolOutput::Flood, 9_000), 0.0);
    }
}
