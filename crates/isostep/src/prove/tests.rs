//! The verb against a board in memory, which answers the protocol with stamps of the compiled move and has faults to
//! inject.

mod fake;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Result;

use self::fake::{Fake, Faults, WINDOW};
use super::{Effort, How, Jumper, Part, Progress, Proof, on, page, tables};
use crate::chip::Chip;

fn effort() -> Effort {
    Effort {
        rates: vec![100_000, 1_000_000],
        windows: 5,
        pair_windows: 5,
        rate_step: 500_000,
        stops: 3,
        starts: 2,
        moves: 40,
        crystal_s: 1.0,
    }
}

fn how(jumpers: &[Jumper]) -> How {
    How { jumpers: jumpers.to_vec(), effort: effort(), laser: false, only: Vec::new() }
}

fn prove(fake: &mut Fake, how: &How) -> Result<Proof> {
    on(fake, how, &Arc::default(), &Progress::begin())
}

/// Proves these parts.
fn proved(faults: Faults, jumpers: &[Jumper], only: &[Part]) -> Proof {
    prove(&mut Fake::new(faults), &How { only: only.to_vec(), ..how(jumpers) }).unwrap()
}

fn value(proof: &Proof, key: &str) -> f64 {
    proof.found.figure(key).and_then(|figure| figure.value).unwrap_or_else(|| panic!("{key} in {proof:#?}"))
}

#[test]
fn a_board_that_keeps_its_promises_is_proved() {
    // Stamps are of two cycles, or of one.
    for (chip, [single, pair]) in [(Chip::Rp2040, [16, 8]), (Chip::Rp2350, [13, 7])] {
        a_board_is_proved(chip, single, pair);
    }
}

fn a_board_is_proved(chip: Chip, single: u32, pair: u32) {
    let mut fake = Fake::new(Faults { chip, wires: vec![9], ..Faults::default() });
    let proof = prove(&mut fake, &how(&[Jumper::Limit])).unwrap();
    assert_eq!((proof.found.broken(), &proof.found.remarks), (Vec::<String>::new(), &Vec::new()), "{proof:#?}");
    for rate in [100_000, 1_000_000] {
        assert!(value(&proof, &format!("edges.{rate}.{single}.max")) <= 40.0);
        assert!(value(&proof, &format!("edges.{rate}.{pair}.max")) <= 32.0);
    }
    // All of 3 x 3,000 edges at the slow rate are in the windows.
    assert!(value(&proof, &format!("edges.100000.{single}.seen")) >= 9_000.0, "{proof:#?}");
    assert!(value(&proof, "intervals") <= 100.0);
    assert_eq!(value(&proof, "rate.3"), 2_000_000.0);
    let without = proved(Faults { chip, ..Faults::default() }, &[], &[Part::Stops]);
    for latency_us in [value(&proof, "stop.9"), value(&without, "stop.reset")] {
        assert!((1.0..=5.1).contains(&latency_us), "{latency_us}");
    }
    assert!((value(&proof, "crystal") - 20.0).abs() < 3.0);
    assert!((value(&proof, "cache.miss") - 48.0).abs() < 0.01);
    assert_eq!((value(&proof, "laser.dark"), value(&proof, "ready")), (0.0, 345.678));
    assert!((12.0..13.0).contains(&value(&proof, "start.cold")));
    assert!(fake.is_at_rest());
    assert!(fake.has_defaults(), "the settings are put back");
}

/// From the first stop it is known where in a move the others come: each is in the middle of its window, so that half a window
/// is left for one that comes sooner or later. The figure is the longest time of those that were seen.
#[test]
fn stops_are_in_the_middle_of_their_windows_and_the_longest_is_reported() {
    for (wires, jumpers, key) in [(vec![9], &[Jumper::Limit][..], "stop.9"), (Vec::new(), &[], "stop.reset")] {
        let mut fake = Fake::new(Faults { wires, ..Faults::default() });
        let proof = prove(&mut fake, &How { only: vec![Part::Stops], ..how(jumpers) }).unwrap();
        let stops = fake.stops();
        assert_eq!(stops.len() as u32, 1 + effort().stops, "the first is seen by no window: {stops:?}");
        for stop in &stops[1..] {
            let beyond = stop.made - stop.skip;
            assert!(beyond.abs_diff(WINDOW as u32 / 2) <= 3, "{key}: {stop:?} is {beyond} edges into its window");
        }
        let longest_us = stops[1..].iter().map(|stop| stop.latency_us).fold(0.0, f64::max);
        assert!((value(&proof, key) - longest_us).abs() <= 0.024, "{key}: {} of {stops:?}", value(&proof, key));
    }
}

#[test]
fn without_a_wire_the_rows_say_which_one() {
    let proof = proved(Faults::default(), &[], &[Part::Stops, Part::Laser]);
    let words = |key: &str| proof.found.figure(key).unwrap().verdict(None);
    assert_eq!(words("stop.9"), "needs a wire from GP28 to GP9");
    assert_eq!(words("stop.12"), "needs a wire from GP28 to GP12");
    assert!(words("laser.500").starts_with("needs --laser"));
}

#[test]
fn an_edge_that_is_three_cycles_late_is_found_and_named() {
    for chip in Chip::ALL {
        let faults = Faults { chip, shifted: Some((1, 2_345, 3)), ..Faults::default() };
        let faults = proved(faults, &[], &[Part::Edges]).found.faults;
        let named = |fault: &String| {
            fault.starts_with("at 3 x 100,000 steps/s: edge 2345 of Y was ")
                && fault.contains(" ns late beside the others")
        };
        assert!(faults.iter().any(named), "{chip:?}: {faults:#?}");
        assert!(faults.iter().all(|fault| fault.contains("edge 2345 of Y")), "{chip:?}: {faults:#?}");
    }
}

#[test]
fn a_lost_edge_is_found_and_named() {
    let proof = proved(Faults { lost: Some((2, 777)), ..Faults::default() }, &[], &[Part::Edges]);
    assert!(
        proof.found.faults.contains(&"at 3 x 100,000 steps/s: edge 777 of Z was lost".to_owned()),
        "{:#?}",
        proof.found.faults
    );
}

#[test]
fn what_the_stampers_lose_is_reported_and_no_fault_of_the_board() {
    let proof = proved(Faults { stampers_lose: true, ..Faults::default() }, &[], &[Part::Edges]);
    assert!(
        proof.found.remarks.iter().any(|remark| remark.contains("the stampers themselves lost stamps")),
        "{:#?}",
        proof.found.remarks
    );
    assert!(!proof.found.faults.iter().any(|fault| fault.contains("was lost")), "{:#?}", proof.found.faults);
}

#[test]
fn a_rate_too_high_is_no_fault_where_it_is_searched_and_one_where_it_is_promised() {
    let proof = proved(Faults { rate_max: Some(500_000.0), ..Faults::default() }, &[], &[Part::Edges, Part::Rates]);
    assert_eq!(value(&proof, "rate.3"), 500_000.0);
    let refused = proof.found.figure("edges.1000000.16.max").unwrap().verdict(None);
    assert!(refused.contains("`$110=60000` was refused"), "{refused}");
}

#[test]
fn a_switch_that_does_not_come_is_found_and_named() {
    let proof = proved(Faults::default(), &[Jumper::Limit], &[Part::Stops]);
    let why = "the limit switch did not stop the move: is the wire from GP28 to GP9 there?";
    assert_eq!(proof.found.faults, [why]);
    assert_eq!(proof.found.figure("stop.9").unwrap().verdict(None), why);
}

#[test]
fn with_a_wire_a_reset_is_not_measured() {
    let proof = proved(Faults { wires: vec![12], ..Faults::default() }, &[Jumper::Estop], &[Part::Stops]);
    assert!((1.0..=5.1).contains(&value(&proof, "stop.12")));
    assert_eq!(
        proof.found.figure("stop.reset").unwrap().verdict(None),
        "needs that no wire is on GP28: run `isostep prove --only stops` without it"
    );
    assert_eq!(proof.found.broken(), Vec::<String>::new());
}

#[test]
fn an_old_image_has_a_remedy_and_is_not_reset() {
    let mut fake = Fake::new(Faults { is_old: true, ..Faults::default() });
    let error = format!("{:#}", prove(&mut fake, &how(&[])).unwrap_err());
    assert!(error.contains("not as the proving image") && error.contains("--image"), "{error}");
    assert_eq!(fake.resets(), 0, "it may be at work");
}

#[test]
fn a_port_where_nothing_answers_has_a_remedy() {
    let error =
        format!("{:#}", prove(&mut Fake::new(Faults { is_silent: true, ..Faults::default() }), &how(&[])).unwrap_err());
    assert!(error.contains("nothing answers") && error.contains("Unplug it"), "{error}");
}

/// Unplugged after any number of lines, the verb ends with words.
#[test]
fn a_board_that_is_unplugged_ends_the_proof_with_words() {
    for lines in [0, 1, 5, 40, 90, 200, 300] {
        let mut fake = Fake::new(Faults { unplugged_after: Some(lines), ..Faults::default() });
        let error = format!("{:#}", prove(&mut fake, &how(&[])).unwrap_err());
        assert!(error.contains("unplugged"), "after {lines} lines: {error}");
    }
}

#[test]
fn an_interrupted_proof_leaves_the_machine_at_rest() {
    let interrupted = Arc::new(AtomicBool::new(false));
    let mut fake = Fake::new(Faults { interrupts: Some((60, interrupted.clone())), ..Faults::default() });
    let error = on(&mut fake, &how(&[]), &interrupted, &Progress::begin()).unwrap_err();
    assert!(format!("{error:#}").contains("interrupted"), "{error:#}");
    assert!(fake.is_at_rest());
}

#[test]
fn a_port_that_is_not_there_says_so() {
    #[cfg(unix)]
    {
        let error = super::Serial::open("/dev/isostep-nowhere").err().unwrap().to_string();
        assert!(error.contains("there is no such port"), "{error}");
    }
}

#[test]
fn table_page_letter_and_comparison_have_every_figure() {
    let parts = [Part::Ready, Part::Edges, Part::Cache, Part::Stops];
    let proof = proved(Faults::default(), &[], &parts);
    let emulated = proof.clone();
    let shown = tables::shown(&proof, Some(&emulated));
    let (letter, html) = (tables::letter(&proof, Some(&emulated)), page::page(&proof, Some(&emulated)).html());
    for figure in &proof.found.figures {
        assert!(shown.contains(&figure.what) && letter.contains(&figure.what), "{}", figure.what);
        assert!(html.contains(&figure.what.replace('\'', "&#39;")) || html.contains(&figure.what), "{}", figure.what);
    }
    assert!(shown.contains("as emulated (within"));
    assert_eq!(html.matches("<svg").count(), 2 * proof.found.edges.len());
    assert!(html.contains("E660583883724B2F") && !html.contains("NaN"));
    let other = proved(Faults { wires: vec![9], ..Faults::default() }, &[Jumper::Limit], &parts);
    let compared = tables::compared(&proof, &other);
    assert!(compared.contains("B beside A") && compared.contains("as A (within"), "{compared}");
}

#[test]
fn the_emulated_proof_of_each_chip_is_one_that_keeps_every_promise() {
    for chip in Chip::ALL {
        let emulated = super::emulated(chip).unwrap().unwrap();
        assert_eq!((emulated.is_emulated, emulated.board.known_chip().unwrap()), (true, chip));
        assert_eq!(emulated.found.broken(), Vec::<String>::new(), "{chip:?}");
        let missing =
            emulated.found.figures.iter().filter(|figure| figure.value.is_none()).map(|figure| figure.key.as_str());
        assert_eq!(missing.collect::<Vec<_>>(), [""; 0], "{chip:?}");
    }
}
