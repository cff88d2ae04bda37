//! Ratios of our times to Grbl's, their medians, and whether they keep their bounds.

use isostep_console::Settings;
use isostep_sim::AXES;
use serde::Serialize;

use super::simulate::{Job, Made};
use super::table::Table;

/// The highest allowed ratios.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Bounds {
    pub median: f64,
    pub each: f64,
}

/// The times of all columns.
#[derive(Debug, Serialize)]
pub struct Report {
    pub bounds: Bounds,
    pub columns: Vec<ColumnTimes>,
    /// Over all columns; null if no program reached its end.
    pub all: Option<Ratios>,
    /// The same of times with blends divided by those of each move by itself, and by the shortest ones.
    pub all_of_one_by_one: Option<Ratios>,
    pub all_of_fastest: Option<Ratios>,
}

/// The times of a column.
#[derive(Debug, Serialize)]
pub struct ColumnTimes {
    /// The name in the table, without its unit.
    pub name: String,
    pub machine: Machine,
    /// Every feed was replaced by F12000.
    pub is_max_feed: bool,
    pub programs: Vec<Times>,
    /// Null if no program reached its end.
    pub ratios: Option<Ratios>,
    /// The same with blends.
    pub blends: Option<Ratios>,
    /// Times with blends divided by those of each move by itself, and by the shortest ones.
    pub of_one_by_one: Option<Ratios>,
    pub of_fastest: Option<Ratios>,
}

/// The machine's settings that determine times.
#[derive(Debug, Default, Serialize)]
pub struct Machine {
    pub name: String,
    pub steps_per_mm: [f32; AXES],
    pub top_speed_mm_min: [f32; AXES],
    pub accel_mm_s2: [f32; AXES],
}

/// The times of a program on a machine.
#[derive(Debug, Serialize)]
pub struct Times {
    pub program: String,
    pub isostep_s: Option<f64>,
    pub grbl_s: f64,
    /// Our time divided by Grbl's.
    pub ratio: Option<f64>,
    /// The time if corners are blends, and the same divided by Grbl's.
    pub blends_s: Option<f64>,
    pub blends_ratio: Option<f64>,
    /// The time if corners are blends and each move is made by itself, and the time with blends divided by it.
    pub one_by_one_s: Option<f64>,
    pub of_one_by_one: Option<f64>,
    /// The shortest time on that path, and the time with blends divided by it. Null where there are no blends.
    pub fastest_s: Option<f64>,
    pub of_fastest: Option<f64>,
    /// Number of moves, how many of them were taken together with others, and the farthest that a line made of several is from
    /// where one of them was to end, mm; 0 if there is none.
    pub moves: Option<usize>,
    pub together: Option<usize>,
    pub beside_mm: Option<f64>,
    /// The largest jump of an axis's speed at a corner, without blends.
    pub jump_mm_s: Option<f64>,
    /// Why there is no time.
    pub failed: Option<String>,
}

/// Many ratios summarised in two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratios {
    pub median: f64,
    pub worst: f64,
}

impl Report {
    /// The report on the runs of a table's programs.
    pub fn new(
        table: &Table,
        machines: Vec<(String, Settings)>,
        timed: Vec<(Job, Result<Made, String>)>,
        bounds: Bounds,
    ) -> Self {
        let mut columns: Vec<ColumnTimes> = table
            .columns
            .iter()
            .map(|column| {
                let machine = machines.iter().find(|(name, _)| *name == column.machine).map(Machine::of);
                ColumnTimes {
                    name: column.name.clone(),
                    machine: machine.unwrap_or_default(),
                    is_max_feed: column.is_max_feed,
                    programs: Vec::new(),
                    ratios: None,
                    blends: None,
                    of_one_by_one: None,
                    of_fastest: None,
                }
            })
            .collect();
        for (job, made) in timed {
            columns[job.column].programs.push(Times::of(job, made));
        }
        for column in &mut columns {
            let ratios = |of: fn(&Times) -> Option<f64>| Ratios::of(column.programs.iter().filter_map(of));
            (column.ratios, column.blends) = (ratios(|times| times.ratio), ratios(|times| times.blends_ratio));
            (column.of_one_by_one, column.of_fastest) =
                (ratios(|times| times.of_one_by_one), ratios(|times| times.of_fastest));
        }
        let all = |of: fn(&Times) -> Option<f64>| {
            Ratios::of(columns.iter().flat_map(|column| &column.programs).filter_map(of))
        };
        let all_of_one_by_one = all(|times| times.of_one_by_one);
        let (all, all_of_fastest) = (all(|times| times.ratio), all(|times| times.of_fastest));
        Self { bounds, columns, all, all_of_one_by_one, all_of_fastest }
    }

    /// Each bound that is exceeded, in words.
    pub fn broken(&self) -> Vec<String> {
        let Bounds { median: median_max, each: each_max } = self.bounds;
        let mut broken = Vec::new();
        let times: Vec<_> = self.columns.iter().flat_map(|column| &column.programs).collect();
        let failed = times.iter().filter(|times| times.failed.is_some()).count();
        if failed > 0 {
            broken.push(format!("{failed} of {} runs did not come to their end", times.len()));
        }
        let above = times.iter().filter(|times| times.ratio > Some(each_max)).count();
        if above > 0 {
            broken.push(format!("{above} of {} ratios are above {each_max} (--each)", times.len()));
        }
        let medians =
            self.columns.iter().map(|column| (column.name.as_str(), column.ratios)).chain([("all", self.all)]);
        for (name, ratios) in medians {
            if let Some(Ratios { median, .. }) = ratios.filter(|ratios| ratios.median > median_max) {
                broken.push(format!("the median of {name}, {median:.3}, is above {median_max} (--median)"));
            }
        }
        broken
    }
}

impl Machine {
    fn of((name, settings): &(String, Settings)) -> Self {
        Self {
            name: name.clone(),
            steps_per_mm: settings.steps_per_mm,
            top_speed_mm_min: settings.max_rate_mm_min,
            accel_mm_s2: settings.accel_mm_s2,
        }
    }
}

impl Times {
    fn of(Job { name: program, grbl_s, .. }: Job, made: Result<Made, String>) -> Self {
        let ran = made.as_ref().ok().copied();
        Self {
            program,
            grbl_s,
            isostep_s: ran.map(|made| made.s),
            ratio: ran.map(|made| made.s / grbl_s),
            blends_s: ran.map(|made| made.blends_s),
            blends_ratio: ran.map(|made| made.blends_s / grbl_s),
            one_by_one_s: ran.map(|made| made.one_by_one_s),
            of_one_by_one: ran.map(|made| made.blends_s / made.one_by_one_s),
            fastest_s: ran.and_then(|made| made.fastest_s),
            of_fastest: ran.and_then(|made| Some(made.blends_s / made.fastest_s?)),
            moves: ran.map(|made| made.moves),
            together: ran.map(|made| made.together.moves),
            beside_mm: ran.map(|made| made.together.farthest_mm),
            jump_mm_s: ran.map(|made| made.jump_mm_s),
            failed: made.err(),
        }
    }
}

impl Ratios {
    fn of(ratios: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<_> = ratios.collect();
        sorted.sort_by(f64::total_cmp);
        let (low, high) = (sorted.get(sorted.len().checked_sub(1)? / 2)?, sorted.get(sorted.len() / 2)?);
        Some(Self { median: (low + high) / 2.0, worst: *sorted.last()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(Ratios::of([].into_iter()), None);
        assert_eq!(Ratios::of([3.0].into_iter()), Some(Ratios { median: 3.0, worst: 3.0 }));
        assert_eq!(Ratios::of([3.0, 1.0, 2.0].into_iter()), Some(Ratios { median: 2.0, worst: 3.0 }));
        assert_eq!(Ratios::of([4.0, 1.0, 2.0, 3.0].into_iter()), Some(Ratios { median: 2.5, worst: 4.0 }));
    }
}
