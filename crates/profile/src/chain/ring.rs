//! A ring of values in the order in which they came, of which any can be looked at.

/// At most `LEN` values, which is above 0.
#[derive(Clone, Debug)]
pub(super) struct Ring<T, const LEN: usize> {
    places: [Option<T>; LEN],
    first: usize,
    len: usize,
}

impl<T, const LEN: usize> Ring<T, LEN> {
    pub(super) const fn new() -> Self {
        Self { places: [const { None }; LEN], first: 0, len: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn is_full(&self) -> bool {
        self.len == LEN
    }

    /// Counted from the first; `None` beyond the last.
    pub(super) fn get(&self, index: usize) -> Option<&T> {
        if index < self.len { self.places[Self::wrap(self.first + index)].as_ref() } else { None }
    }

    pub(super) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        if index < self.len { self.places[Self::wrap(self.first + index)].as_mut() } else { None }
    }

    /// Puts one behind the last.
    ///
    /// # Errors
    /// Gives it back if there is no room.
    pub(super) fn push(&mut self, value: T) -> Result<(), T> {
        if self.is_full() {
            return Err(value);
        }
        self.places[Self::wrap(self.first + self.len)] = Some(value);
        self.len += 1;
        Ok(())
    }

    /// Takes the first.
    pub(super) fn pop(&mut self) -> Option<T> {
        let value = self.places[self.first].take()?;
        self.first = Self::wrap(self.first + 1);
        self.len -= 1;
        Some(value)
    }

    /// No remainder: a Cortex-M0+ has no divider. `index` is below 2 `LEN`.
    fn wrap(index: usize) -> usize {
        if index >= LEN { index - LEN } else { index }
    }
}
