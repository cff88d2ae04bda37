//! A machine with a fourth axis in the simulator. A is rotary and turns without an end, unless its settings say
//! otherwise.

use isostep_motion::{Alarm, Axis};
use isostep_report::{Figures, pictures};
use isostep_sim::{Config, Flash, Port, Sim, State};
use isostep_tests::axes::xyz_a;
use isostep_tests::talk::{machine, say};

/// Every promise of a run, from its edges: equal intervals, edges where the closed form has them, limits, positions.
fn keeps_its_promises(sim: &Sim) {
    let figures = Figures::new("four axes", &sim.outcome());
    let broken: Vec<_> = figures.broken().collect();
    assert!(broken.is_empty() && figures.losses_total == 0, "{broken:?}");
}

#[test]
fn all_four_axes_share_the_intervals_of_a_move() {
    for port in Port::ALL {
        let mut sim = machine(&Config { port, ..Config::default() });
        let program =
            "G1 X20 Y-10 Z5 A90 F2000\nG0 A-45\nG91 G2 X10 I5 A30 F900\nG1 A12.34\nX1 A-1\nX1 Y1\nG90 G0 X0 Y0 Z0 A0";
        assert_eq!(say(&mut sim, program), ["ok"]);
        assert_eq!(sim.counted_steps(), [0; 4]);
        assert!(sim.steps().iter().all(|&steps| steps > 100), "{:?}", sim.steps());
        keeps_its_promises(&sim);
    }
}

/// The report has A in its tables and pictures.
#[test]
fn the_report_has_all_four_axes() {
    let outcome = isostep_sim::run(b"G1 X20 A90 F1200\nG2 X30 I5 A0\nG0 Z5 A-130\n", &Config::default()).unwrap();
    let page =
        pictures::page(&outcome, &pictures::BothRules::of(&outcome, None), &Figures::new("four axes", &outcome)).html();
    for words in ["X 30.00, Y 0.00, Z 5.00, A -130.00", "the top speed of A ($113)", "var(--a)"] {
        assert!(page.contains(words), "{words}");
    }
}

/// By default A does not home, and it is not homed by `$H`; with a 4 in `$901` it is.
#[test]
fn a_homes_if_the_order_names_it() {
    let mut sim = machine(&Config::default());
    assert_eq!(say(&mut sim, "G0 A10\n$H"), ["ok"]);
    assert_eq!(sim.machine().homed(), [true, true, true, false]);
    assert_eq!(sim.counted_steps(), [0, 0, 0, 500]);
    assert_eq!(say(&mut sim, "$HA"), ["error:5"]);
    assert_eq!(say(&mut sim, "$901=4312\n$HA"), ["ok"]);
    assert_eq!(sim.machine().homed(), [true; 4]);
    assert_eq!(sim.counted_steps(), [0; 4]);
    assert!((99..=100).contains(&(sim.places_steps()[3].rem_euclid(18_000))), "{:?}", sim.places_steps());
    // Nobody knows where the others are after they have lost their position, but A is homed first.
    assert_eq!(say(&mut sim, "G0 X30 A200\n$H"), ["ok"]);
    assert_eq!(sim.counted_steps(), [0; 4]);
    keeps_its_promises(&sim);
}

/// Wherever A stands at power-up, homing finds the one place of each turn.
#[test]
fn homing_finds_the_same_place_of_any_turn() {
    for start_degrees in [0.5, 15.0, 180.0, 349.0, 359.0] {
        let mut config = Config { start_mm: xyz_a([35.0, 40.0, 15.0], start_degrees), ..Config::default() };
        config.settings.homing_order_digits = 3124;
        let mut sim = machine(&config);
        assert_eq!(say(&mut sim, "$HA"), ["ok"], "{start_degrees}");
        let place = sim.places_steps()[3].rem_euclid(18_000);
        assert!((99..=100).contains(&place), "from {start_degrees} degrees to {place} steps");
    }
}

#[test]
fn an_axis_without_an_end_turns_past_its_switch() {
    let mut config = Config::default();
    config.settings.homing_order_digits = 3124;
    config.settings.max_rate_mm_min[3] = 36_000.0;
    config.settings.accel_mm_s2[3] = 1_000.0;
    let mut sim = machine(&config);
    assert_eq!(say(&mut sim, "$H\nG0 A-1000\nA2000"), ["ok"]);
    assert_eq!(sim.counted_steps(), [0, 0, 0, 100_000]);
    keeps_its_promises(&sim);
    // With a travel it has an end: soft limits and its switch stop it.
    let said = say(&mut sim, "A0\n$133=180\n$HA\nG0 A179\nG0 A181");
    let outside = "[MSG:A181.000 is outside the travel, 0.000 to 180.000 degrees: correct the program, then $X]";
    assert!(said.iter().any(|line| line == outside), "{said:?}");
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::SoftLimit { axis: Axis::A }));
}

#[test]
fn the_switch_of_an_axis_with_an_end_stops_it() {
    let mut config = Config { start_mm: xyz_a([35.0, 40.0, 15.0], 5.0), ..Config::default() };
    config.settings.travel_mm[3] = 180.0;
    let mut sim = machine(&config);
    let said = say(&mut sim, "G1 A-20 F60");
    assert!(said.contains(&"ALARM:1".to_owned()), "{said:?}");
    assert!(said.iter().any(|line| line.contains("MSG:A")), "{said:?}");
}

/// What keeps a move of a rotary and a linear axis from going faster is F along both, or along the linear one: `$701`.
#[test]
fn a_feed_is_kept_along_the_axes_that_it_is_for() {
    let lasts_s = |settings: &str| {
        let mut sim = machine(&Config::default());
        say(&mut sim, &format!("$120=5000\n$123=5000\n$113=100000\n{settings}"));
        let begun_ns = sim.now_ns();
        say(&mut sim, "G1 X30 A40 F600");
        keeps_its_promises(&sim);
        (sim.now_ns() - begun_ns) as f64 * 1e-9
    };
    let [along_all_s, along_linear_s] = ["$701=0", "$701=1"].map(lasts_s);
    assert!((along_all_s - 5.0).abs() < 0.1 && (along_linear_s - 3.0).abs() < 0.1, "{along_all_s}, {along_linear_s}");
}

#[test]
fn stored_places_have_four_axes() {
    let config = Config::default();
    let flash = Flash::blank();
    let mut sim = Sim::with_flash(&config, flash.clone());
    sim.run_until_idle().unwrap();
    say(&mut sim, "G10 L2 P1 X1 Y2 Z3 A4\nG0 A7\nG28.1");
    let mut again = Sim::with_flash(&config, flash);
    again.run_until_idle().unwrap();
    let listed = say(&mut again, "$#");
    assert!(listed.contains(&"[G54:1.000,2.000,3.000,4.000]".to_owned()), "{listed:?}");
    assert!(listed.contains(&"[G28:0.000,0.000,0.000,11.000]".to_owned()), "{listed:?}");
}
