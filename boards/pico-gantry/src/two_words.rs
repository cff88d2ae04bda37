//! A time of 64 bits that the chip has in two words. It uses nothing of the chip, so that a test on the host can read
//! it with the words changing between any two reads (`tests/tests/registers.rs`).

/// Reads the upper word, the lower one, and the upper one again.
#[inline(always)]
pub fn read(mut upper: impl FnMut() -> u32, mut lower: impl FnMut() -> u32) -> u64 {
    let mut before = upper();
    loop {
        let low = lower();
        // If the lower word has come round in between, it belongs to either upper word.
        let after = upper();
        if after == before {
            return u64::from(after) << 32 | u64::from(low);
        }
        before = after;
    }
}
