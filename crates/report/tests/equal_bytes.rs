//! The same run gives the same bytes.

use isostep_report::{Figures, pictures};
use isostep_sim::{Config, run};

/// The figures and the page of a run.
fn files(config: &Config) -> [Vec<u8>; 2] {
    let outcome = run(include_bytes!("../../../programs/parking.nc"), config).unwrap();
    let figures = Figures::new("parking.nc", &outcome);
    let page = pictures::page(&outcome, &pictures::BothRules::of(&outcome, None), &figures).html();
    [serde_json::to_vec(&figures).unwrap(), page.into_bytes()]
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
