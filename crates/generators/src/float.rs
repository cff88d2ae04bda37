//! The floats that a generator may keep its interval in.

use core::ops::{Add, Div, Mul};

/// `f32` or `f64`.
pub trait Float:
    Copy + Add<Output = Self> + Div<Output = Self> + Mul<Output = Self> + sealed::Sealed + core::fmt::Debug
{
    /// 1.
    const ONE: Self;

    /// The nearest value.
    fn from_f64(value: f64) -> Self;

    /// The nearest whole number of ticks, 0 to `u32::MAX`.
    fn ticks(self) -> u32;
}

impl Float for f32 {
    const ONE: Self = 1.0;

    fn from_f64(value: f64) -> Self {
        value as Self
    }

    fn ticks(self) -> u32 {
        (self + 0.5) as u32
    }
}

impl Float for f64 {
    const ONE: Self = 1.0;

    fn from_f64(value: f64) -> Self {
        value
    }

    fn ticks(self) -> u32 {
        (self + 0.5) as u32
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}
