//! Values of each axis for machines of two, three and four axes.

use isostep_sim::{AXES, Axis};

/// Values of X, Y and Z, and that of A, as far as there are these axes.
#[must_use]
pub const fn xyz_a<T: Copy>([x, y, z]: [T; 3], a: T) -> [T; AXES] {
    *[x, y, z, a].first_chunk().expect("there are four axes at most")
}

/// `X1 Y2 Z3`.
#[must_use]
pub fn words(values: [f64; AXES]) -> String {
    Axis::ALL.iter().zip(values).map(|(axis, value)| format!("{axis}{value}")).collect::<Vec<_>>().join(" ")
}
