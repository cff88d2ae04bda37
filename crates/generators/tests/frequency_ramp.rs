//! Fonseca-Campos's profiles, compared with its equations as they are printed, and with numbers worked out by hand.

use core::f64::consts::PI;

use isostep_generators::{FrequencyError, FrequencyProfile, FrequencyRamp, TruncatedProfile};
use proptest::prelude::*;

use FrequencyRamp::{Linear, Logarithmic, Quadratic, Sinusoidal};

/// N, p_N, tau_max and tau_min of Fonseca-Campos's tables 1, 2, 4 and 6.
const TABLES: [(u32, u32, u32, u32); 4] =
    [(120, 24, 4000, 1500), (1666, 166, 4000, 400), (2000, 300, 5000, 300), (2000, 400, 3000, 300)];

fn exact(frequency_ramp: FrequencyRamp, table: (u32, u32, u32, u32)) -> FrequencyProfile {
    let (n, p, max, min) = table;
    FrequencyProfile::plan(frequency_ramp, n, p, f64::from(max), f64::from(min)).unwrap()
}

fn truncated(frequency_ramp: FrequencyRamp, table: (u32, u32, u32, u32)) -> TruncatedProfile {
    let (n, p, max, min) = table;
    TruncatedProfile::plan(frequency_ramp, n, p, f64::from(max), f64::from(min)).unwrap()
}

/// Eqs 5-8, constants and branches as printed.
fn printed_hz(frequency_ramp: FrequencyRamp, (n, p, max, min): (u32, u32, u32, u32), i: u32) -> f64 {
    let (f_min, f_max) = (1.0 / (f64::from(max) * 1e-6), 1.0 / (f64::from(min) * 1e-6));
    let [i_, n_, p_] = [i, n, p].map(f64::from);
    if p < i && i < n - p {
        return f_max;
    }
    let rises = i <= p;
    match frequency_ramp {
        Linear if rises => (f_max - f_min) / (p_ - 1.0) * (i_ - 1.0) + f_min,
        Linear => (f_min - f_max) / p_ * (i_ - n_) + f_min,
        Quadratic if rises => {
            let a2 = (f_max - f_min) / (p_ * p_ - 1.0);
            a2 * i_ * i_ + (f_min - a2)
        }
        Quadratic => (f_max - f_min) / (p_ * p_) * (i_ - n_).powi(2) + f_min,
        Sinusoidal => {
            let (a5, a6) = ((f_min - f_max) / 2.0, (f_max + f_min) / 2.0);
            a5 * (if rises { PI * (i_ - 1.0) / (p_ - 1.0) } else { PI * (i_ - n_) / p_ }).cos() + a6
        }
        Logarithmic if rises => (f_max - f_min) / p_.ln() * i_.ln() + f_min,
        Logarithmic => (f_max - f_min) / (p_ + 1.0).ln() * (-i_ + n_ + 1.0).ln() + f_min,
    }
}

/// By hand, Table 1: f_min = 250 Hz, f_max = 666.667 Hz, N = 120, p_N = 24; the span is 416.667 Hz.
/// Step 2: 1/23, 3/575, (1 - cos(pi/23))/2 = 0.0046570 and ln 2/ln 24 = 0.218104 of it.
/// Step 97, 23 before the last: 23/24, 529/576, (1 + cos(pi/24))/2 = 0.9957224 and ln 24/ln 25 = 0.987318.
#[test]
fn table_1_by_hand() {
    let by_hand = [
        (Linear, 268.1159, 649.3056),
        (Quadratic, 252.1739, 632.6678),
        (Sinusoidal, 251.9404, 664.8843),
        (Logarithmic, 340.8768, 661.3825),
    ];
    for (frequency_ramp, second_hz, step_97_hz) in by_hand {
        let plan = exact(frequency_ramp, TABLES[0]);
        let ends = [1, 24, 25, 95, 96, 120].map(|i| plan.frequency_hz(i));
        let (low, top) = (250.0, 1e6 / 1500.0);
        assert_eq!(ends, [low, top, top, top, top, low], "{frequency_ramp}");
        assert!((plan.frequency_hz(2) - second_hz).abs() < 1e-4, "{frequency_ramp}: {}", plan.frequency_hz(2));
        assert!((plan.frequency_hz(97) - step_97_hz).abs() < 1e-4, "{frequency_ramp}: {}", plan.frequency_hz(97));
    }
}

#[test]
fn every_step_of_every_table_is_the_printed_equation() {
    for (frequency_ramp, table) in cases() {
        let plan = exact(frequency_ramp, table);
        for i in 1..=table.0 {
            let printed = printed_hz(frequency_ramp, table, i);
            assert!((plan.frequency_hz(i) / printed - 1.0).abs() < 1e-13, "{frequency_ramp} {table:?} step {i}");
        }
    }
}

#[test]
fn the_exact_total_is_the_sum_of_all_periods() {
    for (frequency_ramp, table) in cases() {
        let plan = exact(frequency_ramp, table);
        let sum_s: f64 = (1..=table.0).map(|i| 1.0 / printed_hz(frequency_ramp, table, i)).sum();
        assert!(
            (plan.duration_s() - sum_s).abs() < 1e-9,
            "{frequency_ramp} {table:?}: {} is not {sum_s}",
            plan.duration_s()
        );
        let edges: Vec<f64> = plan.edges_s().collect();
        assert_eq!((edges.len(), edges[0]), (table.0 as usize, 0.0));
        let last_s = edges[edges.len() - 1] + plan.period_s(table.0);
        assert!((last_s - plan.duration_s()).abs() < 1e-15, "the last edge is a period before the end");
    }
}

/// Table 1, computed from the equations by a program in another language. The paper's "almost 10 %" and "18 %" are 9.9
/// and 17.7.
#[test]
fn the_frequency_ramps_of_table_1_are_as_far_apart_as_the_paper_says() {
    let total_s = FrequencyRamp::ALL.map(|frequency_ramp| exact(frequency_ramp, TABLES[0]).duration_s());
    let wanted_s = [0.222_678_167, 0.243_700_268, 0.227_126_018, 0.200_609_771];
    for (total, wanted) in total_s.into_iter().zip(wanted_s) {
        assert!((total - wanted).abs() < 1e-9, "{total} is not {wanted}");
    }
    let saved = [0, 2, 1].map(|other| 100.0 * (1.0 - total_s[3] / total_s[other]));
    assert_eq!(saved.map(|percent| (10.0 * percent).round() / 10.0), [9.9, 11.7, 17.7]);
}

/// The instants are compared with whole numbers of 10^-21 s, which no sum of floats can match. A plain sum would be
/// 3e-8 s off here.
#[test]
fn a_million_instants_keep_what_each_sum_rounds_off() {
    let plan = FrequencyProfile::plan(Linear, 1_000_000, 2, 3_000.0, 3_000.0).unwrap();
    let period = (plan.period_s(1) * 1e21) as u128;
    for (edge_s, i) in plan.edges_s().zip(0_u128..).step_by(99_991) {
        let wanted_s = (i * period) as f64 * 1e-21;
        assert!((edge_s - wanted_s).abs() <= 1e-12, "edge {i}: {edge_s} is not {wanted_s}");
    }
}

/// Half of 1e6/f in whole numbers, for the profiles that are rational.
fn rational_half_us(frequency_ramp: FrequencyRamp, (n, p, max, min): (u32, u32, u32, u32), i: u32) -> u64 {
    let [n, p, max, min, i] = [n, p, max, min, i].map(u64::from);
    let (ratio, whole) = match frequency_ramp {
        Linear if i <= p => (i - 1, p - 1),
        Linear => (p.min(n - i), p),
        _ if i <= p => (i * i - 1, p * p - 1),
        _ => (p.min(n - i).pow(2), p * p),
    };
    // f = 1e6 (1/max + (1/min - 1/max) ratio/whole).
    max * min * whole / (2 * (min * whole + (max - min) * ratio))
}

#[test]
fn the_truncated_total_is_the_sum_of_whole_periods() {
    for (frequency_ramp, table) in cases() {
        let plan = truncated(frequency_ramp, table);
        let half_us = |i| match frequency_ramp {
            Linear | Quadratic => rational_half_us(frequency_ramp, table, i),
            _ => (0.5e6 / printed_hz(frequency_ramp, table, i) + 1e-9) as u64,
        };
        let sum_us: u64 = (1..=table.0).map(|i| 2 * half_us(i)).sum();
        assert_eq!(plan.duration_us(), sum_us, "{frequency_ramp} {table:?}");
        let last_us = plan.edges_us().last().unwrap();
        assert_eq!(last_us + u64::from(plan.period_us(table.0)), sum_us, "{frequency_ramp} {table:?}");
        let ahead_s = exact(frequency_ramp, table).duration_s() - sum_us as f64 * 1e-6;
        assert!((0.0..f64::from(table.0) * 2e-6).contains(&ahead_s), "each period is cut by less than 2 us");
    }
}

/// The totals are those of the paper's listing, written in another language.
#[test]
fn the_truncated_totals_of_table_1() {
    let total_us = FrequencyRamp::ALL.map(|frequency_ramp| truncated(frequency_ramp, TABLES[0]).duration_us());
    assert_eq!(total_us, [222_632, 243_660, 227_080, 200_564]);
}

/// Table 2, step 66: f = 250 + 2250 * 65/165 Hz, whose period is 879.9999999999999 us in floats.
#[test]
fn a_whole_period_stays_whole() {
    let plan = truncated(Linear, TABLES[1]);
    assert_eq!(plan.period_us(66), 880);
    let odd = FrequencyProfile::plan(Sinusoidal, 40, 8, 3_001.0, 1_001.0).unwrap();
    let plan = TruncatedProfile::plan(Sinusoidal, 40, 8, 3_001.0, 1_001.0).unwrap();
    assert_eq!([1, 8, 20, 32, 40].map(|i| plan.period_us(i)), [3_000, 1_000, 1_000, 1_000, 3_000]);
    assert!((odd.period_s(1) - 3_001e-6).abs() < 1e-15);
}

/// The rule belongs to the program. The equations do not have it.
#[test]
fn below_20_steps_the_program_has_no_ramp() {
    let short = |steps, ramp| TruncatedProfile::plan(Logarithmic, steps, ramp, 4_001.0, 1_500.0).unwrap();
    assert_eq!(short(19, 4).edges_us().collect::<Vec<_>>(), (0..19).map(|i| i * 4_000).collect::<Vec<_>>());
    assert_eq!(short(3, 0).duration_us(), 12_000);
    assert_eq!([1, 4, 17, 20].map(|i| short(20, 4).period_us(i)), [4_000, 1_500, short(20, 4).period_us(17), 4_000]);
    assert!(short(20, 4).period_us(17) < 4_000);
    let exact = FrequencyProfile::plan(Logarithmic, 4, 2, 4_000.0, 1_500.0).unwrap();
    assert_eq!(exact.frequency_hz(2), 1e6 / 1500.0);
}

/// Eqs 5-8: i <= p_N, p_N < i < N - p_N, and N - p_N <= i. The first condition that holds decides.
#[test]
fn every_step_belongs_to_one_branch() {
    let counts = |steps, ramp| {
        let counts = FrequencyProfile::plan(Linear, steps, ramp, 4e3, 1e3).unwrap().step_counts();
        [counts.accel, counts.cruise, counts.decel]
    };
    assert_eq!(counts(120, 24), [24, 71, 25]);
    assert_eq!(counts(48, 24), [24, 0, 24]);
    assert_eq!(counts(49, 24), [24, 0, 25]);
    let short = TruncatedProfile::plan(Linear, 9, 1, 4e3, 1e3).unwrap().step_counts();
    assert_eq!([short.accel, short.cruise, short.decel], [0, 9, 0]);
}

#[test]
fn what_cannot_be_planned_is_refused_with_its_bound() {
    let plan = |n, p, max, min| FrequencyProfile::plan(Linear, n, p, max, min).unwrap_err();
    assert_eq!(plan(0, 2, 4e3, 1e3), FrequencyError::NoSteps);
    assert_eq!(plan(120, 61, 4e3, 1e3), FrequencyError::LongRamp { asked: 61, max: 60, steps: 120 });
    assert_eq!(plan(120, 1, 4e3, 1e3), FrequencyError::ShortRamp { asked: 1, min: 2 });
    assert_eq!(plan(120, 24, 1e3, 4e3), FrequencyError::PeriodOrder { asked: 4e3, max: 1e3 });
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e10] {
        assert!(matches!(plan(120, 24, bad, 1e3), FrequencyError::MaxPeriod { min: 0.1, max: 1e9, .. }), "{bad}");
        assert!(matches!(plan(120, 24, 4e3, bad), FrequencyError::MinPeriod { min: 0.1, max: 1e9, .. }), "{bad}");
    }
    let zero_half = TruncatedProfile::plan(Linear, 120, 24, 4e3, 1.5).unwrap_err();
    assert_eq!(zero_half, FrequencyError::MinPeriod { asked: 1.5, min: 2.0, max: 1e9 });
    assert_eq!(
        TruncatedProfile::plan(Linear, 20, 1, 4e3, 1e3).unwrap_err(),
        FrequencyError::ShortRamp { asked: 1, min: 2 }
    );
    assert_eq!(
        plan(120, 61, 4e3, 1e3).to_string(),
        "two ramps of 61 steps do not fit 120 steps: 2 p_N <= N allows at most 60"
    );
}

fn cases() -> impl Iterator<Item = (FrequencyRamp, (u32, u32, u32, u32))> {
    TABLES.into_iter().flat_map(|table| FrequencyRamp::ALL.map(|frequency_ramp| (frequency_ramp, table)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: isostep_trials::cases(100, 1_000), failure_persistence: None, ..ProptestConfig::default() })]

    /// With any parameters, frequencies stay between f_min and f_max, and first rise, then are constant, then fall.
    #[test]
    fn frequencies_rise_stay_and_fall(frequency_ramp in 0..4_usize, n in 4..3_000_u32, p in 0.0..1.0, max in 1.0..1e6, ratio in 0.01..1.0) {
        let p = 2 + (p * f64::from(n / 2 - 1)) as u32;
        let min = f64::max(max * ratio, 0.1);
        let plan = FrequencyProfile::plan(FrequencyRamp::ALL[frequency_ramp], n, p, max, min).unwrap();
        let f: Vec<f64> = (1..=n).map(|i| plan.frequency_hz(i)).collect();
        let p = p as usize;
        let slack = 1.0 + 1e-14;
        prop_assert!(f[..p].windows(2).all(|pair| pair[0] <= pair[1] * slack));
        prop_assert!(f[n as usize - p - 1..].windows(2).all(|pair| pair[1] <= pair[0] * slack));
        prop_assert!(f[p - 1..n as usize - p].iter().all(|&hz| (hz / (1e6 / min) - 1.0).abs() < 1e-14));
        prop_assert!(f.iter().all(|&hz| hz >= 1e6 / max / slack && hz <= 1e6 / min * slack));
        let (edges, whole_s) = (plan.edges_s(), plan.duration_s());
        prop_assert_eq!(edges.len(), n as usize);
        prop_assert!(edges.zip(0_u32..).all(|(edge_s, i)| edge_s <= whole_s && (i == 0) == (edge_s == 0.0)));
    }
}
