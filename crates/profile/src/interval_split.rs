//! The split of a move's duration into its three intervals.

/// The way in which a move's duration is split into its three intervals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum IntervalSplit {
    /// As fast as the limits allow: with a cruise, or without one if the distance is short (Stoychitch 2018, eqs 1-8).
    #[default]
    Fastest,
    /// Three equal intervals, as short as the limits allow (Forero 2023, eqs 1-7). A trapezoid from rest to rest then
    /// accelerates over a quarter of the distance, cruises over half of it and decelerates over a quarter.
    Thirds,
}

impl IntervalSplit {
    /// Every split.
    pub const ALL: [Self; 2] = [Self::Fastest, Self::Thirds];
}
