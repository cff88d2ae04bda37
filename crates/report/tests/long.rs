//! A program of many lines: the output about it stays small and says what it leaves out.

use isostep_report::{Figures, Listed, MoveFigures, again, pictures};
use isostep_sim::{Config, run};

#[path = "../examples/raster.rs"]
mod raster;

const LINES: usize = 20_000;
/// The largest size of a page and of a file of figures, bytes.
const BYTES_MAX: usize = 5_000_000;

#[test]
fn of_a_long_program_little_is_written() {
    let mut program = Vec::new();
    raster::write(LINES - 1, &mut program).unwrap();
    // After all the short moves.
    program.extend(b"X90\n");
    assert_eq!(program.iter().filter(|byte| **byte == b'\n').count(), LINES);
    let mut config = Config { keep_waves: false, start_mm: [5.0; 3], ..Config::default() };
    (config.settings.soft_limits, config.settings.hard_limits) = (false, false);
    let outcome = run(&program, &config).unwrap();
    assert!(outcome.waves.is_empty());

    let figures = Figures::new("raster", &outcome);
    assert_eq!(figures.broken().count(), 0);
    assert_eq!(figures.moves_total, LINES - 4);
    assert!(figures.lengths.most_mm > 80.0 && (figures.lengths.median_mm - 0.1).abs() < 1e-9);
    assert!((1_000..=2_000).contains(&figures.moves.len()), "{}", figures.moves.len());
    assert!(figures.moves.is_sorted_by_key(|one| one.number));
    let json = serde_json::to_string_pretty(&figures).unwrap();
    let (lines, other) = again::other_rule(&outcome).expect("its rows end in corners");
    let other = run(&lines.join(&b'\n'), &other).unwrap();
    let page = pictures::page(&outcome, &pictures::BothRules::of(&outcome, Some(other)), &figures).html();
    assert!(json.len() < BYTES_MAX && page.len() < BYTES_MAX, "{} and {} bytes", json.len(), page.len());
    assert!(page.contains("moves are left out"));
    assert!(page.contains("Blends (G64), this run: at most 1.0"), "though all corners are stops");

    let all = Figures::listing("raster", &outcome, Listed::All);
    assert_eq!(all.moves.len(), LINES - 4);
    let values: [fn(&MoveFigures) -> f64; 2] = [MoveFigures::duration_s, MoveFigures::error_max_ns];
    for value in values {
        let mut most: Vec<f64> = all.moves.iter().map(value).collect();
        most.sort_by(|one, other| other.total_cmp(one));
        let listed = figures.moves.iter().filter(|one| value(one) >= most[499]).count();
        assert!(listed >= 500, "{listed} of the 500 that last longest, or are farthest from their instants");
    }
}
