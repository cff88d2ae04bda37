//! The axes of the machine: X, Y and Z, and with the feature `four-axes` A.

/// How many axes the machine has.
pub const AXES: usize = if cfg!(feature = "four-axes") { 4 } else { 3 };

/// The letters of the axes, in their order.
pub const AXIS_NAMES: [&str; AXES] = [
    "X",
    "Y",
    "Z",
    #[cfg(feature = "four-axes")]
    "A",
];

/// A mask of all axes: bit 0 is X.
pub(crate) const ALL_AXES: u16 = (1 << AXES) - 1;

/// Z, along which a tool is long.
pub(crate) const Z: usize = 2;
/// The axis that may be rotary.
pub(crate) const A: usize = 3;

/// The axis whose letter this is.
pub(crate) fn axis_named(letter: &str) -> Option<usize> {
    AXIS_NAMES.iter().position(|&name| name == letter)
}
