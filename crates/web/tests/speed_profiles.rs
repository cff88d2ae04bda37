//! The speed profiles on the page are those of `isostep profile`.

use isostep_profile::SpeedProfile;
use isostep_web::speed_profiles::{self, Asked};
use serde_json::{Value, json};

const ASKED: Asked = Asked {
    distance_mm: 80.0,
    steps_per_mm: 50.0,
    start_mm_s: 0.0,
    top_mm_s: 48.0,
    accel_mm_s2: 50.0,
    decel_mm_s2: 50.0,
    jerk_mm_s3: 250.0,
};

fn said(start_mm_s: f64) -> Value {
    serde_json::from_str(&speed_profiles::of(&Asked { start_mm_s, ..ASKED }).unwrap()).unwrap()
}

/// `isostep profile --speed-profile trapezoid,s-curve,sine --steps 4000 --top-speed 2400 --accel 2500 --jerk 12500`
#[test]
fn figures_are_those_that_the_tool_prints() {
    let speed_profiles = said(0.0);
    assert_eq!(speed_profiles["names"], json!(["trapezoid", "s-curve", "sine"]));
    let row = |name: &str| {
        let rows = speed_profiles["rows"].as_array().unwrap();
        rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("no {name} in {rows:?}"))["cells"].clone()
    };
    assert_eq!(row("total, s"), json!(["2.626667", "2.826667", "3.174631"]));
    assert_eq!(row("peak jerk, steps/s3")[0], "unbounded");
    assert_eq!(row("peak jerk, steps/s3")[1], "12500");
}

/// Those over displacement need a start speed, and say so.
#[test]
fn a_speed_profile_that_cannot_says_why() {
    let refused = said(0.0)["refused"].as_array().unwrap().clone();
    assert_eq!(refused.len(), 4, "{refused:?}");
    assert!(refused[0]["words"].as_str().unwrap().contains("start"), "{refused:?}");
    assert_eq!(said(2.0)["names"].as_array().unwrap().len(), SpeedProfile::ALL.len());
}

/// The area under the speed is the distance.
#[test]
fn curves_go_the_whole_distance() {
    for curve in said(2.0)["curves"].as_array().unwrap() {
        let column = |name: &str| -> Vec<f64> { serde_json::from_value(curve[name].clone()).unwrap() };
        let (times, speed) = (column("times"), column("speed"));
        let pairs = times.windows(2).zip(speed.windows(2));
        let distance_mm: f64 = pairs.map(|(t, v)| (t[1] - t[0]) * (v[0] + v[1]) / 2.0).sum();
        assert!((distance_mm - 80.0).abs() < 0.05, "{}: {distance_mm} mm", curve["name"]);
    }
}

#[test]
fn a_move_without_steps_is_refused() {
    let trouble = speed_profiles::of(&Asked { distance_mm: 0.0, ..ASKED }).unwrap_err();
    assert!(trouble.words.contains("1 to 1000000"), "{trouble}");
}
