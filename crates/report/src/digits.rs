//! Numbers as texts.

/// A number with so many significant digits, without zeros at the end of decimals.
pub(crate) fn significant(value: f64, digits: f64) -> String {
    let decimals = if value == 0.0 { 0.0 } else { digits - 1.0 - value.abs().log10().floor() };
    let text = format!("{value:.*}", decimals.clamp(0.0, 9.0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
