//! The same programs planned offline, in floats and with all moves known: by two passes with the exact bounds of blends, and
//! as fast as the limits of the axes allow on the same lines and parabolas.

use isostep_profile::OFFSET_PARTS;

use super::{AXES, Machine, OneMove};

/// Into how many parts a line and a blend are divided.
const LINE_PARTS: usize = 400;
const PARTS: usize = 40;

/// The lines and blends of a program.
pub struct Path<'a> {
    machine: &'a Machine,
    lengths_mm: Vec<f64>,
    units: Vec<[f64; AXES]>,
    /// The squared speeds of the moves, (mm/s)².
    nominals: Vec<f64>,
    /// The reach of the blend at the beginning of each move, mm, and the highest squared speed in it.
    reaches_mm: Vec<f64>,
    caps: Vec<f64>,
}

/// A place on the path: the first and second derivatives by its parameter, and the highest square of the parameter's speed.
struct Place {
    first: [f64; AXES],
    second: [f64; AXES],
    cap: f64,
    /// The change of the parameter to the next place.
    step: f64,
}

impl<'a> Path<'a> {
    pub fn new(machine: &'a Machine, moves: &[OneMove], deviation_mm: f64) -> Self {
        let mut from = [0.0; AXES];
        let mut at = [0; AXES];
        let ways: Vec<[f64; AXES]> = moves
            .iter()
            .map(|(steps, offsets, _)| {
                at = std::array::from_fn(|axis| at[axis] + steps[axis]);
                let place = std::array::from_fn(|axis| {
                    let parts = f64::from(offsets[axis].clamp(-56, 56)) / f64::from(OFFSET_PARTS);
                    (f64::from(at[axis]) + parts) / machine.steps_per_mm
                });
                let way = std::array::from_fn(|axis| place[axis] - from[axis]);
                from = place;
                way
            })
            .collect();
        let lengths_mm: Vec<f64> = ways.iter().map(|way| way.iter().map(|mm| mm * mm).sum::<f64>().sqrt()).collect();
        let units: Vec<[f64; AXES]> =
            ways.iter().zip(&lengths_mm).map(|(way, length)| way.map(|mm| mm / length)).collect();
        let mut path = Self { machine, lengths_mm, units, nominals: vec![], reaches_mm: vec![], caps: vec![] };
        let nominal = |(index, one): (usize, &OneMove)| {
            one.2.unwrap_or(f64::INFINITY).min(path.along(index, machine.top_mm_s)).powi(2)
        };
        path.nominals = moves.iter().enumerate().map(nominal).collect();
        for index in 0..moves.len() {
            let (reach_mm, cap) = path.corner(index, deviation_mm);
            path.reaches_mm.push(reach_mm);
            path.caps.push(cap);
        }
        path.reaches_mm.push(0.0);
        path.caps.push(0.0);
        path
    }

    /// A limit of the axes along a move.
    fn along(&self, index: usize, limit: f64) -> f64 {
        self.units[index].iter().map(|unit| limit / unit.abs()).fold(f64::INFINITY, f64::min)
    }

    fn corner(&self, index: usize, deviation_mm: f64) -> (f64, f64) {
        let Some(before) = index.checked_sub(1) else { return (0.0, 0.0) };
        let changes: [f64; AXES] = std::array::from_fn(|axis| self.units[index][axis] - self.units[before][axis]);
        let length = changes.iter().map(|change| change * change).sum::<f64>().sqrt();
        if length < 1e-9 {
            return (0.0, f64::INFINITY);
        }
        if length > 1.999_999 {
            return (0.0, 0.0);
        }
        let half_mm = self.lengths_mm[index].min(self.lengths_mm[before]) / 2.0;
        let reach_mm = (4.0 * deviation_mm / length).min(half_mm);
        let most = changes.iter().map(|change| change.abs()).fold(0.0, f64::max);
        let (cap, nominal) =
            (2.0 * reach_mm * self.machine.accel_mm_s2 / most, self.nominals[index].max(self.nominals[before]));
        // No more than the speed needs, as in the chain.
        let share = (nominal / cap).max(0.25e-3 * nominal.sqrt() / reach_mm).min(1.0);
        (reach_mm * share, cap * share)
    }

    /// The highest squared speed at one end of a blend, by that at the other end.
    fn bound(&self, corner: usize, [own, other]: [&[f64; AXES]; 2], square: f64) -> f64 {
        let room = 2.0 * self.reaches_mm[corner] * self.machine.accel_mm_s2;
        if room == 0.0 {
            return square.min(self.caps[corner]);
        }
        let axes = (0..AXES).filter(|&axis| own[axis] * other[axis] >= 0.0 && own[axis] != 0.0);
        axes.fold(self.caps[corner], |least, axis| {
            let (own, other) = (own[axis].abs(), other[axis].abs());
            let speed = (square.sqrt() * other + (square * other * other + 4.0 * room * own).sqrt()) / (2.0 * own);
            least.min(speed * speed)
        })
    }

    /// The time that it takes by two passes with the bounds of blends as they are.
    pub fn by_two_passes_s(&self) -> f64 {
        let n = self.units.len();
        let (mut ins, mut outs) = (vec![0.0_f64; n + 1], vec![0.0_f64; n + 1]);
        let shortest =
            |index: usize| (self.lengths_mm[index] - self.reaches_mm[index] - self.reaches_mm[index + 1]).max(0.0);
        let gain = |index: usize| 2.0 * self.along(index, self.machine.accel_mm_s2) * shortest(index);
        for index in (1..n).rev() {
            let (before, after) = (&self.units[index - 1], &self.units[index]);
            let most = (ins[index + 1] + gain(index)).min(self.nominals[index]).min(self.caps[index]);
            ins[index] = self.bound(index, [before, after], most).min(self.nominals[index - 1]);
            outs[index] = most.min(self.bound(index, [after, before], ins[index]));
        }
        let mut total_s = 0.0;
        for index in 0..n {
            let most = outs[index] + gain(index);
            if most < ins[index + 1] {
                ins[index + 1] = most;
                outs[index + 1] =
                    outs[index + 1].min(self.bound(index + 1, [&self.units[index + 1], &self.units[index]], most));
            }
            total_s += self.line_s(index, [ins[index], outs[index]], [ins[index + 1], outs[index + 1]]);
        }
        total_s
    }

    /// The time that a line takes, and the blend after it. Given are the squares of both ends of the blends.
    fn line_s(&self, index: usize, begin: [f64; 2], end: [f64; 2]) -> f64 {
        let part =
            |own: f64, squares: [f64; 2]| if own > 0.0 { (own / squares[0].max(squares[1])).sqrt() } else { 0.0 };
        let [entry, exit] = [begin[1], end[0]];
        let length_mm = self.lengths_mm[index]
            - self.reaches_mm[index] * part(entry, begin)
            - self.reaches_mm[index + 1] * part(exit, end);
        let accel = self.along(index, self.machine.accel_mm_s2);
        let mut took_s = 0.0;
        if length_mm > 1e-9 {
            let peak = ((entry + exit) / 2.0 + accel * length_mm).min(self.nominals[index]).max(entry).max(exit);
            let ramps_mm = (2.0 * peak - entry - exit) / (2.0 * accel);
            took_s = (2.0 * peak.sqrt() - entry.sqrt() - exit.sqrt()) / accel
                + (length_mm - ramps_mm).max(0.0) / peak.sqrt();
        }
        if self.reaches_mm[index + 1] > 0.0 {
            took_s += 2.0 * self.reaches_mm[index + 1] / end[0].max(end[1]).sqrt();
        }
        took_s
    }

    /// The time that it takes as fast as the axes can: the fastest from place to place, by which every later place is reached.
    pub fn by_reachability_s(&self) -> f64 {
        let places = self.places();
        let mut most = vec![0.0; places.len() + 1];
        for index in (0..places.len()).rev() {
            most[index] = self.highest_before(&places[index], most[index + 1]);
        }
        let (mut square, mut total_s) = (0.0, 0.0);
        for (place, most) in places.iter().zip(&most[1..]) {
            let next = self.furthest(place, square).min(*most).max(0.0);
            if place.step > 0.0 {
                total_s += 2.0 * place.step / (square.sqrt() + next.sqrt());
            }
            square = next;
        }
        total_s
    }

    /// The highest square at a place from which one of at most `next` can follow.
    fn highest_before(&self, place: &Place, next: f64) -> f64 {
        let (mut low, mut high) = (0.0, place.cap);
        for _ in 0..50 {
            let middle = (low + high) / 2.0;
            let [least, most] = self.slopes(place, middle);
            let is_possible = least <= most && middle + 2.0 * place.step * least <= next;
            *if is_possible { &mut low } else { &mut high } = middle;
        }
        low
    }

    fn furthest(&self, place: &Place, square: f64) -> f64 {
        square + 2.0 * place.step * self.slopes(place, square)[1]
    }

    /// Half of the least and of the greatest change of the square for each unit of the parameter.
    fn slopes(&self, place: &Place, square: f64) -> [f64; 2] {
        let accel = self.machine.accel_mm_s2;
        let mut slopes = [f64::NEG_INFINITY, f64::INFINITY];
        for (first, second) in place.first.iter().zip(place.second).filter(|(first, _)| first.abs() > 1e-12) {
            let ends = [-accel, accel].map(|accel| (accel - second * square) / first);
            slopes = [slopes[0].max(ends[0].min(ends[1])), slopes[1].min(ends[0].max(ends[1]))];
        }
        slopes
    }

    fn places(&self) -> Vec<Place> {
        let mut places = Vec::new();
        for index in 0..self.units.len() {
            let line_mm = self.lengths_mm[index] - self.reaches_mm[index] - self.reaches_mm[index + 1];
            let unit = self.units[index];
            if line_mm > 1e-9 {
                let (second, cap, step) = ([0.0; AXES], self.nominals[index], line_mm / LINE_PARTS as f64);
                places.extend((0..LINE_PARTS).map(|_| Place { first: unit, second, cap, step }));
            }
            let reach_mm = self.reaches_mm[index + 1];
            if reach_mm == 0.0 {
                // Where it stops, nothing is reached.
                if index + 1 < self.units.len() && self.caps[index + 1] == 0.0 {
                    places.push(Place { first: unit, second: [0.0; AXES], cap: 0.0, step: 0.0 });
                }
                continue;
            }
            let next = self.units[index + 1];
            let second: [f64; AXES] = std::array::from_fn(|axis| (next[axis] - unit[axis]) / (2.0 * reach_mm));
            for part in 0..PARTS {
                let share = (part as f64 + 0.5) / PARTS as f64;
                let first = std::array::from_fn(|axis| unit[axis] * (1.0 - share) + next[axis] * share);
                let bent = (0..AXES).filter(|&axis| second[axis].abs() > 1e-12);
                let cap = bent.map(|axis| self.machine.accel_mm_s2 / second[axis].abs()).fold(f64::INFINITY, f64::min);
                let nominal = self.nominals[index].max(self.nominals[index + 1]);
                // Where an axis stands still, nothing but its bend counts.
                let still = (0..AXES).filter(|&axis| f64::abs(first[axis]) < 1e-3).count();
                let cap = if still > 0 { cap.min(nominal) } else { nominal };
                places.push(Place { first, second, cap, step: 2.0 * reach_mm / PARTS as f64 });
            }
        }
        places
    }
}
