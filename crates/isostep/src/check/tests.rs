//! Small programs, and what the check prints about them.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use indicatif::{ProgressBar, ProgressDrawTarget};
use isostep_console::Settings;
use isostep_report::check::{Check, Stand, rows};
use isostep_sim::program::Program;

use super::look::{self, Checked, Machine};
use super::print;

fn machine() -> Vec<Machine> {
    vec![Machine { name: "the default machine".to_owned(), settings: Settings::DEFAULT }]
}

/// Writes a program to a file and checks it.
fn check(name: &str, program: &str, start_mm: Option<[f64; 3]>) -> Checked {
    check_on(name, program, &machine(), Stand { start_mm, plate: None })
}

fn check_on(name: &str, program: &str, machines: &[Machine], stand: Stand) -> Checked {
    look::check(&file(name, program), machines, stand, &ProgressBar::hidden())
}

fn file(name: &str, program: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("isostep-check-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    fs::write(&path, program).unwrap();
    path
}

fn detail(checked: &Checked) -> String {
    print::detail(checked, false)
}

#[test]
fn a_good_program_is_reported_in_full() {
    let program =
        "%\n(tools)\nG21 G90 G64 P0.05\nT2 M6\nM3 S900\nG1 X20 F600\nY10\nG2 X10 I-5\nM0\nG0 Z5\nM5\nM30\n%\n";
    let checked = check("good.nc", program, None);
    let reported = detail(&checked);
    for words in [
        "lines      13: 10 of G-code (4 that move, 1 of them arcs), 0 of $, 3 empty, % or comments",
        "refused    none",
        "tools      T2 (line 4)\n",
        "waits      for a person and ~ at line 4, 9\n",
        "feeds      600 mm/min",
        "ends       by M2 or M30, line 12\n",
        "extents    X 0.000 to 20.000, Y 0.000 to 10.000, Z 0.000 to 5.000 mm: 20.000 x 10.000 x 5.000",
        "travel     it stays within, from --start 175,200,50",
        "limited by ",
        "s at 2 corners, ",
        "fastest    ",
    ] {
        assert!(reported.contains(words), "{words} in\n{reported}");
    }
    assert!(checked.is_good(), "{reported}");
}

#[test]
fn tools_are_named_with_their_comments_and_what_a_change_needs() {
    let program = "(T2 D=6 flat end mill)\nG21 G90\nT2 M6\nG1 X2 F600\nM6 T7\nM2\n";
    let plain = detail(&check("tools.nc", program, None));
    assert!(plain.contains("tools      T2 (line 3): D=6 flat end mill; T7 (line 5)\n"), "{plain}");
    assert!(!plain.contains("needed"), "{plain}");
    let settings = Settings { tool_change_mode: 3, ..Settings::DEFAULT };
    let words = rows(
        &Check::of(&Program::read_raw(program.as_bytes()).unwrap(), &settings, Stand::default(), &mut |_| {}),
        false,
    );
    let row = |name| words.iter().find(|row| row.name == name).map(|row| row.words.as_str());
    assert!(row("needed").is_some_and(|words| words.starts_with("$H before M6, and G59.3 ")), "{words:?}");
    assert!(row("time").is_some_and(|words| words.contains(" s")), "it runs as on a machine that is homed: {words:?}");
}

#[test]
fn every_refused_line_is_reported_up_to_ten_then_counted_by_word() {
    let program = format!("G42 D1 X5\nG0 X1 X2\n{}G0 X3\n", "M100\n".repeat(12));
    let checked = check("refused.nc", &program, None);
    let reported = detail(&checked);
    assert!(
        reported.contains("refused    14\n    line 1 `G42 D1 X5`: error:20 G42: no cutter compensation"),
        "{reported}"
    );
    assert!(reported.contains("line 2 `G0 X1 X2`: error:25 X2: A word stands twice"), "{reported}");
    assert!(reported.contains("and 4 more, in all M100 x 12, G42, error:25 X; --all tells up to 1,000"), "{reported}");
    assert!(reported.contains("s standing, without what is refused"), "{reported}");
    assert!(print::detail(&checked, true).matches("`M100`").count() == 12);
    assert!(!checked.is_good());
    let table = print::table(&[checked], &machine());
    assert!(table.contains("*  M100 x 12, G42, error:25 X\n"), "{table}");
}

#[test]
fn the_place_to_begin_at_is_found_unless_one_is_given() {
    let program = "G0 X180 Y-250\nG0 X0 Y0\nM2\n";
    let found = check("place.nc", program, None);
    assert!(detail(&found).contains("it stays within, from --start 171,251,50"), "{}", detail(&found));
    assert!(found.is_good());
    let given = check("given.nc", program, Some([5.0, 5.0, 5.0]));
    assert!(detail(&given).contains("left: line 1 `G0 X180 Y-250`: Y goes to -250.000 mm"), "{}", detail(&given));
    assert!(!given.is_good());
}

#[test]
fn a_program_that_homes_is_made_with_its_switches() {
    let checked = check("homes.nc", "$H\nG0 X10 Y10\nM2\n", None);
    assert!(detail(&checked).contains("s of homing"), "{}", detail(&checked));
    assert!(checked.is_good(), "{}", detail(&checked));
    let outside = check("outside.nc", "$H\nG0 X-10\nM2\n", None);
    let reported = detail(&outside);
    assert!(reported.contains("as its first line") && reported.contains("time       ALARM:2: "), "{reported}");
    assert!(!outside.is_good());
}

/// The second machine has homing switched off.
#[test]
fn what_one_machine_alone_refuses_is_reported_of_it() {
    let mut two = machine();
    let mut settings = Settings::DEFAULT;
    (settings.homing, settings.soft_limits) = (false, false);
    two.push(Machine { name: "open".to_owned(), settings });
    let path = std::env::temp_dir().join(format!("isostep-two-{}.nc", std::process::id()));
    fs::write(&path, "$H\nG0 X5\nM2\n").unwrap();
    let checked = look::check(&path, &two, Stand::default(), &ProgressBar::hidden());
    let reported = detail(&checked);
    assert!(
        reported.contains("refused    none") && reported.contains("line 1 `$H`: error:5 Homing is switched off"),
        "{reported}"
    );
    assert!(print::table(&[checked], &two).contains("*  error:5\n"));
}

#[test]
fn a_setting_that_is_refused_in_motion_is_reported_with_what_helps() {
    let reported = detail(&check("motion.nc", "G0 X50\n$110=1000\nM2\n", None));
    assert!(
        reported.contains("time       line 2 `$110=1000` was refused: error:8 ")
            && reported.contains("put G4 P0 before it"),
        "{reported}"
    );
    let reported = detail(&check("fast.nc", "$110=90000000\nG0 X5\nM2\n", None));
    assert!(reported.contains("line 2 `G0 X5` was refused: error:9 $110=90000000 is above the"), "{reported}");
}

#[test]
fn what_is_no_program_is_a_row_like_the_others() {
    let (text, binary) = (check("one.nc", "G0 X1\nM2\n", None), check("binary.nc", "\x7fELF\0", None));
    assert!(detail(&binary).contains("binary.nc: line 1: byte 0x7f is not text"), "{}", detail(&binary));
    assert!(!binary.is_good());
    let table = print::table(&[text, binary], &machine());
    let rows: Vec<_> = table.lines().collect();
    assert!(rows[1].starts_with("one.nc") && rows[1].ends_with("  -"), "{table}");
    assert!(rows[2].starts_with("binary.nc") && rows[2].contains("is not text"), "{table}");
}

#[test]
fn one_line_that_must_not_be_sent_is_refused_and_the_others_are_checked() {
    let checked = check("one-bad.nc", "G0 X5\n?\nG0 X6 µ\nG0 X7 (fine?)\nM2\n", None);
    let reported = detail(&checked);
    for words in [
        "refused    2\n    line 2 `?`: '?' is a real-time command, obeyed the moment it arrives: take it out of the program\n",
        "    line 3 `G0 X6 µ`: byte 0xc2 is not text: remove it, or put it in a comment\n",
        "extents    X 0.000 to 7.000",
    ] {
        assert!(reported.contains(words), "{words} in\n{reported}");
    }
    assert!(!checked.is_good());
}

#[test]
fn what_a_program_may_not_mean_is_remarked() {
    let program = "(Ä, Ñ!)\nG0 X5 (a\u{a0}b)\nG28.1 X6\nM3 S1000\nS1200 (Ä)\nT1\nT2 M6\nM2\n";
    let mut machine = machine();
    machine[0].settings.spindle_max_rpm = 255.0;
    let checked = check_on("remarks.nc", program, &machine, Stand::default());
    let reported = detail(&checked);
    for words in [
        "  messages   none: no (MSG, ...) says what the tools are\n",
        "  power      S up to 1200 is above $30=255, from which on the power is full, at line 4, 5\n",
        "  places     G28.1 and G30.1 store the place where the machine stands, and axis words beside them are a move after that, at line 3\n",
        "  comments   with bytes that act at once, if a sender does not strip them: write plain ASCII\n",
        "    line 1: ! (0x21) holds the machine\n",
        "    line 2: a no-break space (0xA0) switches flood coolant\n",
        "    line 1, 5: Ä (0x84) acts as a safety door that opens\n",
        "    line 1: Ñ (0x91) changes the feed\n",
    ] {
        assert!(reported.contains(words), "{words} in\n{reported}");
    }
    assert!(checked.is_good(), "remarks are no refusals: {reported}");
    let good = "(MSG, T2: 3 mm)\nG0 X5 (why? µ)\nG28.1\nG0 X6\nM3 S255\nT2 M6\nM2\n";
    let reported = detail(&check_on("no-remarks.nc", good, &machine, Stand::default()));
    for name in ["  messages  ", "  power  ", "  places  ", "  comments  "] {
        assert!(!reported.contains(name), "{name} in\n{reported}");
    }
}

/// Three holes by a subroutine, which is called from a loop.
#[test]
fn a_program_with_subroutines_is_checked_as_the_lines_that_it_makes() {
    let program = "G21 G90\no100 repeat [3]\nM98 P7\n#1=[#1+1]\no100 endrepeat\nX[1/0]\nM2\nO7 (a hole)\nG0 X[10*#1] Y#1\nG1 Z-1 F300\n\
                   G0 Z1\nM99\n";
    let reported = detail(&check("holes.nc", program, None));
    for words in [
        "  lines      11: 11 of G-code (9 that move, 0 of them arcs), 0 of $, 0 empty, % or comments\n",
        "  made       from 12 lines of the file: parameters, expressions, O-words and M98 are carried out before the machine gets them\n",
        "  refused    1\n    line 6 `X[1/0]`: 1 is divided by zero: test the divisor by an o-if before\n",
        "  ends       by M2 or M30, line 7\n",
        "  extents    X 0.000 to 20.000, Y 0.000 to 2.000, Z -1.000 to 1.000 mm",
        "    line 9, at X",
    ] {
        assert!(reported.contains(words), "{words} in\n{reported}");
    }
    let good = check("good-holes.nc", &program.replace("X[1/0]\n", ""), None);
    let by_hand: String = (0..3).map(|hole| format!("G0 X{}0 Y{hole}\nG1 Z-1 F300\nG0 Z1\n", hole)).collect();
    let by_hand = check("by-hand.nc", &format!("G21 G90\n{by_hand}M2\n"), None);
    assert!(good.is_good() && good.on[0].check.time_s == by_hand.on[0].check.time_s);
    assert!(!detail(&by_hand).contains("  made  "), "{}", detail(&by_hand));
    let endless = detail(&check("endless.nc", "o1 while [1]\n#1=2\no1 endwhile\n", None));
    assert!(endless.contains("1000000 lines were carried out without one for the machine"), "{endless}");
}

#[test]
fn dwells_before_the_first_move_and_after_the_last_count() {
    let plain = check("plain.nc", "G0 X5\nM2\n", None);
    let waiting = check("waits.nc", "G4 P3\nG0 X5\nG4 P2\nM2\n", None);
    let [plain_s, waiting_s] = [&plain, &waiting].map(|checked| checked.on[0].check.time_s.unwrap());
    assert!((waiting_s - plain_s - 5.0).abs() < 0.01, "{waiting_s} s, {plain_s} s without");
    let reported = detail(&waiting);
    assert!(reported.contains(", 3.00") && reported.contains(" s waiting before the first move, 2.0"), "{reported}");
    assert!(reported.contains(" s waiting after the last"), "{reported}");
    assert!(!detail(&plain).contains("waiting"), "{}", detail(&plain));
    let alone = check("alone.nc", "G4 P5\nM2\n", None).on[0].check.time_s.unwrap();
    assert!((alone - 5.0).abs() < 0.01, "{alone} s");
    let freed = check("freed.nc", "$1=250\nG0 X5\nM2\n", None).on[0].check.time_s.unwrap();
    assert!((freed - plain_s).abs() < 0.01, "motors are freed later, which nobody waits for: {freed} s");
    let homed = check("homed.nc", "$H\nG4 P1\nG0 X5\nM2\n", None);
    assert!((homed.on[0].check.waits_s.unwrap()[0] - 1.0).abs() < 0.01, "{:?}", homed.on[0].check.waits_s);
}

/// Machine C, and lines of 0.04 mm at 100 mm/s: 2,500 moves a second are asked for, and none lasts less than 0.59 ms.
#[test]
fn more_moves_than_the_board_carries_are_reported() {
    let mut settings = Settings::DEFAULT;
    (settings.homing, settings.soft_limits) = (false, false);
    (settings.steps_per_mm, settings.max_rate_mm_min) = ([80.0; 3], [12_000.0; 3]);
    (settings.accel_mm_s2, settings.travel_mm) = ([2_000.0; 3], [10_000.0; 3]);
    let c = [Machine { name: "c".to_owned(), settings }];
    let checked =
        check_on("short.nc", &format!("G64 P0.01 Q0 G91 G1 F6000\n{}", "X0.04\n".repeat(10_000)), &c, Stand::default());
    let reported = detail(&checked);
    assert!(reported.contains("\n  the board  1695"), "{reported}");
    assert!(reported.contains(" moves a second, where it plans 1640 (emulated"), "{reported}");
    assert!(reported.contains(": it takes at least 0.17"), "{reported}");
    let table = print::table(&[checked], &c);
    assert!(table.contains("the board takes 0.17"), "{table}");
}

/// Two stops, each half a period of 40 Hz with a damping ratio of 0.05 longer.
#[test]
fn what_shapers_cost_is_reported() {
    let program = "G0 X5\nG4 P1\nG0 Y5\nM2\n";
    let [plain, shaped] = ["", "$950=1\n"].map(|set| check("stops.nc", &format!("{set}{program}"), None));
    let more_s = shaped.on[0].check.time_s.unwrap() - plain.on[0].check.time_s.unwrap();
    assert!((more_s - 2.0 * 0.012_515_6).abs() < 1e-5, "{more_s} s");
    let reported = detail(&shaped);
    assert!(reported.contains("\n  shaping    0.025 s more for 2 stops, 12.5 ms at most; "), "{reported}");
    assert!(!detail(&plain).contains("shap"), "{}", detail(&plain));
}

#[test]
fn a_pierce_that_will_be_dark_is_reported() {
    let program = "$32=1\nM3 S800\nG4 P0.5\nG1 X5 F600\nM5\nG4 P0.5\nM2\n";
    let reported = detail(&check("pierce.nc", program, None));
    assert!(reported.contains("dark       the laser does not pierce at line 3: it is dark wherever"), "{reported}");
    for good in [program.replace("$32=1", "$32=0"), program.replace("M3", "M4"), program.replace("S800", "S0")] {
        assert!(!detail(&check("dots.nc", &good, None)).contains("pierce"), "{good}");
    }
}

#[test]
fn a_plate_is_probed_and_its_place_is_reported() {
    let program = "G21 G91\nG38.2 Z-10 F60\nG0 Z2\nM2\n";
    let stand = |plate| Stand { start_mm: Some([35.0, 40.0, 15.0]), plate };
    let plate = Some("Z,12.5,below".parse().unwrap());
    let checked = check_on("probe.nc", program, &machine(), stand(plate));
    let reported = detail(&checked);
    assert!(checked.is_good(), "{reported}");
    assert!(reported.contains("probed     line 2: [PRB:0.000,0.000,-2."), "{reported}");
    let without = detail(&check_on("none.nc", program, &machine(), stand(None)));
    assert!(without.contains("ALARM:5") && without.contains("(--probe-plate puts a plate there)"), "{without}");
}

/// The lines that the bar has counted, and all of them.
fn counted(bar: &ProgressBar) -> (u64, u64) {
    (bar.position(), bar.length().unwrap())
}

/// It counts what is refused, and what an alarm leaves out, too.
#[test]
fn the_bar_is_full_at_the_end_however_a_program_ends() {
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::hidden());
    for (name, program, lines) in [
        ("refused-bar.nc", "G0 X5\nG99\nM2\n", 3),
        ("alarm-bar.nc", "G38.2 Z-5 F60\nG0 X5\nG0 X6\nM2\n", 3 + 4),
        ("fast-bar.nc", "G91\nG0 X0.1\n", 3 + 4 + 2),
    ] {
        look::check(&file(name, program), &machine(), Stand::default(), &bar);
        assert_eq!(counted(&bar), (lines, lines), "{name}");
    }
}

/// A program of half an hour, which takes some tenths of a second here.
#[test]
fn the_bar_moves_while_a_long_program_is_made() {
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::hidden());
    let path = file("long-bar.nc", &format!("G91 G1 F60\n{}", "X1\nX-1\n".repeat(1_000)));
    let seen = std::thread::scope(|scope| {
        let check = scope.spawn(|| look::check(&path, &machine(), Stand::default(), &bar));
        let mut seen = BTreeSet::new();
        while !check.is_finished() {
            seen.insert(bar.position());
            std::thread::yield_now();
        }
        seen
    });
    assert_eq!(counted(&bar), (2_001, 2_001));
    assert!(seen.iter().any(|lines| (1..2_000).contains(lines)), "{seen:?}");
}
