//! A program that is run and looked at piece by piece is the same as the whole, and its memory stays bounded.

use embassy_time::{Duration, Instant};
use isostep_sim::program::Program;
use isostep_sim::verify::{Gathered, moves, verdicts};
use isostep_sim::world::Edge;
use isostep_sim::{Config, Outcome, Sim, Streamed, run};
use isostep_trials::cases;

/// Programs with homing, arcs, blends, exact stops, a shaper, an alarm, a refusal, and one that waits for a person.
const PROGRAMS: [&[u8]; 7] = [
    include_bytes!("../../../programs/parking.nc"),
    include_bytes!("../../../programs/arcs.nc"),
    include_bytes!("../../../programs/square.nc"),
    b"$950=2\n$960=40\n$951=1\n$961=30\nG21 G91\nG1 X10 Y3 F2400\nX2 Y8\nX-5\nG4 P0.2\nY-4\n",
    b"$21=1\nG21 G91\nG1 X-20 F1200\nX-30\nY5\n",
    b"G21 G91\nG1 X5 F1200\nG42\nX5\n",
    b"G21 G91\nG61 G1 X5 F1200\nY2\nM0\nX5\nG64 P0.2\nY2\nX2\n",
];

/// All edges of a run that is cut after every `every`, and what was gathered from its pieces, with its end.
fn in_pieces(program: &[u8], config: &Config, every: Duration) -> (Vec<Edge>, Gathered, Outcome, usize) {
    let lines = Program::read(program).unwrap();
    let mut streamed = Streamed::new(Sim::new(config), lines);
    let (mut gathered, mut edges, mut most) = (Gathered::default(), Vec::new(), 0);
    let mut add = |piece: &Outcome| {
        gathered.add(piece);
        edges.extend_from_slice(&piece.edges);
        most = most.max(piece.edges.len() + piece.moves.len() + piece.waves.len());
    };
    let mut horizon = Instant::from_ticks(0);
    loop {
        horizon += every;
        let has_ended = streamed.run_until(horizon).unwrap();
        add(&streamed.take_piece());
        if has_ended {
            break;
        }
    }
    let end = streamed.end().unwrap();
    add(&end);
    (edges, gathered, end, most)
}

#[test]
fn pieces_together_are_the_whole() {
    for (number, program) in PROGRAMS.into_iter().enumerate() {
        let whole = run(program, &Config::default()).unwrap();
        let expected = verdicts(&whole, &moves(&whole).collect());
        for every_ms in (0..cases(3, 30)).map(|case| 7 + 97 * case as u64) {
            let (edges, gathered, end, _) = in_pieces(program, &Config::default(), Duration::from_millis(every_ms));
            assert_eq!(edges, whole.edges, "program {number}, every {every_ms} ms");
            let found = gathered.verdicts(&end);
            assert_eq!(found, expected, "program {number}, every {every_ms} ms");
            let totals = (gathered.edges(), gathered.homing_ns(), end.duration_ns);
            assert_eq!(totals, (whole.edges.len(), whole.homing_ns(), whole.duration_ns));
            assert_eq!(
                (end.refusals, end.pauses, end.alarm_code),
                (whole.refusals.clone(), whole.pauses.clone(), whole.alarm_code)
            );
        }
    }
}

/// Chains of moves that never stop, with edges and without.
#[test]
fn a_long_program_takes_no_more_memory_than_a_short_one() {
    let program = |moves: usize| {
        let lines = (0..moves).map(|number| ["X0.2\n", "Y0.2\n", "X-0.2\n", "Y-0.2\n"][number % 4]);
        format!("G21 G91 G1 F2400\n{}", lines.collect::<String>()).into_bytes()
    };
    for only_time in [false, true] {
        let config = Config { only_time, ..Config::default() };
        let most = |count: usize| {
            let (_, gathered, _, most) = in_pieces(&program(count), &config, Duration::from_millis(250));
            assert_eq!(gathered.moves(), count);
            most
        };
        let (short, long) = (most(1_000), most(cases(4_000, 20_000) as usize));
        assert!(long <= short + short / 4, "{long} instead of {short}");
    }
}
