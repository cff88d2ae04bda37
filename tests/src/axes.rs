//! Values of each axis for machines of three axes and of four.

use isostep_sim::{AXES, Axis};

/// Values of X, Y and Z, and that of A if there is a fourth axis.
#[must_use]
pub const fn xyz_a<T: Copy>([x, y, z]: [T; 3], a: T) -> [T; AXES] {
    let mut values = [a; AXES];
    (values[0], values[1], values[2]) = (x, y, z);
    values
}

/// `X1 Y2 Z3`.
#[must_use]
pub fn words(values: [f64; AXES]) -> String {
    Axis::ALL.iter().zip(values).map(|(axis, value)| format!("{axis}{value}")).collect::<Vec<_>>().join(" ")
}
