//! The stamps of a stamper: instants of edges, in cycles from one that all stampers share, and which edges they are by count.

use anyhow::{Context, Result, bail, ensure};

use crate::chip::Chip;

/// This stamper cannot skip: it keeps the last stamps of its window instead.
pub const KEEPS_LAST: usize = 2;

/// The window of a stamper.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stamps {
    /// The cycles in which the pad was seen high. It has been so since then, or since the cycle before.
    pub cycles: Vec<u32>,
    /// The number of each of these edges, from 1, as the stamper has counted them.
    pub counted: Vec<u32>,
    /// The stamper itself has lost time, because nobody took its stamps soon enough.
    pub lost: bool,
}

impl Stamps {
    /// Reads the replies to `$PROVE=READ`: `[STAMPS:stamper,first,count,lost]`, then `[S:a b c]` lines, hexadecimal: the first
    /// stamp, then the differences between successive ones. `first` is the number of the edge of the first one. The
    /// stampers that can skip have skipped so many after it.
    ///
    /// # Errors
    /// When they are no such lines, or fewer than announced.
    pub fn read(said: &[String], skip: u32) -> Result<Self> {
        let head = said.iter().find_map(|line| line.strip_prefix("[STAMPS:")?.strip_suffix(']'));
        let head = head.with_context(|| format!("no [STAMPS:stamper,first,count,lost] came, but {said:?}"))?;
        let fields: Vec<u32> = head.split(',').filter_map(|field| field.parse().ok()).collect();
        let &[stamper, first, count, lost] = fields.as_slice() else { bail!("[STAMPS:{head}] has not four numbers") };
        let (mut at, mut cycles) = (0_u32, Vec::with_capacity(count as usize));
        for line in said.iter().filter_map(|line| line.strip_prefix("[S:")?.strip_suffix(']')) {
            for difference in line.split_whitespace() {
                let difference = u32::from_str_radix(difference, 16);
                at = at.wrapping_add(difference.with_context(|| format!("[S:{line}] is not hexadecimal"))?);
                cycles.push(at);
            }
        }
        ensure!(
            cycles.len() as u32 == count,
            "{count} stamps were announced, and {} came: bytes are lost on the cable",
            cycles.len()
        );
        let skipped = if stamper as usize == KEEPS_LAST { 0 } else { skip };
        let counted = (0..count).map(|index| first + index + if index == 0 { 0 } else { skipped }).collect();
        Ok(Self { cycles, counted, lost: lost != 0 })
    }

    /// The instants of the edges by this chip's clock, ns from the cycle that all share. An edge is on a cycle, and a stamp stands
    /// for two of them: the instant is between both, half a cycle from either.
    pub fn instants_ns(&self, chip: Chip) -> Vec<f64> {
        self.cycles.iter().map(|&cycle| (f64::from(cycle) - 0.5) * chip.cycle_ns()).collect()
    }
}

/// The instants of edges that two stampers have seen, one of which looks in the cycles between: exact to the cycle of this
/// chip, ns. `None` where they do not agree, which is a defect of the stampers or of the cable.
pub fn both(chip: Chip, one: &Stamps, other: &Stamps) -> Option<Vec<f64>> {
    // One of them looked on the edge's own cycle, the other on the next.
    let exact = |(&a, &b): (&u32, &u32)| (a.abs_diff(b) == 1).then(|| f64::from(a.min(b)) * chip.cycle_ns());
    (one.counted == other.counted).then(|| one.cycles.iter().zip(&other.cycles).map(exact).collect())?
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(lines: &[&str]) -> Vec<String> {
        lines.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn differences_become_cycles_and_edges_keep_their_numbers() {
        let read = Stamps::read(&lines(&["[STAMPS:1,1,4,0]", "[S:100 1f 1f]", "[S:20]"]), 500).unwrap();
        let counted = vec![1, 502, 503, 504];
        assert_eq!(read, Stamps { cycles: vec![0x100, 0x11f, 0x13e, 0x15e], counted, lost: false });
        assert_eq!(read.instants_ns(Chip::Rp2040)[0], 255.5 * 8.0);
        assert_eq!(read.instants_ns(Chip::Rp2350)[0], 255.5 * Chip::Rp2350.cycle_ns());
        let last = Stamps::read(&lines(&["[STAMPS:2,501,2,1]", "[S:100 1f]"]), 500).unwrap();
        assert_eq!((last.counted, last.lost), (vec![501, 502], true));
        assert_eq!(Stamps::read(&lines(&["[STAMPS:0,1,0,0]"]), 0).unwrap(), Stamps::default());
    }

    #[test]
    fn what_is_torn_is_refused() {
        let refused = |said: &[&str]| Stamps::read(&lines(said), 0).unwrap_err().to_string();
        assert!(refused(&["[STAMPS:1,1,4,0]", "[S:100 1f]"]).contains("4 stamps were announced, and 2 came"));
        assert!(refused(&["ok"]).contains("no [STAMPS:stamper,first,count,lost]"));
        assert!(refused(&["[STAMPS:1,1,1,0]", "[S:xyz]"]).contains("not hexadecimal"));
        assert!(refused(&["[STAMPS:1,1,0]"]).contains("not four numbers"));
    }

    /// An edge on each of six cycles, as two stampers see it that look every second cycle.
    #[test]
    fn a_pair_is_exact_to_the_cycle() {
        let cycles: Vec<u32> = (10..16).collect();
        let counted: Vec<u32> = (1..=6).collect();
        let seen = |phase: u32| Stamps {
            cycles: cycles.iter().map(|cycle| cycle + (cycle + phase) % 2).collect(),
            counted: counted.clone(),
            lost: false,
        };
        for chip in Chip::ALL {
            let own: Vec<f64> = cycles.iter().map(|&cycle| f64::from(cycle) * chip.cycle_ns()).collect();
            assert_eq!(both(chip, &seen(0), &seen(1)), Some(own));
            assert_eq!((both(chip, &seen(0), &seen(0)), both(chip, &seen(0), &Stamps::default())), (None, None));
        }
    }
}
