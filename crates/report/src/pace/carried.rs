//! The pace at which the board carries a program: it plans no more than so many moves a second, and in virtual time planning
//! takes none.

use std::collections::VecDeque;

use isostep_motion::MOVES_AHEAD;

use isostep_sim::Outcome;

/// Short moves of three axes that the board carries out in a second, sent over USB: measured on the emulated board by
/// `cargo xtask bench --quick`; docs/figures.md.
pub const BOARD_MOVES_PER_S: f64 = 1_640.0;
/// Lines that go straight on with another power, each 0.1 mm, that it carries out in a second: measured in the same way.
const BOARD_PIXELS_PER_S: f64 = 3_230.0;

/// The time that the program takes longer than planned at least, because the board plans a move no faster than that, s. It
/// plans ahead while the machine moves, as far as it has room, so that a short burst of moves costs nothing. Where it
/// falls behind it also brakes, as fewer moves are known ahead: that is not counted.
pub fn longer_s(outcome: &Outcome) -> f64 {
    let mut begun_s = VecDeque::with_capacity(MOVES_AHEAD);
    let (mut planned_s, mut late_s) = (None, 0.0_f64);
    let lines = outcome.program_moves().flat_map(|record| {
        let marks = record.marks_steps.iter().map(|place_steps| {
            let begin_s = record.place_time_s(f64::from(*place_steps));
            (record.start_ns as f64 * 1e-9 + begin_s, 1.0 / BOARD_PIXELS_PER_S)
        });
        std::iter::once((record.begin_ns() as f64 * 1e-9, 1.0 / BOARD_MOVES_PER_S)).chain(marks)
    });
    for (due_s, cost_s) in lines {
        // A move can be planned when one before it has begun and so made room.
        let room_s = if begun_s.len() == MOVES_AHEAD { begun_s.pop_front() } else { None };
        let at_s = planned_s.map_or(due_s, |last_s: f64| last_s.max(room_s.unwrap_or(last_s)) + cost_s);
        planned_s = Some(at_s);
        late_s = late_s.max(at_s - due_s);
        begun_s.push_back(due_s + late_s);
    }
    late_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    fn longer(program: &str) -> f64 {
        let mut config = Config { only_time: true, ..Config::default() };
        config.settings.max_rate_mm_min = [12_000.0; 3];
        config.settings.accel_mm_s2 = [2_000.0; 3];
        config.settings.blend_deviation_mm = 0.0;
        longer_s(&run(program.as_bytes(), &config).unwrap())
    }

    #[test]
    fn moves_that_the_board_carries_cost_nothing() {
        assert_eq!(longer("G91 G1 F6000 X100\nX-100\n"), 0.0);
        assert_eq!(longer(&format!("G91 G1 F6000\n{}", "X0.1\n".repeat(1_500))), 0.0, "1,000 a second");
        let burst = format!("G91 G1 F6000 X50\n{}X50\n", "X0.02\n".repeat(60));
        assert_eq!(longer(&burst), 0.0, "planned during the long move before them");
    }

    /// 2,500 moves a second are asked for; the machine makes 2,000, and the board needs longer for each.
    #[test]
    fn moves_that_come_too_fast_take_as_long_as_their_planning() {
        let program = format!("G91 G1 F6000\n{}", "X0.04\n".repeat(5_000));
        let expected_s = 5_000.0 / BOARD_MOVES_PER_S - 5_000.0 * Config::default().least_times.straight_s;
        assert!((longer(&program) - expected_s).abs() < 0.05, "{} for {expected_s}", longer(&program));
    }
}
