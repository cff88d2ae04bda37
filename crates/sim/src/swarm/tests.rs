//! The swarm itself: that it is the same in every run, and that it sees what is wrong.

use super::*;

#[test]
fn a_seed_is_the_same_world_every_time() {
    for seed in [3, 4] {
        let (one, other) = (Scenario::new(seed), Scenario::new(seed));
        assert_eq!(one.acts, other.acts);
        assert_eq!(run(&one), run(&other));
        assert_ne!(one.acts, Scenario::new(seed + 2).acts);
    }
}
