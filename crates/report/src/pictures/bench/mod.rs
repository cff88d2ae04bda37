//! Pictures and a page for benchmarks: plain data in, SVG and HTML out, in the style of a run's report.

mod bars;
mod curves;
mod histogram;
mod page;

pub use bars::bars;
pub use curves::curves;
pub use histogram::histogram;
pub use page::{Picture, Section, Table, files, page};

use plotters::style::RGBColor;

use super::theme::AXIS;

/// A series of values with one name and one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<T> {
    /// Its name in the key.
    pub name: String,
    /// The values, in the order drawn.
    pub values: Vec<T>,
}

/// The colour of the series with this index. Colours repeat if there are more than three series.
fn colour(index: usize) -> RGBColor {
    AXIS[index % AXIS.len()]
}

/// The powers of ten around positive `values`; the lower one is below all of them.
fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = super::theme::range(values.map(f64::log10));
    (10_f64.powf(low.ceil() - 1.0), 10_f64.powf(high.ceil()))
}

/// A label of a logarithmic scale. Some values have none because the labels would be too close.
fn label(value: f64) -> String {
    let leading = value / 10_f64.powf(value.log10().floor());
    if [1.0, 2.0, 5.0].iter().any(|digit| (leading - digit).abs() < 0.01) { short(value) } else { String::new() }
}

/// `1,200,000`, `30,000`, `4.1`, `0.012`: short, and with no more digits than a picture shows.
pub fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 1e6 {
        format!("{}M", trimmed(value * 1e-6))
    } else if magnitude >= 1e3 {
        format!("{}k", trimmed(value * 1e-3))
    } else {
        trimmed(value)
    }
}

/// Three significant digits, without zeros at the end of decimals.
fn trimmed(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers =
            [(0.0, "0"), (1e6, "1M"), (2.4e6, "2.4M"), (30_000.0, "30k"), (0.012, "0.012"), (-4.126, "-4.13")];
        for (value, text) in numbers {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn decades_hold_all_values() {
        assert_eq!(decades([3e4, 2.4e6].into_iter()), (1e4, 1e7));
        assert_eq!(decades([100.0].into_iter()), (10.0, 100.0));
    }

    #[test]
    fn few_places_of_a_logarithmic_scale_have_labels() {
        assert_eq!([1e4, 2e4, 3e4, 0.05, 1e6].map(label), ["10k", "20k", "", "0.05", "1M"]);
    }
}
