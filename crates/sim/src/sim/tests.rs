//! Tests of whole machines: what a good one does, and that faults of a bad one are detected.

use isostep_motion::Alarm;
use tmc2209::WriteRequest;
use tmc2209::reg::CHOPCONF;

use super::*;
use crate::config::{Board, Port, Streaming};
use crate::record::LossCause;
use crate::{trace, vcd, verify};

fn parking() -> &'static [u8] {
    include_bytes!("../../../../programs/parking.nc")
}

/// All files that a run writes.
fn files(config: &Config) -> [Vec<u8>; 2] {
    let outcome = run(parking(), config).unwrap();
    let (mut csv, mut wires) = (Vec::new(), Vec::new());
    trace::write(&outcome.edges, &mut csv).unwrap();
    vcd::write(&outcome.waves, &outcome.tool, outcome.limits_high_at_start, &mut wires).unwrap();
    [csv, wires]
}

#[test]
fn equal_runs_write_equal_bytes() {
    let config = Config::default();
    let other_thread = std::thread::spawn({
        let config = config.clone();
        move || files(&config)
    });
    let here = files(&config);
    assert!(here == files(&config));
    assert!(here == other_thread.join().unwrap());
    assert!(here != files(&Config { seed: 2, ..config }), "the seed has no effect");
}

#[test]
fn every_seed_and_way_of_sending_parks_the_car() {
    let sent = [(1, crate::Streaming::GRBL), (2, crate::Streaming::SendAndWait), (3, crate::Streaming::GRBL)];
    for ((seed, streaming), port) in sent.into_iter().flat_map(|sent| Port::ALL.map(|port| (sent, port))) {
        let poll_every = (seed == 3).then_some(Duration::from_millis(200));
        let config = Config { seed, streaming, poll_every, port, ..Config::default() };
        let outcome = run(parking(), &config).unwrap();
        let findings = verify::moves(&outcome).collect();
        let broken: Vec<_> =
            verify::verdicts(&outcome, &findings).into_iter().filter(|verdict| !verdict.kept).collect();
        assert_eq!(broken, [], "SEED={seed}");
        assert_eq!(outcome.position_mm, [175.0, 40.0, 0.0], "SEED={seed}");
    }
}

#[test]
fn too_much_acceleration_loses_steps_and_is_reported() {
    let mut config = Config::default();
    config.settings.accel_mm_s2 = [40_000.0; 3];
    config.settings.max_rate_mm_min = [9_000.0; 3];
    let outcome = run(b"G0 X100\n", &config).unwrap();
    assert!(matches!(outcome.losses[0].cause, LossCause::PullOut { .. }), "{:?}", outcome.losses);
    assert_eq!(outcome.position_mm, [100.0, 0.0, 0.0], "the controller cannot know");
    assert!(outcome.drift_steps[0] < -1_000, "{:?}", outcome.drift_steps);
    let verdicts = verify::verdicts(&outcome, &verify::moves(&outcome).collect());
    let broken: Vec<_> = verdicts.iter().filter(|verdict| !verdict.kept).map(|verdict| verdict.promise).collect();
    assert_eq!(broken, ["no step lost", "final position exact"]);
}

#[test]
fn a_switch_that_never_closes_is_an_alarm_at_the_end_stop() {
    let mut config = Config::default();
    config.switches[Axis::X as usize] = SwitchFault::StuckOpen;
    let outcome = run(b"$H\nG0 X1\n", &config).unwrap();
    assert_eq!(outcome.state, State::Alarm(Alarm::SwitchNotFound { axis: Axis::X }));
    assert_eq!(outcome.alarm_code, Some(9));
    assert_eq!(outcome.losses[0].cause, LossCause::EndStop);
    assert_eq!(outcome.places_steps[Axis::X as usize], -150);
}

#[test]
fn a_switch_that_never_opens_is_an_alarm() {
    let mut config = Config::default();
    config.switches[Axis::Z as usize] = SwitchFault::StuckClosed;
    let outcome = run(b"$H\n", &config).unwrap();
    assert_eq!(outcome.state, State::Alarm(Alarm::SwitchStuck { motor: Motor::first(Axis::Z) }));
}

#[test]
fn a_refused_line_ends_the_program_there() {
    let outcome =
        run(b"G0 X1\nG41\nG0 X2\n", &Config { streaming: crate::Streaming::SendAndWait, ..Config::default() }).unwrap();
    assert_eq!((outcome.refusals[0].line, outcome.refusals[0].code), (2, 20));
    assert!(outcome.cut_short);
    assert_eq!(outcome.position_mm[0], 1.0);
}

/// The dwells are longer than the interval of progress reports, and the pauses wait for the operator.
#[test]
fn dwells_and_pauses_are_played_through() {
    let mut reported = Vec::new();
    let program = Program::read(b"G4 P5\nG0 X1\nM0\nG4 P0.5\nG0 X2\n").unwrap();
    let outcome = run_watched(program, &Config::default(), Flash::blank(), &mut |now| reported.push(now)).unwrap();
    assert_eq!((outcome.position_mm[0], outcome.pauses[0].line, outcome.pauses.len()), (2.0, 3, 1));
    assert!(
        reported.len() >= 5 && reported.is_sorted_by_key(|now| now.answered) && reported.last().unwrap().answered >= 1
    );
}

#[test]
fn a_dialogue_in_steps() {
    let mut sim = Sim::new(&Config::default());
    sim.run_until_idle().unwrap();
    assert!(sim.replies()[0].starts_with("Grbl 1.1h"));
    sim.send(b"G0 X100\n");
    sim.run_for(Duration::from_millis(1_200)).unwrap();
    sim.send(b"?");
    sim.run_for(Duration::from_millis(1)).unwrap();
    let replies = sim.replies();
    assert_eq!(replies[0], "ok");
    assert!(replies[1].starts_with("<Run|MPos:"), "{replies:?}");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.counted_steps(), [5_000, 0, 0]);
    assert_eq!(sim.places_steps()[0], 1_750 + 5_000);
}

#[test]
fn an_abrupt_stop_at_speed_overshoots() {
    // 60 kg at 48 mm/s.
    let heavy = Some("32,60".parse().unwrap());
    let mut sim = Sim::new(&Config { loads: [heavy; 3], ..Config::default() });
    sim.send(b"G0 X100\n");
    sim.run_for(Duration::from_millis(1_500)).unwrap();
    sim.set_emergency_stop(true);
    sim.run_until_state(|state| state == State::Alarm(Alarm::EmergencyStop)).unwrap();
    sim.run_for(Duration::from_millis(100)).unwrap();
    let outcome = sim.outcome();
    assert!(matches!(outcome.losses[0].cause, LossCause::Overshoot { .. }), "{:?}", outcome.losses);
    let drift_steps = outcome.drift_steps[0];
    assert!(drift_steps > 100 && drift_steps % 32 == 0, "{drift_steps}: whole periods of four full steps");
}

/// The third move begins after 2.1 s, and was handed out 45 ms earlier.
#[test]
fn of_moves_that_a_stop_forestalls_there_is_no_record() {
    let mut sim = Sim::new(&Config::default());
    sim.send("G91 G1 F600 X10\nX10\nX10\nX10\nX10\n".as_bytes());
    sim.run_for(Duration::from_millis(2_080)).unwrap();
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_millis(100)).unwrap();
    let outcome = sim.outcome();
    assert_eq!(outcome.moves.len(), 2, "{:?}", outcome.moves);
    assert_eq!(outcome.moves[1].end_steps, outcome.position_steps);
}

/// A machine that differs from the default one, with different axes.
const FAST: &str = "$100=80\n$101=160\n$102=400\n$110=12000\n$111=9000\n$112=1500\n$120=2000\n$121=800\n$122=300\n\
                    $130=200\n$131=120\n$132=60\n";

fn fast() -> isostep_console::Settings {
    crate::settings::read("fast", FAST.as_bytes(), Port::Pio, isostep_motion::DriverTiming::DRV8825).unwrap()
}

/// Homes, then moves to the ends of the travel and back, each axis at its top speed.
const ENDS: &str = "$H\nG0 X200\nG0 Y120\nG0 Z60\nG0 X0 Y0 Z0\n";

/// True if each axis is at the pull-off of 2 mm from its switch, within the steps that were made during its bounce.
fn stands_at_zero(outcome: &Outcome) -> bool {
    outcome.places_steps.iter().zip([160, 320, 800]).all(|(&place, zero)| place.abs_diff(zero) <= 5)
}

fn broken(outcome: &Outcome) -> Vec<String> {
    let verdicts = verify::verdicts(outcome, &verify::moves(outcome).collect()).into_iter();
    verdicts.filter(|verdict| !verdict.kept).map(|verdict| format!("{}: {}", verdict.promise, verdict.detail)).collect()
}

#[test]
fn the_machine_is_as_its_settings_say() {
    let outcome = run(ENDS.as_bytes(), &Config { settings: fast(), ..Config::default() }).unwrap();
    assert_eq!(broken(&outcome), [""; 0]);
    assert!(stands_at_zero(&outcome), "{:?}", outcome.places_steps);
}

#[test]
fn a_machine_follows_what_a_program_sets_at_rest() {
    let outcome = run(format!("G0 X3\nG4 P0.1\n{FAST}{ENDS}").as_bytes(), &Config::default()).unwrap();
    assert_eq!(broken(&outcome), [""; 0]);
    assert!(stands_at_zero(&outcome), "{:?}", outcome.places_steps);
}

#[test]
fn drivers_and_switches_are_wired_as_the_settings_say() {
    let mut config = Config::default();
    for (number, value) in [(3, 5.0), (4, 1.0), (5, 1.0), (23, 5.0)] {
        assert!(config.settings.set(number, value));
    }
    // Y homes in the positive direction.
    let outcome = run(b"$H\nG0 X20 Y-30 Z5\n", &config).unwrap();
    assert_eq!(broken(&outcome), [""; 0]);
    assert_eq!(outcome.carriage_mm(), [22.0, 32.0, 7.0]);
}

#[test]
fn without_edges_a_program_takes_the_same_time() {
    let config = Config { settings: fast(), ..Config::default() };
    let program = "$22=0\nG90 G1 X5 Y3 F1000\nX5.01\nY2.99 Z1\nG4 P0.5\nG0 X0 Y0 Z0\n";
    let whole = run(program.as_bytes(), &config).unwrap();
    let only_time = Config { only_time: true, keep_record: false, ..config };
    let light = run(program.as_bytes(), &only_time).unwrap();
    assert!(light.edges.is_empty() && light.waves.is_empty() && light.moves.is_empty());
    assert_eq!((whole.motion_s, whole.position_steps), (light.motion_s, light.position_steps));
    let first = &whole.moves[0];
    let last = whole.moves.last().unwrap();
    let expected_s = (last.start_ns - first.start_ns) as f64 * 1e-9 + last.plan_s;
    assert_eq!(whole.motion_s, expected_s);
}

#[test]
fn a_line_behind_one_that_silences_the_console_names_it() {
    let rows = [
        ("G0 X1\nG4 P0\n$SLP\nG0 X2\n", "line 4 `G0 X2`", "line 3 `$SLP` puts the machine to sleep"),
        ("$RST=$\nG0 X2\n", "line 2 `G0 X2`", "line 1 `$RST=$` resets the console"),
        ("$C\nG0 X1\n$C\nG0 X2\n", "line 4 `G0 X2`", "line 3 `$C` ends checking and resets the console"),
    ];
    for (program, unanswered, silencer) in rows {
        let error = run(program.as_bytes(), &Config::default()).unwrap_err().to_string();
        let expected = format!("{unanswered} was never answered, as {silencer}: take it out of the program");
        assert_eq!(error, expected, "{program}");
    }
}

/// Two consoles, one of which resets while the line of the other begins to move.
#[test]
fn a_reset_leaves_no_console_with_another_idea_of_the_place() {
    for section_max_ns in [None, Some(0), Some(20_000), Some(200_000)] {
        let mut sim = Sim::new(&Config { second_console: true, section_max_ns, ..Config::default() });
        sim.run_until_idle().unwrap();
        sim.send_to(0, &[RESET]);
        sim.send_to(1, b"G1 X5 Y2 F600\n");
        sim.run_until_idle().unwrap();
        let [x, y, z] = sim.machine().position_steps();
        sim.send_to(1, b"G91 G1 X1 F600\n");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.machine().position_steps(), [x + 50, y, z], "{section_max_ns:?}");
    }
}

#[test]
fn an_alarm_wakes_no_sleeping_machine() {
    let mut sim = Sim::new(&Config::default());
    sim.send(b"$SLP\n");
    sim.run_until_idle().unwrap();
    sim.set_emergency_stop(true);
    sim.run_until_idle().unwrap();
    sim.set_emergency_stop(false);
    sim.run_until_idle().unwrap();
    sim.replies();
    sim.send(b"?");
    sim.run_until_idle().unwrap();
    assert!(sim.replies()[0].starts_with("<Sleep|"), "what it is told waits for a reset");
    sim.send(&[RESET]);
    sim.run_until_idle().unwrap();
    sim.replies();
    sim.send(b"$X\nG0 X1\n");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["[MSG:Caution: Unlocked]", "ok", "ok"]);
}

/// A host that opens the console again discards the line that homes or probes; the machine does not.
#[test]
fn a_host_that_comes_back_finds_the_machine_where_it_stands() {
    let plate = Some("Z,10,below".parse().unwrap());
    for line in ["$HX", "G38.2 Z-10 F600", "G2 X0 Y0 I2 F600"] {
        let mut sim = Sim::new(&Config { plate, ..Config::default() });
        sim.send(format!("{line}\n").as_bytes());
        sim.run_for(Duration::from_millis(300)).unwrap();
        assert!(sim.steps() != [0; 3], "{line}");
        sim.open_console();
        sim.run_until_idle().unwrap();
        let [x, y, z] = sim.machine().position_steps();
        sim.send(b"G91 G1 X1 F600\n");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.machine().position_steps(), [x + 50, y, z], "{line}");
    }
}

#[test]
fn a_machine_that_is_dropped_is_gone() {
    let mut sim = Sim::new(&Config { second_console: true, section_max_ns: Some(1_000), ..Config::default() });
    sim.send(b"G0 X5\n");
    sim.run_for(Duration::from_millis(100)).unwrap();
    let (machine, world) = (Rc::downgrade(&sim.machine), Rc::downgrade(&sim.world));
    drop(sim);
    assert!(machine.upgrade().is_none() && world.upgrade().is_none(), "something still holds it");
}

/// Somebody else on the wire, or noise, has changed a driver's register. It is read back within a second, as it was set last, for as
/// long as the machine is on.
#[test]
fn a_register_that_is_not_as_it_was_set_is_reported() {
    let board = Board::SkrPico;
    let mut sim = Sim::new(&Config { board, driver: board.driver(), ..Config::default() });
    let world = sim.world.clone();
    let mut said = |line: &str| {
        sim.send(format!("{line}\n").as_bytes());
        sim.run_for(Duration::from_millis(1_500)).unwrap();
        (sim.replies(), sim.driver_setup(1).unwrap().microsteps)
    };
    said("");
    for (line, microsteps, before) in [("", 16, 8), ("$151=32", 32, 16), ("$151=8", 8, 32), ("", 8, 32)] {
        assert_eq!(said(line).1, microsteps, "{line}");
        assert!(said("").0.iter().all(|line| line == "ok"), "it is as it was set");
        let changed = CHOPCONF::from(0x1000_0053 | (8 - u32::ilog2(before)) << 24);
        world.borrow_mut().exchange_with_drivers(WriteRequest::new(2, changed).bytes());
        let (heard, is_set) = said("");
        assert!(heard.iter().any(|line| line.starts_with("[MSG:Y driver does not take its settings: ")), "{heard:?}");
        assert!(heard.contains(&"ALARM:17".to_owned()) && is_set == microsteps, "{heard:?}");
        assert!(said("$X").0.contains(&"ok".to_owned()));
    }
}

/// A machine whose M6 is `$341=mode`.
fn changing(mode: f32) -> Config {
    let mut config = Config::default();
    config.settings = config.settings.with(341, mode).unwrap();
    config
}

#[test]
fn a_change_of_the_tool_is_resumed_and_named() {
    let program = b"(T2 D=6 flat)\n$H\nM6 T2\nG0 X1\nT3\nM6 (V-bit)\n";
    for streaming in [Streaming::SendAndWait, Streaming::CharacterCounting { window_bytes: 128 }] {
        for mode in [0.0, 1.0, 2.0] {
            let outcome = run(program, &Config { streaming, ..changing(mode) }).unwrap();
            let pauses: Vec<_> = outcome.pauses.iter().map(|pause| (pause.line, pause.comment.as_deref())).collect();
            assert_eq!(pauses, [(3, Some("D=6 flat")), (6, Some("V-bit"))], "$341={mode}");
            assert!(outcome.pauses[1].words.as_ref().unwrap().starts_with("M6: put in tool 3"), "$341={mode}");
            assert!(outcome.refusals.is_empty() && outcome.position_mm == [1.0, 0.0, 0.0], "$341={mode}");
        }
    }
}

#[test]
fn a_tool_is_measured_at_a_plate_and_without_one_the_run_ends() {
    let program = b"$H\nG10 L2 P9 X50 Y40 Z45\nM6 T2\nG0 X1\n";
    let config = changing(3.0);
    let error = run(program, &config).unwrap_err().to_string();
    assert!(
        error.starts_with("line 3 `M6 T2`: the tool cannot be measured at G59.3 ($341=3): The probe met"),
        "{error}"
    );
    let plate = Some("Z,20,below".parse().unwrap());
    let outcome = run(program, &Config { plate, ..config }).unwrap();
    assert_eq!((outcome.pauses.len(), outcome.position_mm), (1, [1.0, 0.0, 0.0]));
}
