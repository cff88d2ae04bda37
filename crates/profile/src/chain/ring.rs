//! A ring of values in the order in which they came, of which any can be looked at.

/// At most `LEN` values, which is above 0.
#[derive(Clone, Debug)]
pub(super) struct Ring<T, const LEN: usize> {
    places: [T; LEN],
    first: usize,
    len: usize,
}

impl<T: Copy, const LEN: usize> Ring<T, LEN> {
    /// Of none; `nothing` is where there is none.
    pub(super) const fn new(nothing: T) -> Self {
        Self { places: [nothing; LEN], first: 0, len: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn is_full(&self) -> bool {
        self.len == LEN
    }

    /// Counted from the first; `None` beyond the last.
    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> Option<&T> {
        if index < self.len { self.places.get(Self::wrap(self.first + index)) } else { None }
    }

    #[inline(always)]
    pub(super) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        if index < self.len { self.places.get_mut(Self::wrap(self.first + index)) } else { None }
    }

    pub(super) fn last(&self) -> Option<&T> {
        self.get(self.len.checked_sub(1)?)
    }

    /// Puts one behind the last; false if there is no room.
    pub(super) fn push(&mut self, value: T) -> bool {
        let has_room = !self.is_full();
        if has_room {
            self.places[Self::wrap(self.first + self.len)] = value;
            self.len += 1;
        }
        has_room
    }

    /// Forgets the first.
    pub(super) fn pop(&mut self) {
        if self.len > 0 {
            self.first = Self::wrap(self.first + 1);
            self.len -= 1;
        }
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// No remainder: a Cortex-M0+ has no divider. `index` is below 2 `LEN`.
    #[inline(always)]
    fn wrap(index: usize) -> usize {
        if index >= LEN { index - LEN } else { index }
    }
}
