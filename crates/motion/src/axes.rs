//! The axes of the gantry.

use core::fmt;

/// Number of axes of a machine.
pub const AXES: usize = if cfg!(feature = "four-axes") {
    4
} else if cfg!(feature = "two-axes") {
    2
} else {
    3
};

/// An axis of the gantry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Axis {
    /// Across.
    X = 0,
    /// Up.
    Y = 1,
    /// Into the rack.
    #[cfg(any(not(feature = "two-axes"), feature = "four-axes"))]
    Z = 2,
    /// The fourth, which may be rotary.
    #[cfg(feature = "four-axes")]
    A = 3,
}

impl Axis {
    /// All axes, in order.
    pub const ALL: [Self; AXES] = [
        Self::X,
        Self::Y,
        #[cfg(any(not(feature = "two-axes"), feature = "four-axes"))]
        Self::Z,
        #[cfg(feature = "four-axes")]
        Self::A,
    ];
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "X",
            Self::Y => "Y",
            #[cfg(any(not(feature = "two-axes"), feature = "four-axes"))]
            Self::Z => "Z",
            #[cfg(feature = "four-axes")]
            Self::A => "A",
        })
    }
}
