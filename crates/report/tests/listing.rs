//! Six settings that people have published for Grbl, grblHAL and FluidNC: what is said of each line, and that the machine homes with
//! them and makes a first program.

use isostep_report::listing::Listing;
use isostep_sim::{Config, run};

const LISTINGS: [(&str, &str); 6] = [
    ("genmitsu-3018-pro", include_str!("listings/genmitsu-3018-pro.txt")),
    ("x-carve", include_str!("listings/x-carve.txt")),
    ("laser-500", include_str!("listings/laser-500.txt")),
    ("skr-3-ez", include_str!("listings/skr-3-ez.txt")),
    ("longmill-mk3", include_str!("listings/longmill-mk3.txt")),
    ("fluidnc", include_str!("listings/fluidnc.txt")),
];

fn listing(name: &str) -> Listing {
    let text = LISTINGS.iter().find(|(listed, _)| *listed == name).unwrap().1;
    Listing::read(name, text.as_bytes(), &Config::default())
}

/// All that is said, a line each.
fn said(listing: &Listing) -> Vec<String> {
    let rows = listing.rows();
    rows.iter().flat_map(|row| [vec![format!("{} {}", row.name, row.words)], row.places.clone()].concat()).collect()
}

#[test]
fn each_line_of_grbls_is_reported() {
    let expected: &[&str] = &[
        "taken 31 as they are",
        "otherwise 3, which mean something else here",
        "line 9 `$10=19`: taken as $10=3: machine position (1) and buffers (2) are a choice, and all other fields are always reported",
        "line 10 `$11=0.010`: it holds with G61; else corners are blends, by $904 and G64 P",
        "line 19 `$26=250`: a switch counts once it has been steady for so long; 5 is enough for most, and sooner",
        "unknown none",
        "refused none",
        "travel 0 is where an axis stands after $H, $27 from its switch. Add to the places of G28, G30, G53 and of work offsets:",
        "X 0.000 to 269.000 mm; to a place of Grbl's add 268.000",
        "Y -180.000 to 0.000 mm; to a place of Grbl's add 1.000",
        "Z -38.000 to 0.000 mm; to a place of Grbl's add 1.000",
    ];
    assert_eq!(said(&listing("genmitsu-3018-pro")), expected);
}

#[test]
fn each_line_of_grblhals_is_reported() {
    let expected: &[&str] = &[
        "taken 33 as they are",
        "otherwise 9, which mean something else here",
        "line 6 `$4=0`: taken as $4=1: grblHAL's 0 is an ENABLE that is active high",
        "line 7 `$5=15`: taken as $5=1: one setting is for all switches: wire all of them to open when they are pressed",
        "line 8 `$6=3`: taken as $6=1: bit 1 is no tool setter here",
        "line 11 `$10=511`: taken as $10=3: machine position (1) and buffers (2) are a choice, and all other fields are always reported",
        "line 12 `$11=0.010`: it holds with G61; else corners are blends, by $904 and G64 P",
        "line 19 `$22=79`: taken as $22=1: bit 0 is homing; $HX homes one axis, and the machine is not locked until it is homed",
        "line 20 `$23=9`: taken as $23=1: there are no more axes than XYZ",
        "line 23 `$26=25`: a switch counts once it has been steady for so long; 5 is enough for most, and sooner",
        "line 38 `$44, $45, $46`: taken as $901=321: the axes home one after the other",
        "unknown 18, left out",
        "line 10 `$9=1`: the PWM output is on whenever the spindle is, and S0 has no duty",
        "line 15 `$14=64`: inputs are low when they are pressed, with a pull-up, and outputs are active high: only an emergency stop may open (--estop nc)",
        "line 16 `$15=0`: inputs are low when they are pressed, with a pull-up, and outputs are active high: only an emergency stop may open (--estop nc)",
        "line 26 `$29=0.0`: the time from DIR to STEP is that of the driver (--driver)",
        "line 31 `$34=0.0`: S0 has no duty",
        "line 34 `$37=0`: $1=255 keeps all motors on, and nothing else keeps some of them on",
        "line 35 `$39=1`: all real-time bytes act",
        "line 36 `$40=1`: a jog of a homed axis always keeps to the travel",
        "line 37 `$43=1`: the door parks nothing, and homing measures each switch once",
        "line 41 `$47=0`: there are no more axes",
        "line 45 `$103=79.01235`: firmware with A has it, on four axes: --axes 4; there are no more",
        "line 49 `$113=8000.000`: firmware with A has it, on four axes: --axes 4; there are no more",
        "line 53 `$123=1000.000`: firmware with A has it, on four axes: --axes 4; there are no more",
        "line 57 `$133=0.000`: firmware with A has it, on four axes: --axes 4; there are no more",
        "line 59 `$376=1`: firmware with A has it, on four axes: --axes 4; there are no more",
        "line 60 `$384=0`: G92 is forgotten by a reset",
        "line 62 `$398=128`: the look-ahead has 64 moves, and one spindle",
        "line 63 `$481=0`: nothing here depends on it",
        "refused none",
        "travel 0 is where an axis stands after $H, $27 from its switch. Add to the places of G28, G30, G53 and of work offsets:",
        "X 0.000 to 805.000 mm; to a place of Grbl's add 803.000",
        "Y -830.000 to 0.000 mm; to a place of Grbl's add 2.000",
        "Z -129.000 to 0.000 mm; to a place of Grbl's add 2.000",
    ];
    assert_eq!(said(&listing("longmill-mk3")), expected);
}

#[test]
fn what_others_have_is_reported() {
    let has = |name: &str, words: &str| {
        let said = said(&listing(name));
        assert!(said.iter().any(|line| line == words), "{words} in {name}:\n{}", said.join("\n"));
    };
    has("x-carve", "line 33 `$130=-290.000`: taken as $130=290: the travel is a length");
    has("laser-500", "line 23 `$32=1`: the beam is on only while the machine moves, with M3 too");
    has("skr-3-ez", "line 6 `$4=7`: taken as $4=0: grblHAL's 7 is an ENABLE that is active low");
    has("skr-3-ez", "line 39 `$44, $45, $46`: taken as $901=213: the axes home one after the other");
    has("fluidnc", "line 18 `$30=0`: taken as $30=1000: S would have no full duty: set the S that has it");
    has("fluidnc", "taken 16 as they are");
}

#[test]
fn a_change_of_the_tool_is_taken_over_from_grblhal() {
    let text = "$341=2\n$342=30.0\n$343=25.0\n$344=200.0\n$345=200.0\n$346=1\n";
    let listing = Listing::read("hal.txt", text.as_bytes(), &Config::default());
    assert_eq!(listing.taken, [(341, 2.0), (342, 30.0), (343, 25.0), (344, 200.0)]);
    let said = said(&listing);
    assert!(said.contains(&"line 5 `$345=200.0`: $TPW goes up again by $344".to_owned()), "{said:?}");
    assert!(said.contains(&"line 6 `$346=1`: behind M6 the machine goes back to where it was".to_owned()), "{said:?}");
}

#[test]
fn what_cannot_be_is_refused_with_the_remedy() {
    let said = |text: &str| said(&Listing::read("my.txt", text.as_bytes(), &Config::default())).join("\n");
    assert!(
        said("$2=1\n$100=80\n").contains("line 1 `$2=1`: STEP is active high: leave $2 out"),
        "{}",
        said("$2=1\n$100=80\n")
    );
    let vfd = said("$395=2\n$340=0\n$398=100\n");
    assert!(vfd.contains("taken as $395=0: grblHAL counts the spindles"), "{vfd}");
    assert!(vfd.contains("taken as $340=5: a VFD's spindle is always waited for"), "{vfd}");
    assert!(said("$100=0.000\n").contains("line 1 `$100=0.000`: $100=0 is below the least, 0.100 steps/mm: raise it"));
    assert!(
        said("$27=30\n$130=20\n")
            .contains("refused 1\n`$130=20`: $27=30 is not below the travel of X, $130=20 mm: lower")
    );
    assert!(
        said("$Homing/Seek=1000\n$100=80\n").contains("line 1 `$Homing/Seek=1000`: a name, a text or a start-up line")
    );
    assert!(said("<Idle|MPos:0,0,0>\n").contains("there is no $n=v line in it: save what $$ prints"));
}

/// Away from the switches and back, however they are mounted.
#[test]
fn the_machine_homes_with_each_and_makes_a_first_program() {
    for (name, _) in LISTINGS {
        let listing = listing(name);
        assert!(listing.is_good(), "{name}: {:?}", listing.refused);
        let settings = listing.settings.unwrap();
        let again = Listing::read(name, listing.text().as_bytes(), &Config::default());
        assert_eq!(
            (again.settings, &again.unknown[..]),
            (Some(settings), &[][..]),
            "{name}: what is written is read back"
        );
        let away = |axis: usize| if settings.homing_direction_mask >> axis & 1 == 1 { "" } else { "-" };
        let [x, y, z] = [0, 1, 2].map(away);
        let program = format!(
            "$H\nG21 G90 G94\nG0 X{x}20 Y{y}20 Z{z}10\nG1 X{x}30 F600\nY{y}30\nG2 X{x}20 Y{y}20 R8\nG0 X0 Y0 Z0\nM2\n"
        );
        let config = Config { settings, start_mm: [12.0; 3], ..Config::default() };
        let outcome = run(program.as_bytes(), &config).unwrap();
        assert_eq!(
            (outcome.alarm_code, &outcome.refusals[..], outcome.position_mm),
            (None, &[][..], [0.0; 3]),
            "{name}"
        );
        assert_eq!((&outcome.losses[..], outcome.drift_steps), (&[][..], [0; 3]), "{name}");
    }
}
