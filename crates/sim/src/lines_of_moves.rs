//! Which line of the program each move is of. No move says so: the lines are read again, and moves are told by where they
//! end.

use std::ops::Range;

use isostep_console::{Command, Interpreter, LineAssembler, State};
use isostep_motion::{AXES, whole_steps};

use crate::outcome::Outcome;
use crate::stream::Speaker;

/// Of each of [`Outcome::moves`] the line, from 1. `None` for homing, and where moves end elsewhere than their lines say:
/// after a program that changes `$100`, or in which a jog was cancelled.
pub fn of_moves(outcome: &Outcome) -> Vec<Option<usize>> {
    let mut reader =
        Reader { outcome, interpreter: Interpreter::new(), next: 0, lines: vec![None; outcome.moves.len()] };
    let sent = outcome.transcript.iter().filter(|said| said.speaker == Speaker::Sender);
    for (number, said) in (1..).zip(sent) {
        reader.read(number, &said.text);
    }
    reader.lines
}

struct Reader<'a> {
    outcome: &'a Outcome,
    interpreter: Interpreter,
    /// The first move whose line has not been read.
    next: usize,
    lines: Vec<Option<usize>>,
}

impl Reader<'_> {
    fn read(&mut self, number: usize, text: &str) {
        let mut assembler = LineAssembler::new();
        for byte in text.bytes() {
            let _ = assembler.push(byte);
        }
        let Some(Ok(line)) = assembler.push(b'\n') else { return };
        match self.interpreter.interpret(line, State::Idle, &self.outcome.config.settings) {
            Ok(Command::Block(block)) => {
                let via = block.via_mm.map(|target_mm| (target_mm, false));
                let motion = block.motion.map(|motion| (motion.target_mm, motion.arc.is_some()));
                for (target_mm, is_arc) in via.into_iter().chain(motion) {
                    self.take(number, target_mm, is_arc);
                }
            }
            Ok(Command::Jog(jog)) => {
                self.take(number, jog.target_mm, false);
                self.interpreter.set_position_mm(jog.target_mm);
            }
            Ok(Command::Home { .. }) => self.home(),
            _ => {}
        }
    }

    /// The moves up to the first that ends there are of this line: one, or the chords of an arc.
    fn take(&mut self, number: usize, target_mm: [f32; AXES], is_arc: bool) {
        let steps_per_mm = self.outcome.steps_per_mm;
        let target_steps: [i32; AXES] =
            std::array::from_fn(|axis| whole_steps(target_mm[axis].into(), steps_per_mm[axis]));
        let left = &self.outcome.moves[self.next..];
        // A straight way to where it stands is no move.
        let is_there = left.first().is_none_or(|record| record.origin_steps == target_steps);
        if is_there && !is_arc {
            return;
        }
        if let Some(others) = left.iter().position(|record| record.end_steps == target_steps) {
            let own: Range<usize> = self.next..self.next + others + 1;
            self.next = own.end;
            self.lines[own].fill(Some(number));
        }
    }

    /// What follows begins where homing has left the machine.
    fn home(&mut self) {
        let moves = &self.outcome.moves;
        while moves.get(self.next).is_some_and(|record| record.homing) {
            self.next += 1;
        }
        if let Some(record) = moves.get(self.next) {
            self.interpreter.set_position_mm(self.outcome.mm(record.origin_steps).map(|mm| mm as f32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Config, run};

    fn lines(program: &str) -> Vec<Option<usize>> {
        of_moves(&run(program.as_bytes(), &Config::default()).unwrap())
    }

    #[test]
    fn lines_that_move_nothing_are_passed_over() {
        assert_eq!(lines("G21\n; a comment\nG91 G1 X1 F600\nX0\n\nM5\nX-1 Y2\nG4 P0.1\nY-2\n"), [3, 7, 9].map(Some));
    }

    #[test]
    fn the_chords_of_an_arc_and_both_moves_of_g28_are_of_one_line() {
        let found = lines("G0 X20\nG2 X20 I5 F1200\nG3 X10 I-5\nG28 Y1\n");
        assert_eq!(found.first(), Some(&Some(1)));
        let of = |line: usize| found.iter().filter(|each| **each == Some(line)).count();
        assert!(of(2) > 10 && of(3) > 5, "{found:?}");
        assert_eq!((of(4), found.len()), (2, 1 + of(2) + of(3) + 2));
    }

    #[test]
    fn homing_is_of_no_line_and_moves_count_from_where_it_ends() {
        let found = lines("$H\nG90 G0 X10\nG91 G0 Y3\n");
        let homing = found.iter().filter(|line| line.is_none()).count();
        assert!(homing >= 9, "{found:?}");
        assert_eq!(found[homing..], [Some(2), Some(3)]);
    }
}
