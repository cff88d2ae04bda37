//! The emulated board's file of STEP edges. Each rising edge is a little-endian `u64`: eight times its cycle at 125
//! MHz, plus twice its axis, plus one if the direction is positive.

use std::io::{self, ErrorKind, Read};

use isostep::measure::course::PROVED;

/// A rising edge of STEP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// When it rose, in cycles since power-up.
    pub cycle: u64,
    /// Index of the axis.
    pub axis: usize,
    /// 1 or -1.
    pub direction: i32,
}

/// The edges of `input` in the order in which they rose. They are read one at a time, because there may be millions.
pub fn read(mut input: impl Read) -> impl Iterator<Item = io::Result<Edge>> {
    std::iter::from_fn(move || word(&mut input).and_then(|word| word.map(edge).transpose()).transpose())
}

/// The next word, or `None` at the end.
fn word(input: &mut impl Read) -> io::Result<Option<u64>> {
    let mut bytes = [0; 8];
    let mut filled = 0;
    while filled < bytes.len() {
        match input.read(&mut bytes[filled..]) {
            Ok(0) if filled == 0 => return Ok(None),
            Ok(0) => return Err(io::Error::new(ErrorKind::UnexpectedEof, "the file of edges ends within an edge")),
            Ok(count) => filled += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(Some(u64::from_le_bytes(bytes)))
}

fn edge(word: u64) -> io::Result<Edge> {
    let axis = (word >> 1 & 3) as usize;
    if axis >= PROVED {
        return Err(io::Error::new(ErrorKind::InvalidData, format!("there is no axis {axis} in the file of edges")));
    }
    Ok(Edge { cycle: word >> 3, axis, direction: if word & 1 == 1 { 1 } else { -1 } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_read_in_their_order() {
        let words = [1_250_000_000 * 8 + 5, 8 + 2_u64];
        let bytes: Vec<u8> = words.into_iter().flat_map(u64::to_le_bytes).collect();
        let edges: Vec<Edge> = read(bytes.as_slice()).map(Result::unwrap).collect();
        assert_eq!(
            edges,
            [Edge { cycle: 1_250_000_000, axis: 2, direction: 1 }, Edge { cycle: 1, axis: 1, direction: -1 }]
        );
    }

    #[test]
    fn a_torn_file_and_a_fourth_axis_are_refused() {
        assert!(read([0_u8; 9].as_slice()).last().unwrap().is_err());
        assert!(read(6_u64.to_le_bytes().as_slice()).next().unwrap().is_err());
    }
}
