//! Colours and common parts of the pictures.
//!
//! The pictures are inline in the page and take their colours from its style sheet, so they follow the reader's light
//! or dark mode. plotters draws in a few signal colours, which [`svg`] replaces with CSS variables.

use plotters::coord::Shift;
use plotters::prelude::*;

/// A colour of the style sheet.
pub type Colour = RGBColor;

/// plotters rounds points to whole pixels, which would distort smooth curves. Drawn at this scale, the error is not
/// visible.
pub const FINE: u32 = 4;

/// Text and frames.
pub const INK: RGBColor = RGBColor(1, 0, 1);
/// Grid lines.
pub const GRID: RGBColor = RGBColor(1, 0, 2);
/// X, Y and Z.
pub const AXIS: [RGBColor; 4] = [RGBColor(1, 0, 4), RGBColor(1, 0, 5), RGBColor(1, 0, 6), RGBColor(1, 0, 15)];
/// Accelerating, cruising, decelerating.
pub const INTERVAL: [RGBColor; 3] = [RGBColor(1, 0, 7), RGBColor(1, 0, 8), RGBColor(1, 0, 9)];
/// Bounds.
pub(crate) const BOUND: RGBColor = RGBColor(1, 0, 10);
/// The rack.
pub(crate) const RACK: RGBColor = RGBColor(1, 0, 11);
/// Curves that overlap, in the order drawn.
pub const CURVE: [RGBColor; 7] =
    [AXIS[0], AXIS[1], AXIS[2], RACK, RGBColor(1, 0, 12), RGBColor(1, 0, 13), RGBColor(1, 0, 14)];

/// Two of the scale of speeds, where more colours are needed.
pub(super) const SPEED: [RGBColor; 2] = [RGBColor(1, 0, 16), RGBColor(1, 0, 17)];

const VARIABLES: [(RGBColor, &str); 16] = [
    (INK, "--ink"),
    (GRID, "--grid"),
    (AXIS[0], "--x"),
    (AXIS[1], "--y"),
    (AXIS[2], "--z"),
    (AXIS[3], "--a"),
    (INTERVAL[0], "--accel"),
    (INTERVAL[1], "--cruise"),
    (INTERVAL[2], "--decel"),
    (BOUND, "--bound"),
    (RACK, "--rack"),
    (CURVE[4], "--curve-5"),
    (CURVE[5], "--curve-6"),
    (CURVE[6], "--curve-7"),
    (SPEED[0], "--speed-4"),
    (SPEED[1], "--speed-5"),
];

pub use isostep_console::AXIS_NAMES;

/// The page's style sheet, which defines the colours.
pub(super) const STYLE_SHEET: &str = include_str!("style.css");

/// A drawing into memory.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// The result of drawing into memory. It fails only if the library's own arithmetic fails.
pub type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Draws a picture of `size` pixels and returns it as an SVG element for the page.
///
/// # Panics
/// Never in normal use: a failure would be a defect of the drawing code.
pub fn svg(size: (u32, u32), title: &str, draw: impl FnOnce(&Area) -> Drawn) -> String {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&area).and_then(|()| area.present()).expect("drawing into memory does not fail");
    }
    for (colour, variable) in VARIABLES {
        let RGBColor(r, g, b) = colour;
        text = text.replace(&format!("#{r:02X}{g:02X}{b:02X}"), &format!("var({variable})"));
    }
    // It scales with the page, and has a title for readers who cannot see it.
    let (width, height) = size;
    text.replace(
        &format!("<svg width=\"{width}\" height=\"{height}\""),
        &format!("<svg role=\"img\" aria-label=\"{title}\""),
    )
}

/// A picture as a separate file, in the light colours of the page's style sheet.
pub fn standalone(picture: &str) -> String {
    let text = picture.replacen('>', "><rect width=\"100%\" height=\"100%\" fill=\"var(--paper)\"/>", 1);
    STYLE_SHEET
        .lines()
        .filter_map(light_colour)
        .fold(text, |text, (variable, colour)| text.replace(&format!("var({variable})"), colour))
}

/// Splits `--x: light-dark(#1f6feb, #6cb0ff);` into `--x` and its light colour.
fn light_colour(line: &str) -> Option<(&str, &str)> {
    let (variable, value) = line.trim().split_once(": light-dark(")?;
    Some((variable, value.split(',').next()?))
}

/// A text style of `size` pixels.
pub fn font<'a>(size: u32) -> TextStyle<'a> {
    ("sans-serif", size).into_font().color(&INK)
}

/// A text of `size` pixels in a picture of [`FINE`] pixels, with its left end at a point, or as `more` attributes say.
pub(super) fn text([x, y]: [u32; 2], size: u32, more: &str, text: &str) -> String {
    let size = size * FINE;
    format!(
        "<text x=\"{x}\" y=\"{y}\" font-family=\"sans-serif\" font-size=\"{size}\"{more} fill=\"var(--ink)\">{text}</text>"
    )
}

/// The range from the least to the greatest of `values`, or 0 to 1 if there are none.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values
        .fold(None, |range: Option<(f64, f64)>, value| match range {
            None => Some((value, value)),
            Some((low, high)) => Some((low.min(value), high.max(value))),
        })
        .unwrap_or((0.0, 1.0))
}

/// Number of decimals that resolve a tenth of `span`.
pub fn decimals_of(span: f64) -> usize {
    (1.0 - span.log10()).ceil().clamp(0.0, 6.0) as usize
}
