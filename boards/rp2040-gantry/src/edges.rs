//! Which inputs have changed, and their levels, in the order in which no change is lost. It uses nothing of the chip, so
//! that a test on the host can change the inputs between any two accesses (`tests/tests/registers.rs`).

/// Inputs with a flag each, which every edge sets. While a flag is set, the interrupt is requested.
pub trait Inputs {
    /// The flags.
    fn flags(&mut self) -> u8;
    /// Clears these flags.
    fn clear(&mut self, flags: u8);
    /// The levels.
    fn levels(&mut self) -> u32;
}

/// The inputs that have changed, and all levels. The levels are read last: an input that changes after its flag was
/// cleared sets it again, and one that changes before is read as it is.
#[inline(always)]
pub fn take(inputs: &mut impl Inputs) -> (u8, u32) {
    let changed = inputs.flags();
    inputs.clear(changed);
    (changed, inputs.levels())
}
