//! Overrides: how much faster or slower than programmed the machine runs, set by the operator's real-time bytes.

/// Least and greatest override of the feed or the spindle, %.
const LIMITS_PERCENT: (u8, u8) = (10, 200);

/// The overrides in force, %; all are 100 by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overrides {
    /// Override of feeds, 10 to 200.
    pub feed_percent: u8,
    /// Override of rapids: 100, 50 or 25.
    pub rapid_percent: u8,
    /// Override of the spindle's speed, or of the laser's power, 10 to 200.
    pub spindle_percent: u8,
}

impl Overrides {
    /// No override: everything as programmed.
    pub const DEFAULT: Self = Self { feed_percent: 100, rapid_percent: 100, spindle_percent: 100 };

    /// Applies a byte of [`Realtime::Override`](crate::Realtime::Override); any other byte changes nothing.
    pub fn apply(&mut self, byte: u8) {
        match byte {
            0x90..=0x94 => step(&mut self.feed_percent, byte - 0x90),
            0x95 => self.rapid_percent = 100,
            0x96 => self.rapid_percent = 50,
            0x97 => self.rapid_percent = 25,
            0x99..=0x9D => step(&mut self.spindle_percent, byte - 0x99),
            _ => {}
        }
    }
}

impl Default for Overrides {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The meaning of five consecutive bytes: 100 %, 10 % more, 10 % less, 1 % more, 1 % less.
fn step(percent: &mut u8, which: u8) {
    let (least, most) = LIMITS_PERCENT;
    *percent = match which {
        0 => 100,
        1 => *percent + 10,
        2 => *percent - 10,
        3 => *percent + 1,
        _ => *percent - 1,
    }
    .clamp(least, most);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(bytes: &[u8]) -> [u8; 3] {
        let mut overrides = Overrides::DEFAULT;
        bytes.iter().for_each(|&byte| overrides.apply(byte));
        [overrides.feed_percent, overrides.rapid_percent, overrides.spindle_percent]
    }

    #[test]
    fn each_byte_does_its_part() {
        let rows: &[(&[u8], [u8; 3])] = &[
            (&[0x91], [110, 100, 100]),
            (&[0x92], [90, 100, 100]),
            (&[0x93], [101, 100, 100]),
            (&[0x94], [99, 100, 100]),
            (&[0x91, 0x93, 0x90], [100, 100, 100]),
            (&[0x96], [100, 50, 100]),
            (&[0x97], [100, 25, 100]),
            (&[0x97, 0x95], [100, 100, 100]),
            (&[0x9A], [100, 100, 110]),
            (&[0x9B], [100, 100, 90]),
            (&[0x9C], [100, 100, 101]),
            (&[0x9D], [100, 100, 99]),
            (&[0x9D, 0x99], [100, 100, 100]),
            (&[0x98, 0x9E, 0xA0, b'!', 0xC2], [100, 100, 100]),
        ];
        for &(bytes, expected) in rows {
            assert_eq!(after(bytes), expected, "{bytes:02X?}");
        }
    }

    #[test]
    fn they_end_at_10_and_200_percent() {
        assert_eq!(after(&[0x91; 30]), [200, 100, 100]);
        assert_eq!(after(&[0x93; 255]), [200, 100, 100]);
        assert_eq!(after(&[0x92; 30]), [10, 100, 100]);
        assert_eq!(after(&[0x94; 255]), [10, 100, 100]);
        assert_eq!(after(&[0x9A; 30]), [100, 100, 200]);
        assert_eq!(after(&[0x9B; 30]), [100, 100, 10]);
    }
}
