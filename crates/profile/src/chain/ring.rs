//! A ring buffer that gives access to each of its values, in the order in which they came.

/// At most `LEN` values; `LEN` is above 0.
#[derive(Clone, Debug)]
pub(crate) struct Ring<T, const LEN: usize> {
    places: [T; LEN],
    first: usize,
    len: usize,
}

impl<T: Copy, const LEN: usize> Ring<T, LEN> {
    /// An empty ring; `nothing` fills the empty places.
    pub(crate) const fn new(nothing: T) -> Self {
        Self { places: [nothing; LEN], first: 0, len: 0 }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn is_full(&self) -> bool {
        self.len == LEN
    }

    /// The value with this index, counted from the first; `None` beyond the last.
    #[inline(always)]
    pub(crate) fn get(&self, index: usize) -> Option<&T> {
        if index < self.len { self.places.get(Self::wrap(self.first + index)) } else { None }
    }

    #[inline(always)]
    pub(crate) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        if index < self.len { self.places.get_mut(Self::wrap(self.first + index)) } else { None }
    }

    pub(crate) fn last(&self) -> Option<&T> {
        self.get(self.len.checked_sub(1)?)
    }

    /// The place behind the last value, which [`extend`](Self::extend) makes the last; `None` if there is no room.
    pub(crate) fn next_place(&mut self) -> Option<&mut T> {
        if self.is_full() { None } else { self.places.get_mut(Self::wrap(self.first + self.len)) }
    }

    /// Appends what stands in [`next_place`](Self::next_place).
    pub(crate) fn extend(&mut self) {
        self.len = LEN.min(self.len + 1);
    }

    /// Removes the first value.
    pub(crate) fn pop(&mut self) {
        if self.len > 0 {
            self.first = Self::wrap(self.first + 1);
            self.len -= 1;
        }
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// `index` modulo `LEN`, without a division, because a Cortex-M0+ has no divider. `index` is below 2 `LEN`.
    #[inline(always)]
    fn wrap(index: usize) -> usize {
        if index >= LEN { index - LEN } else { index }
    }
}
