//! The axes of the machine: X, Y and Z; with the feature `four-axes` A too, with `two-axes` X and Y alone.

/// The number of axes that the machine has.
pub const AXES: usize = if cfg!(feature = "four-axes") {
    4
} else if cfg!(feature = "two-axes") {
    2
} else {
    3
};

/// The values of the axes that there are, from these, which are for X, Y, Z and A.
pub(crate) const fn of_each<T: Copy>(of_four: [T; 4]) -> [T; AXES] {
    *of_four.first_chunk().expect("there are four axes at most")
}

/// The letters of the axes, in their order.
pub const AXIS_NAMES: [&str; AXES] = of_each(["X", "Y", "Z", "A"]);

/// A mask of all axes: bit 0 is X.
pub(crate) const ALL_AXES: u16 = (1 << AXES) - 1;

/// The axes that crossed belts move.
pub(crate) const X: usize = 0;
pub(crate) const Y: usize = 1;
/// Z, along which a tool is long.
pub(crate) const Z: usize = 2;
/// The axis that may be rotary.
pub(crate) const A: usize = 3;

/// The axis whose letter this is.
pub(crate) fn axis_named(letter: &str) -> Option<usize> {
    AXIS_NAMES.iter().position(|&name| name == letter)
}
