//! The line of the program that each move comes from, and what this line asks for, as the machine was asked for the move.

use isostep_console::{BlockMove, Command, Interpreter, Rate, ReportedState};
use isostep_motion::{Move, Power};

use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::program::{Program, stripped};

/// The origin of a move in the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Its line of the file, from 1.
    pub line: usize,
    /// The speed that the line asks for.
    pub rate: Rate,
    /// True if the line asks for an exact stop.
    pub exact_stop: bool,
    /// The farthest that a blend may leave the corner at its beginning, mm; 0 for none.
    pub deviation_mm: f64,
    /// True if it is a chord that is not the last of its arc. Its end is then not a corner of the program.
    pub in_arc: bool,
    /// The power of the laser during the move.
    pub power: Power,
}

impl Source {
    /// The source of a move that was asked for; `None` if no line did.
    pub fn of(asked: &Move, program: &Program) -> Option<Self> {
        let &Move { source, feed_mm_s, exact_stop, deviation_mm, power, in_arc, .. } = asked;
        let is_rapid = feed_mm_s == f64::INFINITY;
        let rate = if is_rapid { Rate::Rapid } else { Rate::Feed { mm_min: (feed_mm_s * 60.0) as f32 } };
        let deviation_mm = deviation_mm.into();
        (source > 0).then_some(Self {
            line: program.number(source as usize),
            rate,
            exact_stop,
            deviation_mm,
            in_arc,
            power,
        })
    }
}

/// A move, or the part of it that comes from one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// The index of its move in [`Outcome::moves`].
    pub index: usize,
    /// The place where it begins, steps of the longest axis from the beginning of the whole move.
    pub from_steps: f64,
    /// Its source; `None` for homing, probing, and the start-up lines.
    pub source: Option<Source>,
}

/// The source of each of [`Outcome::moves`]; of a move that is made for several lines, the first.
pub fn of_moves(outcome: &Outcome) -> Vec<Option<Source>> {
    outcome
        .moves
        .iter()
        .map(|record| record.asked.first().and_then(|asked| Source::of(asked, &outcome.program)))
        .collect()
}

/// All moves, divided where the lines begin that they are made for.
pub fn sections(outcome: &Outcome) -> Vec<Section> {
    outcome.moves.iter().enumerate().flat_map(|(index, record)| sections_of(index, record, &outcome.program)).collect()
}

fn sections_of<'o>(index: usize, record: &'o MoveRecord, program: &'o Program) -> impl Iterator<Item = Section> + 'o {
    let begin_steps = if record.blend.is_some() { 0.0 } else { record.plan.begin_steps() };
    let places_steps = std::iter::once(begin_steps).chain(record.marks_steps.iter().copied().map(f64::from));
    let sources = record.asked.iter().map(|asked| Source::of(asked, program)).chain(std::iter::repeat(None));
    places_steps.zip(sources).map(move |(from_steps, source)| Section { index, from_steps, source })
}

/// The lines that were sent and not refused, in order.
fn accepted_lines(outcome: &Outcome) -> impl Iterator<Item = &[u8]> {
    let mut refusals = outcome.refusals.iter().map(|refusal| refusal.sent_before).peekable();
    let sent = outcome.program.iter().enumerate().take(outcome.lines_sent);
    sent.filter(move |(index, _)| refusals.next_if_eq(index).is_none()).map(|(_, line)| line.as_slice())
}

/// True if the program sets steps/mm or anything that limits speed after its first move (homing is not a move).
pub fn sets_limits_on_the_way(outcome: &Outcome) -> bool {
    // Few programs set anything, and interpreting all lines takes time.
    if !accepted_lines(outcome).any(|text| text.contains(&b'$')) {
        return false;
    }
    let mut interpreter = Interpreter::new();
    let mut has_moved = false;
    accepted_lines(outcome).any(|text| {
        let Ok(line) = stripped(text) else { return false };
        let from_pm = interpreter.position_pm();
        match interpreter.interpret(&line, ReportedState::Idle, &outcome.config.settings) {
            Ok(Command::Block(block)) => {
                let moves = |motion: BlockMove| motion.arc.is_some() || motion.target_pm != from_pm;
                has_moved |= block.drills || block.via_pm.is_some() || block.motion.is_some_and(moves);
                false
            }
            Ok(Command::Jog(jog)) => {
                has_moved |= jog.target_pm != from_pm;
                interpreter.set_position_pm(jog.target_pm);
                false
            }
            Ok(Command::SetSetting { number, .. }) => has_moved && is_limit(number),
            _ => false,
        }
    })
}

/// True if the setting defines the length of a step, or limits the speed of a move or a corner.
fn is_limit(number: u16) -> bool {
    let of_axes = matches!(number, 100..=102 | 110..=112 | 120..=122 | 910..=912 | 920..=922 | 930..=932);
    of_axes || matches!(number, 11 | 900 | 940)
}

#[cfg(test)]
mod tests {
    use embassy_time::{Duration, Instant};
    use isostep_motion::Level;

    use super::*;
    use crate::{Config, Sim, run};

    fn sources(program: &str) -> Vec<Option<Source>> {
        of_moves(&run(program.as_bytes(), &Config::default()).unwrap())
    }

    fn lines(program: &str) -> Vec<Option<usize>> {
        sources(program).into_iter().map(|source| source.map(|source| source.line)).collect()
    }

    #[test]
    fn lines_that_move_nothing_are_passed_over() {
        assert_eq!(lines("G21\n; a comment\nG91 G1 X1 F600\nX0\n\nM5\nX-1 Y2\nG4 P0.1\nY-2\n"), [3, 7, 9].map(Some));
    }

    #[test]
    fn a_move_is_of_the_line_of_the_file_that_it_is_made_from() {
        let program = "G61 G91 F600\no1 repeat [2]\n#1=[#1+1]\nG1 X#1\no1 endrepeat\nY1\n";
        assert_eq!(lines(program), [4, 4, 6].map(Some));
        let mut pieces = crate::Streamed::new(Sim::new(&Config::default()), Program::read(program.as_bytes()).unwrap());
        pieces.run_until(Instant::from_secs(60)).unwrap();
        let found = of_moves(&pieces.take_piece()).into_iter().chain(of_moves(&pieces.end().unwrap()));
        assert_eq!(found.map(|source| source.map(|source| source.line)).collect::<Vec<_>>(), [4, 4, 6].map(Some));
    }

    #[test]
    fn a_refused_line_and_a_wait_are_of_the_line_of_the_file() {
        let outcome = run(b"#1=1\nG0 X#1\nM0\n#2=2\nD[#2]\n", &Config::default()).unwrap();
        assert_eq!((outcome.pauses[0].line, outcome.refusals[0].line, outcome.refusals[0].sent_before), (3, 5, 2));
        assert_eq!(of_moves(&outcome).len(), 1);
        let silenced = run(b"#1=1\n$SLP\n#2=2\nG0 X#2\n", &Config::default()).unwrap_err().to_string();
        assert!(silenced.starts_with("line 4 `G0 X2` was never answered, as line 2 `$SLP` "), "{silenced}");
    }

    #[test]
    fn lines_that_blends_join_are_told_apart() {
        let program = "G91 G64 P0.05 G1 X5 F600\nY5\nX1 Y1\nG2 X2 I1\nX3\n";
        let (found, exact) = (lines(program), lines(&program.replace("G64 P0.05", "G61")));
        assert_eq!(found[..3], [1, 2, 3].map(Some));
        assert_eq!((found.first(), found.last()), (exact.first(), exact.last()));
        assert!(found.iter().all(Option::is_some) && found.is_sorted(), "{found:?}");
    }

    #[test]
    fn a_refused_line_moves_nothing() {
        let program = "G0 X150\n$J=X10 F500\nG0 X10\nM2\n";
        let outcome = run(program.as_bytes(), &Config::default()).unwrap();
        assert_eq!(outcome.refusals.iter().map(|refusal| refusal.line).collect::<Vec<_>>(), [2], "in motion");
        let found = of_moves(&outcome).into_iter().map(|source| source.map(|source| (source.line, source.rate)));
        assert_eq!(found.collect::<Vec<_>>(), [1, 3].map(|line| Some((line, Rate::Rapid))));
    }

    #[test]
    fn a_move_asks_for_what_its_line_asks_for() {
        let found = sources("G0 X1\nG61.1 G1 X2 F600\nG61 G3 X3 I0.5\n");
        let asked = |source: &Option<Source>| source.map(|source| (source.rate, source.exact_stop, source.in_arc));
        let feed = Rate::Feed { mm_min: 600.0 };
        let (first, chords) = found.split_at(2);
        assert_eq!(
            first.iter().map(asked).collect::<Vec<_>>(),
            [Some((Rate::Rapid, false, false)), Some((feed, true, false))]
        );
        let (last, others) = chords.split_last().unwrap();
        assert_eq!(asked(last), Some((feed, false, false)));
        assert!(others.len() > 5 && others.iter().all(|chord| asked(chord) == Some((feed, false, true))), "{others:?}");
    }

    #[test]
    fn a_laser_shines_in_feed_moves_as_m3_m4_and_s_say() {
        let found =
            sources("G21 G91\nM3 S500\nG1 X1 F600\nG4 P0\n$32=1\nX1\nM3 X1\nG4 P0\n$30=2000\nM4 X1\nG0 X1\nM5 G1 X1\n");
        let level = |share| Level::of_ratio(share);
        let powers: Vec<_> = found.iter().map(|source| source.unwrap().power).collect();
        // A change of `$32` switches off what was a spindle.
        let expected =
            [Power::Off, Power::Off, Power::Constant(level(0.5)), Power::BySpeed(level(0.25)), Power::Off, Power::Off];
        assert_eq!(powers, expected);
    }

    #[test]
    fn one_move_for_several_lines_has_a_section_for_each() {
        let outcome =
            run(b"$32=1\nG21G91\nM4 S500 G1 F600 X-1\nX1\nX2 S0\nX1 S100\nY1\nM5\n", &Config::default()).unwrap();
        let found: Vec<_> = sections(&outcome)
            .iter()
            .map(|section| (section.index, section.from_steps, section.source.map(|source| source.line)))
            .collect();
        let expected = [(0, 0.0, 3), (1, 0.0, 4), (1, 50.0, 5), (1, 150.0, 6), (2, 0.0, 7)];
        assert_eq!(found, expected.map(|(index, from_steps, line)| (index, from_steps, Some(line))));
        let first = of_moves(&outcome).into_iter().map(|source| source.unwrap().line);
        assert_eq!(first.collect::<Vec<_>>(), [3, 4, 7]);
    }

    /// A blend leaves its corner, to which the line goes all the same.
    #[test]
    fn moves_that_meet_in_blends_are_of_their_lines() {
        let program = "G1 X10 F1200\nY10\nG2 X20 I5\nX0 Y0\n$H\n";
        let of =
            |lines: Vec<Option<usize>>| [1, 2, 3, 4].map(|line| lines.iter().filter(|at| **at == Some(line)).count());
        let [blended, exact] =
            [format!("G64 P0.3 {program}"), format!("G61 {program}")].map(|program| of(lines(&program)));
        // With blends an arc has fewer sides.
        assert_eq!((blended, exact), ([1, 1, 9, 0], [1, 1, 56, 0]));
    }

    #[test]
    fn the_chords_of_an_arc_and_both_moves_of_g28_are_of_one_line() {
        let found = lines("G0 X20\nG2 X20 I5 F1200\nG3 X10 I-5\nG28 Y1\n");
        assert_eq!(found.first(), Some(&Some(1)));
        let of = |line: usize| found.iter().filter(|each| **each == Some(line)).count();
        assert!(of(2) > 10 && of(3) > 5, "{found:?}");
        assert_eq!((of(4), found.len()), (2, 1 + of(2) + of(3) + 2));
    }

    /// It would be taken for all moves up to a later one that ends at the same place.
    #[test]
    fn an_arc_of_less_than_a_step_is_passed_over() {
        let program = "G1 X10 Y2 F1200\nG3 X10.0008 J0.5\nG1 Y5\nX0\nY2\nX10\nG2 X10 I0.5\nG2 X10.02 I0.01\n";
        for path in ["G61", "G64 P0.01"] {
            let mut found = lines(&format!("{path} {program}"));
            found.dedup();
            assert_eq!(found, [1, 3, 4, 5, 6, 7, 8].map(Some), "{path}");
        }
    }

    /// What blends leave of the second line is nothing but a way to the corner behind it.
    #[test]
    fn a_short_line_that_goes_straight_on_to_a_blend_is_found() {
        let program = "G64 P0.01 G1 X10 F600\nX10.04\nX10.08\nY1\nX10.12 Y1.04\nX10.16 Y1.08\nY0\n";
        assert_eq!(lines(program), [1, 2, 3, 4, 5, 6, 7].map(Some));
    }

    /// A place means another number of steps then.
    #[test]
    fn moves_after_a_change_of_the_steps_per_mm_are_of_their_lines() {
        let found = lines("G91 G1 X5 F600\nG4 P0\n$100=100\nX5\nX-2\n");
        assert_eq!(found, [1, 4, 5].map(Some));
    }

    #[test]
    fn each_setting_that_limits_speed_is_told_after_the_first_move() {
        let of_axes = [(100, 60), (110, 2_000), (120, 60), (910, 1), (920, 40), (930, 400)];
        let of_axes =
            of_axes.into_iter().flat_map(|(first, value)| (first..first + 3).map(move |number| (number, value)));
        let limits = of_axes.chain([(11, 1), (900, 1), (940, 1)]).map(|setting| (setting, true));
        for ((number, value), is_limit) in limits.chain([((1, 100), false), ((130, 300), false)]) {
            let told = |program: String| {
                let outcome = run(program.as_bytes(), &Config::default()).unwrap();
                assert!(outcome.refusals.is_empty(), "{program}: {:?}", outcome.refusals);
                sets_limits_on_the_way(&outcome)
            };
            assert_eq!(told(format!("G91 G1 X1 F600\nG4 P0\n${number}={value}\n")), is_limit, "${number}");
            assert!(!told(format!("${number}={value}\nG91 G1 X1 F600\n")), "${number} before it");
        }
    }

    /// It ends where no line says.
    #[test]
    fn a_jog_that_is_cancelled_is_of_its_line_and_so_is_what_follows() {
        let mut sim = Sim::new(&Config::default());
        sim.send(b"G21\n$J=G91 X30 F600\n$J=G91 X30 F600\n");
        sim.run_for(Duration::from_millis(500)).unwrap();
        sim.send(&[0x85]);
        sim.run_until_idle().unwrap();
        sim.send(b"G1 X40 F600\nG3 X45 I2.5\n");
        sim.run_until_idle().unwrap();
        let mut found: Vec<_> =
            of_moves(&sim.outcome()).into_iter().map(|source| source.map(|source| source.line)).collect();
        found.dedup();
        assert_eq!(found, [2, 4, 5].map(Some));
    }

    #[test]
    fn homing_is_of_no_line_and_moves_count_from_where_it_ends() {
        let found = lines("$H\nG90 G0 X10\nG91 G0 Y3\n");
        let homing = found.iter().filter(|line| line.is_none()).count();
        assert!(homing >= 9, "{found:?}");
        assert_eq!(found[homing..], [Some(2), Some(3)]);
    }
}
