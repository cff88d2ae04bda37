//! Random numbers in the forms that a scenario needs.

use oorandom::Rand64;

/// Random numbers in the forms that a scenario needs.
pub(super) struct Random(pub Rand64);

impl Random {
    pub fn below(&mut self, end: u64) -> u64 {
        self.0.rand_range(0..end)
    }

    /// True in one of `cases` cases.
    pub fn one_in(&mut self, cases: u64) -> bool {
        self.below(cases) == 0
    }

    pub fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }

    /// A number from `least` to `most`, with a logarithmic distribution.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.0.rand_float())
    }
}
