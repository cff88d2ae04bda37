//! A share of the worlds, for a machine of several; and its line of JSON, which a sum of all shares is made from.

use std::fmt;
use std::str::FromStr;

use isostep_sim::swarm::{Amount, Failure};
use serde::Serialize;

use super::again;

/// The worlds of one machine among several: every `of`th, from the `number`th on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

impl Shard {
    /// Its seeds among those from `first` on, in order.
    pub fn seeds(self, first: u64) -> impl Iterator<Item = u64> {
        (first + self.number - 1..).step_by(self.of as usize)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        let (number, of) = numbers.ok_or(format!("`{text}` is not like 2/8, the second of eight"))?;
        if (1..=of).contains(&number) { Ok(Self { number, of }) } else { Err(format!("there is no shard {text}")) }
    }
}

/// The result of a shard, as its line.
#[derive(Debug, Serialize)]
pub struct Line<'a> {
    shard: String,
    worlds: u64,
    machine_s: f64,
    lines: u64,
    steps: u64,
    faults: u64,
    sections: u64,
    took_s: f64,
    failures: Vec<Failed<'a>>,
}

#[derive(Debug, Serialize)]
struct Failed<'a> {
    seed: u64,
    promise: &'a str,
    found: &'a str,
    again: String,
}

impl<'a> Line<'a> {
    /// The result of `worlds` worlds, in `took_s` seconds.
    pub fn new(shard: Shard, worlds: u64, amount: Amount, took_s: f64, failed: &'a [(u64, Failure)]) -> Self {
        let Amount { virtual_ns, faults, lines, steps, sections } = amount;
        let failures = failed.iter().map(|(seed, failure)| Failed {
            seed: *seed,
            promise: failure.promise,
            found: &failure.found,
            again: again(*seed, None),
        });
        Self {
            shard: shard.to_string(),
            worlds,
            machine_s: virtual_ns as f64 * 1e-9,
            lines,
            steps,
            faults,
            sections,
            took_s,
            failures: failures.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_have_each_seed_once() {
        let mut seeds: Vec<u64> = Vec::new();
        for number in 1..=3 {
            let shard: Shard = format!("{number}/3").parse().unwrap();
            seeds.extend(shard.seeds(10).take_while(|seed| *seed < 20));
        }
        seeds.sort_unstable();
        assert_eq!(seeds, (10..20).collect::<Vec<_>>());
        let whole: Shard = "1/1".parse().unwrap();
        assert_eq!(whole.seeds(5).take(3).collect::<Vec<_>>(), [5, 6, 7]);
    }

    #[test]
    fn what_is_no_shard_is_refused_in_words() {
        for (text, words) in [("2", "is not like 2/8"), ("0/3", "no shard 0/3"), ("4/3", "no shard 4/3"), ("1/0", "no")]
        {
            let refused = text.parse::<Shard>().unwrap_err();
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn a_failure_is_in_the_line_with_what_shows_it_again() {
        let failed = [(17, Failure { promise: "no panic", found: "a panic".to_owned(), act: None })];
        let amount = Amount { virtual_ns: 1_500_000_000, ..Amount::default() };
        let line = serde_json::to_value(Line::new("2/4".parse().unwrap(), 3, amount, 1.0, &failed)).unwrap();
        assert_eq!((&line["shard"], &line["worlds"], &line["machine_s"]), (&"2/4".into(), &3.into(), &1.5.into()));
        assert_eq!(line["failures"][0]["promise"], "no panic");
        assert!(line["failures"][0]["again"].as_str().unwrap().ends_with(" swarm --seed 17"));
    }
}
