//! The time on a path by two passes with the exact bounds of the chain's blends, in which each axis has one acceleration.

use isostep_motion::AXES;
use isostep_report::fastest::Path;

/// Planned with axes that are alike, s.
pub fn time_s(path: &Path, accel_mm_s2: f64) -> f64 {
    TwoPasses { path, accel_mm_s2 }.time_s()
}

struct TwoPasses<'a> {
    path: &'a Path,
    accel_mm_s2: f64,
}

impl TwoPasses<'_> {
    fn along(&self, index: usize) -> f64 {
        self.path.lines[index].unit.iter().map(|unit| self.accel_mm_s2 / unit.abs()).fold(f64::INFINITY, f64::min)
    }

    fn reach_mm(&self, corner: usize) -> f64 {
        self.path.corners[corner].reach_mm
    }

    /// The highest squared speed at one end of a blend, by that at the other end.
    fn bound(&self, corner: usize, [own, other]: [usize; 2], square: f64) -> f64 {
        let cap = self.path.corners[corner].cap;
        let room = 2.0 * self.reach_mm(corner) * self.accel_mm_s2;
        if room == 0.0 {
            return square.min(cap);
        }
        let [own, other] = [own, other].map(|index| &self.path.lines[index].unit);
        let axes = (0..AXES).filter(|&axis| own[axis] * other[axis] >= 0.0 && own[axis] != 0.0);
        axes.fold(cap, |least, axis| {
            let (own, other) = (own[axis].abs(), other[axis].abs());
            let speed = (square.sqrt() * other + (square * other * other + 4.0 * room * own).sqrt()) / (2.0 * own);
            least.min(speed * speed)
        })
    }

    fn time_s(&self) -> f64 {
        let lines = &self.path.lines;
        let n = lines.len();
        let (mut ins, mut outs) = (vec![0.0_f64; n + 1], vec![0.0_f64; n + 1]);
        let shortest =
            |index: usize| (lines[index].length_mm - self.reach_mm(index) - self.reach_mm(index + 1)).max(0.0);
        let gain = |index: usize| 2.0 * self.along(index) * shortest(index);
        for index in (1..n).rev() {
            let most = (ins[index + 1] + gain(index)).min(lines[index].nominal).min(self.path.corners[index].cap);
            ins[index] = self.bound(index, [index - 1, index], most).min(lines[index - 1].nominal);
            outs[index] = most.min(self.bound(index, [index, index - 1], ins[index]));
        }
        let mut total_s = 0.0;
        for index in 0..n {
            let most = outs[index] + gain(index);
            if most < ins[index + 1] {
                ins[index + 1] = most;
                outs[index + 1] = outs[index + 1].min(self.bound(index + 1, [index + 1, index], most));
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
        let length_mm = self.path.lines[index].length_mm
            - self.reach_mm(index) * part(entry, begin)
            - self.reach_mm(index + 1) * part(exit, end);
        let accel = self.along(index);
        let mut took_s = 0.0;
        if length_mm > 1e-9 {
            let nominal = self.path.lines[index].nominal;
            let peak = ((entry + exit) / 2.0 + accel * length_mm).min(nominal).max(entry).max(exit);
            let ramps_mm = (2.0 * peak - entry - exit) / (2.0 * accel);
            took_s = (2.0 * peak.sqrt() - entry.sqrt() - exit.sqrt()) / accel
                + (length_mm - ramps_mm).max(0.0) / peak.sqrt();
        }
        if self.reach_mm(index + 1) > 0.0 {
            took_s += 2.0 * self.reach_mm(index + 1) / end[0].max(end[1]).sqrt();
        }
        took_s
    }
}
