//! The key of a picture: colours and their meanings, side by side, in as many lines as they need.

use plotters::prelude::*;

use super::WIDTH;
use super::theme::{self, Area, Colour, Drawn, FINE};

/// Height of a line and of what is above the first, pixels.
const LINE: u32 = 22;
const ABOVE: u32 = 12;
/// The place where a line begins, pixels.
const LEFT: u32 = 80;
/// The length of a sample of a colour, and what it takes with its space, pixels.
const SAMPLE: u32 = 20;
const BESIDE: u32 = 27;
/// The width that a letter takes at most in the mean, pixels.
const LETTER: u32 = 8;
/// The space behind a text, pixels.
const SPACE: u32 = 20;

/// The left upper corner of a place, pixels, and what stands there.
type Entry<'a> = ((u32, u32), &'a (Colour, String));

/// Colours and meanings in their places.
pub struct Key<'a> {
    places: Vec<Entry<'a>>,
}

impl<'a> Key<'a> {
    /// Places all of them.
    pub fn new(names: &'a [(Colour, String)]) -> Self {
        let (mut x, mut y) = (LEFT, ABOVE);
        let places = names.iter().map(|name| {
            let wide = BESIDE + LETTER * name.1.chars().count() as u32 + SPACE;
            if x > LEFT && x + wide > WIDTH {
                (x, y) = (LEFT, y + LINE);
            }
            x += wide;
            ((x - wide, y), name)
        });
        Self { places: places.collect() }
    }

    /// Its height, pixels: 0 without a colour.
    pub fn height(&self) -> u32 {
        self.places.last().map_or(0, |((_, y), _)| y + LINE)
    }

    /// Draws it into `area`.
    pub fn draw(&self, area: &Area) -> Drawn {
        let fine = |pixels: u32| (pixels * FINE) as i32;
        for &((x, y), (colour, name)) in &self.places {
            let ends = vec![(fine(x), fine(y + 8)), (fine(x + SAMPLE), fine(y + 8))];
            area.draw(&PathElement::new(ends, colour.stroke_width(3 * FINE)))?;
            area.draw(&Text::new(name.clone(), (fine(x + BESIDE), fine(y)), theme::font(15 * FINE)))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::theme::CURVE;
    use super::*;

    #[test]
    fn names_that_do_not_fit_go_into_another_line() {
        assert_eq!(Key::new(&[]).height(), 0);
        let names: Vec<_> = CURVE.into_iter().map(|colour| (colour, "some twenty letters.".to_owned())).collect();
        let key = Key::new(&names);
        let lines: Vec<_> = key.places.iter().map(|((_, y), _)| (y - ABOVE) / LINE).collect();
        assert_eq!(lines, [0, 0, 0, 1, 1, 1, 2]);
        assert_eq!(key.height(), ABOVE + 3 * LINE);
        assert!(key.places.iter().all(|((x, _), (_, name))| x + BESIDE + LETTER * name.len() as u32 <= WIDTH));
    }
}
