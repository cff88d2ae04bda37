//! Arbitrary input: every line gets one answer, and an error changes nothing.

use isostep_console::{
    AlarmCode, Command, Error, Interpreter, LineAssembler, MAX_COORDINATE_PM, Realtime, Refusal, ReportedState,
    SETTING_TABLE, Settings, Unfit, realtime, report, stopped_at,
};
use isostep_trials::cases;
use proptest::prelude::*;

/// Parts to build lines from, valid and invalid.
const FRAGMENTS: &str = "G M N G0 G1 G1 G2 G3 G4 G10 G17 G18 G20 G21 G28 G28.1 G30 G38.2 G38.3 G38.5 G38.6 G43.1 G49 G53 G54 G59 G59.1 G80 \
    G90 G91 G91.1 G92 G92.1 G93 G94 M0 M1 M2 M3 M4 M6 M7 M8 M9 M30 X X1 Y-2.5 Z.5 X10000 Z-9999 F100 F S1 T1 T300 P1 P9 L2 L20 R2 \
    G43 G64 G42 A B0 H1 I1 R-9 J-3 K.5 G61 G61.1 N7 N10000001 A1 $ $$ $# $G $I $N $N0= $N1= $N2= $X $H $C $SLP $BOOT $PROVE $PROVE= $RST= * # $J= \
    $J=G91X1F100 $J $E $E22 $A1 $A99 $100= $110=1e9 $20=1 $22=0 $13=1 $6=3 $30=1 $31=1 $31=999 $35=9 $36=1 $902=1 = - + . 0 1 99999999 123456789 ( ) ; / % (note) g1x1f9 e q ? ! ~ \x00 \x18 \x7F \
    XXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXXX";

fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let fragments: Vec<_> = FRAGMENTS.split(' ').map(str::as_bytes).collect();
    let fragment = prop_oneof![
        38 => prop::sample::select(fragments).prop_map(<[u8]>::to_vec),
        1 => any::<u8>().prop_map(|byte| vec![byte]),
        1 => prop::sample::select(vec![&b" "[..], b"\t", b"\x84", b"\x85", b"\x90", b"\xC2\x96", b"\x9E", b"\xA0", b"\xA1"]).prop_map(<[u8]>::to_vec),
    ];
    let end = prop::sample::select(vec!["\n", "\n", "\r", "\r\n", ""]);
    let line = (prop::collection::vec(fragment, 0..6), end)
        .prop_map(|(words, end)| [&words.concat(), end.as_bytes()].concat());
    prop::collection::vec(line, 1..8).prop_map(|lines| lines.concat())
}

/// Does what a caller does with one line. Checks that nothing has changed if the answer is an error.
fn answer(line: Result<&str, Error>, state: ReportedState, interpreter: &mut Interpreter, settings: &mut Settings) {
    let before = (*interpreter, *settings);
    let answer = line.and_then(|line| match interpreter.interpret(line, state, settings)? {
        Command::SetSetting { number, value } => {
            *settings = settings.with(number, value).map_err(|refused| refused.error())?;
            Ok(())
        }
        Command::SetStartup { index, line, .. } => {
            assert!(index < 2 && line.len() <= isostep_console::parameters::STORED_LINE_CHARS);
            Ok(())
        }
        Command::SetBuild { text } => {
            assert!(text.len() <= isostep_console::parameters::STORED_LINE_CHARS);
            Ok(())
        }
        Command::Jog(jog) => {
            assert_eq!(*interpreter, before.0);
            interpreter.set_position_pm(jog.target_pm);
            Ok(())
        }
        _ => Ok(()),
    });
    if let Err(error) = answer {
        assert_eq!((*interpreter, *settings), before, "{error}");
        if let Ok(line) = line {
            let word = stopped_at(line).map(|range| &line[range]);
            assert!(word.is_none_or(|word| !word.is_empty()), "{line}");
            // For an error that stops reading at a word, that word is found, if reading got that far.
            let is_of_words =
                matches!(error, Error::ModalClash | Error::AxisConflict | Error::RepeatedWord | Error::ToolNumber);
            assert!(word.is_some() || !is_of_words, "{line}: {error}");
            let _ = Refusal::of(line, Error::Unsupported).map(|refusal| refusal.to_string());
        }
    }
    assert!(interpreter.position_pm().iter().all(|pm| pm.abs() <= MAX_COORDINATE_PM));
    // The offset is the sum of a work coordinate system, a shift and a tool length.
    assert!(interpreter.work_offset_pm().iter().all(|pm| pm.abs() <= 3 * MAX_COORDINATE_PM));
    assert_eq!(settings.check_ranges(), Ok(()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(10_000, 100_000)))]

    #[test]
    fn strings_of_any_bytes_are_answered_line_by_line(
        bytes in bytes(),
        state in prop::sample::select(&ReportedState::ALL[..]),
    ) {
        let (mut lines, mut interpreter) = (LineAssembler::new(), Interpreter::new());
        let mut settings = Settings::DEFAULT;
        let mut answers = 0;
        for &byte in &bytes {
            match realtime::classify(byte) {
                Some(Realtime::Reset) => {
                    lines.reset();
                    interpreter.reset();
                }
                Some(_) => {}
                None => {
                    if let Some(line) = lines.push(byte) {
                        answer(line, state, &mut interpreter, &mut settings);
                        answers += 1;
                    }
                }
            }
        }
        prop_assert_eq!(answers, bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count());
    }
}

/// Some senders take every line that contains one of these words as the answer to their own line, or as an alarm.
#[test]
fn no_words_of_ours_read_like_an_answer() {
    let mut build = String::new();
    report::build(&mut build, "", true).unwrap();
    report::extended_build(&mut build, &Settings::DEFAULT).unwrap();
    let mut texts: Vec<String> = vec![report::HELP.into(), build];
    texts.extend(Error::ALL.iter().map(ToString::to_string));
    texts.extend(AlarmCode::ALL.iter().map(ToString::to_string));
    let codes = (b'A'..=b'Z').flat_map(|letter| (0..100).map(move |code| format!("{}{code}.7", char::from(letter))));
    let lines = codes.chain(["G10L3P1X1", "G1X#1"].map(String::from));
    texts.extend(lines.flat_map(|line| Refusal::of(&line, Error::Unsupported).map(|refusal| refusal.to_string())));
    texts.push(report::messages::CHANGE_TOOL.into());
    for row in SETTING_TABLE {
        for value in [-1.0, 0.5, 0.0, 1e9, 555.0] {
            let refused = Settings::DEFAULT.with(row.number, value);
            match refused {
                Ok(settings) => texts.extend(settings.check(&|_| 1.0).err().map(|why| Unfit(why).to_string())),
                Err(refused) => texts.push(refused.to_string()),
            }
        }
    }
    for text in texts {
        assert!(["ok", "error", "ALARM"].iter().all(|word| !text.contains(word)), "{text}");
    }
}
