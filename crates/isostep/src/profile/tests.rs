//! Tests the verb as a user runs it, without the shell.

use clap::Parser;
use isostep_generators::{FrequencyProfile, FrequencyRamp};
use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile};
use isostep_report::speed_profiles::{differences, peak, peak_mean};

use super::*;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: Args,
}

fn parsed(line: &str) -> Args {
    try_parsed(line).unwrap_or_else(|error| panic!("{line}: {error}"))
}

fn try_parsed(line: &str) -> Result<Args, clap::Error> {
    Cli::try_parse_from(["profile"].into_iter().chain(line.split_whitespace())).map(|cli| cli.args)
}

fn curves(line: &str) -> Vec<Curve> {
    plan(&parsed(line)).unwrap_or_else(|error| panic!("{line}: {error}")).0
}

/// The error that the verb prints for a command line that cannot work.
fn refusal(line: &str) -> String {
    match try_parsed(line) {
        Err(error) => error.to_string(),
        Ok(args) => format!("{:#}", plan(&args).err().unwrap_or_else(|| panic!("{line} was planned"))),
    }
}

/// The numbers in the CSV of steps. An empty field becomes NaN.
fn read_csv(curve: &Curve) -> Vec<[f64; 4]> {
    let mut bytes = Vec::new();
    files::write_csv(curve, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    assert_eq!(head, "step,t_us,period_us,frequency_hz");
    let row = |line: &str| {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect();
        fields.try_into().unwrap()
    };
    rows.lines().map(row).collect()
}

const TABLE_1: &str = "--steps 120 --ramp-steps 24 --max-period-us 4000 --min-period-us 1500";
const MACHINE: &str = "--steps 4000 --top-speed 2400 --accel 2500";

#[test]
fn a_csv_of_fonseca_campos_2023_loses_nothing() {
    for (speed_profile, name) in FrequencyRamp::ALL.map(|speed_profile| (speed_profile, speed_profile.name())) {
        let profile = FrequencyProfile::plan(speed_profile, 120, 24, 4000.0, 1500.0).unwrap();
        let rows = read_csv(&curves(&format!("--speed-profile {name} {TABLE_1}"))[0]);
        assert_eq!(rows.len(), 120);
        for ((row, edge_s), i) in rows.iter().zip(profile.edges_s()).zip(1_u32..) {
            let hz = profile.frequency_hz(i);
            assert_eq!(*row, [f64::from(i), edge_s * 1e6, 1e6 / hz, hz], "{name}");
        }
        assert_eq!(rows[0][1..], [0.0, 4000.0, 250.0]);
    }
}

#[test]
fn a_csv_as_printed_has_even_microseconds() {
    let rows = read_csv(&curves(&format!("--speed-profile logarithmic {TABLE_1} --truncated"))[0]);
    let last = rows.last().unwrap();
    // The value is from the paper's listing, programmed in another language.
    assert_eq!(last[1] + last[2], 200_564.0);
    assert!(rows.iter().all(|row| row[1] % 2.0 == 0.0 && row[2] % 2.0 == 0.0));
}

#[test]
fn a_csv_of_the_machine_is_the_closed_form() {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 2_400.0,
        accel_steps_s2: 2_500.0,
        decel_steps_s2: 2_500.0,
        jerk_steps_s3: f64::INFINITY,
    };
    let profile = Profile::plan(4_000.0, 0.0, 0.0, &limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid).unwrap();
    let rows = read_csv(&curves(&format!("--speed-profile trapezoid {MACHINE}"))[0]);
    assert_eq!(rows.len(), 4_000);
    let first_us = profile.time_at(0.5) * 1e6;
    for row in &rows {
        assert_eq!(row[1], profile.time_at(row[0] - 0.5) * 1e6 - first_us);
    }
    assert!(rows.windows(2).all(|pair| (pair[0][1] + pair[0][2] - pair[1][1]).abs() < 1e-6));
    let last = rows.last().unwrap();
    assert!(last[2].is_nan() && last[3].is_nan(), "the last step has no next one");
}

/// By hand, eq 13: c_0 = 1e6/326 = 3067.5. With services every 100 us, the first step to the second takes 31 of them
/// less 1.
#[test]
fn generators_stand_beside_the_closed_form() {
    let line = "--speed-profile trapezoid --steps 4096 --start-speed 326 --top-speed 1304 --accel 1304 --decel 652";
    let all = curves(&format!("{line} --generator exact,time-per-step,time-per-step-corrected,steps-per-time"));
    let names: Vec<&str> = all.iter().map(|curve| curve.name.as_str()).collect();
    assert_eq!(names, ["trapezoid", "time-per-step", "time-per-step-corrected", "steps-per-time"]);
    assert_eq!(all[1].steps[0].period_us, Some(3_067.0));
    assert_eq!(all[3].steps[0].period_us.unwrap() % 100.0, 0.0);
    for curve in &all {
        assert_eq!(curve.steps.len(), 4_096);
        assert!((curve.first_to_last_s() - all[0].first_to_last_s()).abs() < 0.02, "{}", curve.name);
    }
    assert_eq!(
        curves(&format!("{line} --generator time-per-step --tick-hz 2000"))[0].steps[0].period_us,
        Some(3_000.0)
    );
}

#[test]
fn the_four_speed_profiles_are_planned_as_the_options_say() {
    let by_index = &curves(&format!("--speed-profile linear {TABLE_1}"))[0];
    let by_displacement = &curves(&format!("--speed-profile linear {MACHINE} --start-speed 100"))[0];
    assert!(by_index.exact.is_none() && by_displacement.exact.is_some());
}

/// By hand: a trapezoid of 2500 steps/s2 to 2400 steps/s accelerates for 0.96 s. Its jerk has no bound. An S-curve has
/// a bounded jerk and takes longer.
#[test]
fn the_table_has_every_figure() {
    let text = table::table(&curves(&format!("--speed-profile trapezoid,s-curve,sine {MACHINE} --jerk 12500")));
    let row = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {text}"));
    let cells = |name: &str| row(name)[46..].split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(cells("")[..3], ["trapezoid", "s-curve", "sine"]);
    assert_eq!(cells("accelerating, s")[0], "0.960000");
    assert_eq!(cells("peak acceleration, steps/s2")[..2], ["2500", "2500"]);
    assert_eq!(cells("peak jerk, steps/s3")[..2], ["unbounded", "12500"]);
    assert_eq!(cells("  the fastest saves")[..2], ["0.0", "%"]);
}

#[test]
fn a_single_speed_profile_shows_its_first_and_last_steps() {
    let text = table::table(&curves(&format!("--speed-profile linear {TABLE_1}")));
    for part in ["24 + 71 + 25", "0.222678", "         1              0.000         4000.000", "...", "\n       120"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn pictures_and_pages_have_every_speed_profile() {
    let all = curves(&format!("--speed-profile linear,quadratic,sinusoidal,logarithmic {TABLE_1}"));
    let picture = files::plot(&PlotKind::Picture, &all, Derivatives::Exact, "", "");
    assert!(picture.starts_with("<svg") && !picture.contains("var(") && picture.matches("<polyline").count() > 16);
    let page = files::plot(&PlotKind::Page, &all, Derivatives::Paper, "N = 120", "isostep profile");
    for part in ["<svg", "N = 120", "isostep profile", "second-order differences", "logarithmic", "9.9 %"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(PlotKind::of("a.svg".as_ref()).is_ok() && PlotKind::of("a.html".as_ref()).is_ok());
    assert!(PlotKind::of("a.png".as_ref()).err().unwrap().to_string().contains("such as profile.svg"));
}

#[test]
fn exact_and_papers_derivatives_agree_where_the_steps_are_dense() {
    let curve = &curves(&format!("--speed-profile s-curve {MACHINE} --jerk 12500"))[0];
    let exact = kinematics::curves(curve, Derivatives::Exact);
    let paper = kinematics::curves(curve, Derivatives::Paper);
    assert!((peak(&exact.speed) / peak(&paper.speed) - 1.0).abs() < 1e-3);
    assert!((peak(&exact.accel) / peak(&paper.accel) - 1.0).abs() < 0.02);
}

/// Each case is refused with its own message, which names the bound or the remedy.
#[test]
fn what_cannot_work_is_refused() {
    let cases = [
        ("--speed-profile linear --steps 120 --ramp-steps 61 --max-period-us 4e3 --min-period-us 1e3", "at most 60"),
        ("--speed-profile linear --steps 120 --ramp-steps 1 --max-period-us 4e3 --min-period-us 1e3", "at least 2"),
        ("--speed-profile linear --steps 120 --ramp-steps -3 --max-period-us 4e3 --min-period-us 1e3", "0 to 1000000"),
        (
            "--speed-profile linear --steps 120 --ramp-steps 24 --max-period-us 1e3 --min-period-us 4e3",
            "above the largest, 1000 us",
        ),
        (
            "--speed-profile linear --steps 120 --ramp-steps 24 --max-period-us NaN --min-period-us 1e3",
            "NaN us is outside",
        ),
        (
            "--speed-profile linear --steps 120 --ramp-steps 24 --max-period-us 4e3 --min-period-us -1",
            "-1 us is outside",
        ),
        ("--speed-profile linear --steps 0 --ramp-steps 24", "from 1 to 1000000"),
        ("--speed-profile linear --steps -120 --ramp-steps 24", "from 1 to 1000000"),
        ("--speed-profile linear --steps NaN", "from 1 to 1000000"),
        ("--steps 120", "such as --speed-profile linear"),
        ("--speed-profile linear", "such as --steps 120"),
        ("--speed-profile linear --steps 120", "such as --ramp-steps 24"),
        ("--speed-profile linear --steps 120 --ramp-steps 24 --min-period-us 1e3", "such as --max-period-us 4000"),
        ("--speed-profile straight --steps 120", "possible values: trapezoid"),
        ("--speed-profile trapezoid --steps 120", "such as --top-speed 2400"),
        ("--speed-profile trapezoid --steps 120 --top-speed 2400", "such as --accel 2500"),
        ("--speed-profile s-curve --steps 120 --top-speed 2400 --accel 2500", "such as --jerk 25000"),
        ("--speed-profile trapezoid --steps 120 --top-speed NaN --accel 2500", "NaN steps/s is outside"),
        ("--speed-profile trapezoid --steps 120 --top-speed 2400 --accel 0", "must be above 0"),
        ("--speed-profile trapezoid --steps 120 --ramp-steps 24", "give --top-speed and --accel"),
        ("--speed-profile linear --steps 120 --ramp-steps 24 --accel 9", "give the options of one of them"),
        ("--speed-profile trapezoid --steps 120 --top-speed 9 --accel 9 --jerk 9", "--speed-profile s-curve"),
        (
            "--speed-profile sine --steps 120 --top-speed 9 --accel 9 --generator steps-per-time",
            "add --speed-profile trapezoid",
        ),
        (
            "--speed-profile trapezoid --steps 9 --top-speed 9 --accel 9 --thirds --generator steps-per-time",
            "leave out --thirds",
        ),
        ("--speed-profile trapezoid --steps 120 --top-speed 9 --accel 9 --tick-hz 9", "time-per-step"),
        ("--speed-profile trapezoid --steps 120 --top-speed 9 --accel 9 --service-hz 9", "steps-per-time"),
        (
            "--speed-profile trapezoid --steps 9 --top-speed 90 --accel 9 --generator time-per-step",
            "cannot start at 0 steps/s",
        ),
        (
            "--speed-profile trapezoid --steps 9 --start-speed 9 --top-speed 2e4 --accel 9 --generator steps-per-time",
            "--service-hz",
        ),
        ("--speed-profile linear --steps 120 --top-speed 2400 --accel 2500", "start speed"),
    ];
    for (line, wanted) in cases {
        let text = refusal(line);
        assert!(text.contains(wanted), "{line}: {text}");
    }
}

#[test]
fn help_teaches_with_lines_that_work() {
    use clap::CommandFactory;
    // Without wrapping: another crate of the workspace may enable clap's line wrapping.
    let help = Cli::command().term_width(0).render_long_help().to_string();
    let examples: Vec<String> = help
        .replace("\\\n", " ")
        .lines()
        .filter(|line| line.contains("  isostep profile"))
        .map(str::to_owned)
        .collect();
    assert_eq!(examples.len(), 5, "{help}");
    for example in examples {
        let words = example.split_whitespace().skip(2);
        let words: Vec<&str> = words
            .take_while(|word| word.starts_with("--") || !["Fonseca-Campos", "Stoychitch's", "as"].contains(word))
            .collect();
        curves(&words.join(" "));
    }
}

/// Near standstill, steps are far apart. Repeated differences show a jerk that the speed profile does not have; means over steps
/// do not.
#[test]
fn the_table_shows_no_jerk_that_a_speed_profile_does_not_have() {
    let curves = curves("--speed-profile s-curve,sine --steps 4000 --top-speed 2400 --accel 2500 --jerk 12500");
    for curve in &curves {
        let exact = curve.exact.as_ref().unwrap();
        let (accel, jerk) = (peak_mean::<3>(curve), peak_mean::<4>(curve));
        assert!((0.99..=1.0 + 1e-5).contains(&(accel / exact.peak_accel())), "{}: {accel}", curve.name);
        assert!((0.99..=1.0 + 1e-5).contains(&(jerk / exact.peak_jerk())), "{}: {jerk}", curve.name);
        assert!(peak(&differences(curve).jerk) > 1.4 * exact.peak_jerk());
    }
    let text = table::table(&curves);
    let line = text.lines().find(|line| line.contains("mean over 4 steps")).unwrap();
    assert!(line.contains("12500"), "{text}");
}
