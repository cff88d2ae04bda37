//! Compares `PioPort`'s record of the words and edges in flight with a list of all of them.

#[path = "../../boards/pico-gantry/src/pio_port/tally.rs"]
mod tally;

use proptest::prelude::*;

use self::tally::{IN_FLIGHT_MAX, Tally};

/// A write to the port.
#[derive(Clone, Copy, Debug)]
enum Written {
    Rest,
    /// True if the steps go back, and their number.
    Steps(bool, u32),
}

fn written() -> impl Strategy<Value = Written> {
    let steps = |up_to: u32| (any::<bool>(), 1..=up_to).prop_map(|(back, steps)| Written::Steps(back, steps));
    prop_oneof![1 => Just(Written::Rest), 4 => steps(1), 4 => steps(40), 1 => steps(600)]
}

impl Written {
    fn words(self) -> u32 {
        match self {
            Self::Rest => 1,
            Self::Steps(_, steps) => steps,
        }
    }
}

proptest! {
    /// Compares the counts after each write, with the state machine at a random place.
    #[test]
    fn words_and_edges_lead_where_they_were_written_to(
        all in prop::collection::vec((written(), any::<prop::sample::Index>()), 1..300)
    ) {
        let mut tally = Tally::new();
        // `edges_of[n]`: the number of edges after n words. `steps_after[n]`: the position after n edges.
        let (mut edges_of, mut steps_after) = (vec![0_u32], vec![0_i32]);
        for (each, looked_at) in all {
            match each {
                Written::Rest => {
                    tally.write_rest();
                    edges_of.push(edges_of[edges_of.len() - 1]);
                }
                Written::Steps(back, steps) => {
                    tally.write_steps(back, steps);
                    for _ in 0..steps {
                        edges_of.push(edges_of[edges_of.len() - 1] + 1);
                        steps_after.push(steps_after[steps_after.len() - 1] + if back { -1 } else { 1 });
                    }
                }
            }
            let words = edges_of.len() - 1;
            prop_assert!(each.words() <= words as u32);
            let in_flight = looked_at.index(words.min(IN_FLIGHT_MAX as usize) + 1);
            let begun = words - in_flight;
            let edges = edges_of[begun];
            prop_assert_eq!(tally.edges_of(begun as u32), edges);
            prop_assert_eq!(tally.steps_after(edges), steps_after[edges as usize]);
            prop_assert_eq!(tally.written_edges() as usize, steps_after.len() - 1);
        }
    }
}

#[test]
fn a_run_of_nothing_leads_nowhere() {
    let tally = Tally::new();
    assert_eq!((tally.written_edges(), tally.edges_of(0), tally.steps_after(0)), (0, 0, 0));
}

/// Counts wrap around at 32 bits without error.
#[test]
fn counts_wrap_around() {
    let mut tally = Tally::new();
    tally.write_steps(false, u32::MAX - 10);
    tally.write_steps(true, 30);
    assert_eq!(tally.written_edges(), 19);
    let end = tally.steps_after(19);
    assert_eq!(tally.steps_after(18), end + 1);
    assert_eq!(tally.steps_after(u32::MAX - 10), end + 30);
    assert_eq!(tally.steps_after(u32::MAX - 12), end + 28);
    assert_eq!(tally.edges_of(5), 5);
}
