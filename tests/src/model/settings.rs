//! The settings by their numbers, as docs/console.md and docs/bring-up.md have them.

use std::collections::BTreeMap;

/// The value of each setting.
#[derive(Clone, Debug, PartialEq)]
pub struct SettingValues(BTreeMap<u16, f64>);

impl SettingValues {
    /// From the reply to `$$` of a machine whose settings are known otherwise.
    #[must_use]
    pub fn from_listing(lines: &[String]) -> Self {
        let pair = |line: &String| {
            let (number, value) = line.strip_prefix('$')?.split_once('=')?;
            Some((number.parse().ok()?, value.parse().ok()?))
        };
        Self(lines.iter().filter_map(pair).collect())
    }

    /// A setting's value.
    ///
    /// # Panics
    /// If there is no such setting.
    #[must_use]
    pub fn get(&self, number: u16) -> f64 {
        self.0[&number]
    }

    /// `$n=v`.
    ///
    /// # Errors
    /// The number of the error; nothing has changed then.
    pub fn set(&mut self, number: u16, value: f64) -> Result<(), u8> {
        match number {
            _ if !self.0.contains_key(&number) => return Err(3),
            _ if value < 0.0 => return Err(4),
            10 if value > 3.0 => return Err(2),
            950..=952 if value > 5.0 => return Err(2),
            // As in Grbl there are no soft limits without homing.
            22 if value == 0.0 => drop(self.0.insert(20, 0.0)),
            _ => {}
        }
        self.0.insert(number, value);
        Ok(())
    }

    /// Checks that they work together: soft limits need homing, and only the trapezoid is shaped.
    ///
    /// # Errors
    /// The number of the error.
    pub fn check(&self) -> Result<(), u8> {
        let is_shaped = (950..=952).any(|number| self.get(number) != 0.0);
        match () {
            () if self.get(20) != 0.0 && self.get(22) == 0.0 => Err(10),
            () if self.get(940) != 0.0 && is_shaped => Err(2),
            () => Ok(()),
        }
    }

    /// True if all values are the same, as `$$` rounds them.
    #[must_use]
    pub fn is_about(&self, other: &Self) -> bool {
        let pairs = self.0.iter().zip(&other.0);
        self.0.len() == other.0.len()
            && pairs.into_iter().all(|(one, two)| one.0 == two.0 && (one.1 - two.1).abs() < 6e-4)
    }
}
