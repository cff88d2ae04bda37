//! The emulated board's file of STEP edges, and its comparison with the closed form of moves. Each rising edge is a little-endian
//! `u64`: eight times its cycle, plus twice its axis, plus one if the direction is positive.

use std::io::{self, ErrorKind, Read};

use isostep::chip::Chip;
use isostep::measure::PlannedMove;
use isostep::measure::board::Followed;
use isostep::measure::errors::{Drift, Errors};
use isostep::measure::planned_move::{NAMES, PROVED};

/// A rising edge of STEP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// When it rose, ns since power-up.
    pub t_ns: f64,
    /// Index of the axis.
    pub axis: usize,
    /// 1 or -1.
    pub direction: i32,
}

/// The edges of `input` in the order in which they rose, by the clock of `chip`. They are read one at a time, because there may be millions.
pub fn read(mut input: impl Read, chip: Chip) -> impl Iterator<Item = io::Result<Edge>> {
    std::iter::from_fn(move || {
        word(&mut input).and_then(|word| word.map(|word| edge(word, chip)).transpose()).transpose()
    })
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

fn edge(word: u64, chip: Chip) -> io::Result<Edge> {
    let axis = (word >> 1 & 3) as usize;
    if axis >= PROVED {
        return Err(io::Error::new(ErrorKind::InvalidData, format!("there is no axis {axis} in the file of edges")));
    }
    let t_ns = (word >> 3) as f64 * chip.cycle_ns();
    Ok(Edge { t_ns, axis, direction: if word & 1 == 1 { 1 } else { -1 } })
}

/// Why the edges do not match the moves.
#[derive(Debug)]
pub enum Astray {
    /// The file cannot be read.
    Read(io::Error),
    /// An axis made a wrong number of steps, or moved in the wrong direction.
    Steps { axis: usize, made: u64, planned: u64 },
    /// A step came while its axis should rest or move in the other direction.
    Stray { axis: usize, t_ns: f64 },
}

/// Compares `edges` with the closed form of `moves`.
///
/// The firmware chooses the instant at which a move starts. So in each move both the measured and the planned instants
/// count from its first edge, and a latency common to all edges does not show.
pub fn follow(edges: impl Iterator<Item = io::Result<Edge>>, moves: &[PlannedMove]) -> Result<Followed, Astray> {
    let mut edges = edges.peekable();
    let mut errors = Errors::default();
    let mut drift = None;
    for planned in moves {
        let mut moved = Move::new(planned);
        while moved.left > 0 {
            let edge = edges.next().ok_or_else(|| moved.cut_short())?.map_err(Astray::Read)?;
            errors.add(moved.error_ns(edge)?);
        }
        drift = drift.or(Some(moved.drift.figures()));
    }
    match edges.next() {
        None => Ok(Followed { errors, drift }),
        Some(Ok(Edge { axis, t_ns, .. })) => Err(Astray::Stray { axis, t_ns }),
        Some(Err(error)) => Err(Astray::Read(error)),
    }
}

/// A move whose edges are being read.
struct Move<'a> {
    planned: &'a PlannedMove,
    /// Steps that each axis has made.
    made: [u32; PROVED],
    /// Number of edges still to come.
    left: u64,
    /// The board's time at instant 0 of the plan, ns. It is known from the first edge on.
    start_ns: Option<f64>,
    drift: Drift,
}

impl<'a> Move<'a> {
    fn new(planned: &'a PlannedMove) -> Self {
        let left = planned.edges();
        Self { planned, made: [0; PROVED], left, start_ns: None, drift: Drift::new(left) }
    }

    fn error_ns(&mut self, Edge { t_ns, axis, direction }: Edge) -> Result<f64, Astray> {
        let steps = self.planned.steps[axis];
        if self.made[axis] == steps.unsigned_abs() || direction != steps.signum() {
            return Err(Astray::Stray { axis, t_ns });
        }
        self.made[axis] += 1;
        self.left -= 1;
        let due_ns = self.planned.due_ns(axis, self.made[axis]);
        let start_ns = *self.start_ns.get_or_insert(t_ns - due_ns);
        let error_ns = t_ns - start_ns - due_ns;
        self.drift.add(due_ns * 1e-9, error_ns);
        Ok(error_ns)
    }

    fn cut_short(&self) -> Astray {
        let short = (0..PROVED).find(|&axis| self.made[axis] < self.planned.count(axis));
        let axis = short.unwrap_or(0);
        Astray::Steps { axis, made: self.made[axis].into(), planned: self.planned.count(axis).into() }
    }
}

impl std::fmt::Display for Astray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Read(ref error) => write!(f, "the edges cannot be read: {error}"),
            Self::Steps { axis, made, planned } => write!(f, "{} made {made} of {planned} steps", NAMES[axis]),
            Self::Stray { axis, t_ns } => {
                write!(f, "{} made a step that is in no plan, {:.6} s after power-up", NAMES[axis], t_ns * 1e-9)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use isostep::measure::{Machine, Ramp};

    use super::*;

    /// A short move there and back, with edges that are exact to the cycle.
    fn ideal() -> ([PlannedMove; 2], Vec<Edge>) {
        let machine = Machine::new(10_000, Ramp { s: 0.01, accel_max_steps_s2: 5e6 });
        let there = machine.planned([250, 250, 0]).unwrap();
        let moves = [there.clone(), there.back()];
        let start = [8e6, 720e6];
        let mut edges = Vec::new();
        for (planned, start) in moves.iter().zip(start) {
            for k in 1..=250 {
                for axis in 0..2 {
                    let t_ns = start + (planned.due_ns(axis, k) * 0.125).round() * 8.0;
                    edges.push(Edge { t_ns, axis, direction: planned.steps[axis].signum() });
                }
            }
        }
        (moves, edges)
    }

    fn judge(moves: &[PlannedMove], edges: &[Edge]) -> Result<Followed, Astray> {
        follow(edges.iter().copied().map(Ok), moves)
    }

    #[test]
    fn edges_to_the_cycle_have_no_error_but_rounding() {
        let (moves, edges) = ideal();
        let followed = judge(&moves, &edges).unwrap();
        assert_eq!(followed.errors.count(), 1_000);
        assert!(followed.errors.max_ns() <= 8.0, "half a cycle on either side: {:?}", followed.errors);
    }

    #[test]
    fn a_late_edge_is_seen_with_its_lateness() {
        let (moves, mut edges) = ideal();
        edges[100].t_ns += 1_000.0;
        let errors = judge(&moves, &edges).unwrap().errors;
        assert!((errors.extremes_ns()[1] - 1_000.0).abs() <= 8.0 && errors.quantile_ns(0.99) <= 8.0, "{errors:?}");
    }

    #[test]
    fn lost_added_and_turned_edges_are_named() {
        let (moves, edges) = ideal();
        let lost = judge(&moves, &edges[..edges.len() - 1]).unwrap_err();
        assert_eq!(lost.to_string(), "Y made 249 of 250 steps");
        let added = [edges.as_slice(), &edges[edges.len() - 1..]].concat();
        assert!(matches!(judge(&moves, &added), Err(Astray::Stray { axis: 1, .. })));
        let mut turned = edges.clone();
        turned[7].direction = -1;
        assert!(matches!(judge(&moves, &turned), Err(Astray::Stray { axis: 1, .. })));
    }

    #[test]
    fn edges_are_read_in_their_order() {
        let words = [1_250_000_000 * 8 + 5, 8 + 2_u64];
        let bytes: Vec<u8> = words.into_iter().flat_map(u64::to_le_bytes).collect();
        for (chip, t_ns) in [(Chip::Rp2040, [1e10, 8.0]), (Chip::Rp2350, [1.25e9 / 0.15, 1.0 / 0.15])] {
            let edges: Vec<Edge> = read(bytes.as_slice(), chip).map(Result::unwrap).collect();
            let read: Vec<_> = edges.iter().map(|edge| (edge.axis, edge.direction)).collect();
            assert_eq!(read, [(2, 1), (1, -1)]);
            assert!(edges.iter().zip(t_ns).all(|(edge, t_ns)| (edge.t_ns - t_ns).abs() < 1e-5), "{edges:?}");
        }
    }

    #[test]
    fn a_torn_file_and_a_fourth_axis_are_refused() {
        assert!(read([0_u8; 9].as_slice(), Chip::Rp2040).last().unwrap().is_err());
        assert!(read(6_u64.to_le_bytes().as_slice(), Chip::Rp2040).next().unwrap().is_err());
    }
}
