//! Where the beam was on, and for how long: combines the positions between the edges with the spells of the tool.

use crate::tool::spells::Spell;
use isostep_sim::Outcome;
use isostep_sim::measure::across;

/// The position of the carriage between two steps of X or Y.
struct Stand {
    since_ns: u64,
    steps: [i32; 2],
}

/// Calls `take` with every position at which the beam was on, X and Y in steps, and with the dose there, which is duty
/// times s. In order of time.
pub fn places(outcome: &Outcome, spells: &[Spell], take: &mut impl FnMut([i32; 2], f64)) {
    let mut stands = stands(outcome).peekable();
    let mut spells = spells.iter().peekable();
    while let Some(Stand { since_ns, steps }) = stands.next() {
        let until_ns = stands.peek().map_or(u64::MAX, |next| next.since_ns);
        while let Some(spell) = spells.peek() {
            let (begin_ns, end_ns) = (spell.begin_ns.max(since_ns), spell.end_ns.min(until_ns));
            if begin_ns < end_ns {
                take(steps, (end_ns - begin_ns) as f64 * 1e-9 * spell.duty_ratio);
            }
            if spell.end_ns > until_ns {
                break;
            }
            spells.next();
        }
    }
}

/// All positions of the program, in order. Homing is left out because it resets the origin.
fn stands(outcome: &Outcome) -> impl Iterator<Item = Stand> {
    across::runs(outcome).flat_map(|(_, run)| {
        let [x, y, ..] = run[0].origin_steps;
        let mut steps = [x, y];
        let edges = outcome.edges[run[0].edges.start..run[run.len() - 1].edges.end].iter().filter(|edge| edge.axis < 2);
        let after = edges.map(move |edge| {
            steps[edge.axis] += edge.direction;
            Stand { since_ns: edge.t_ns, steps }
        });
        std::iter::once(Stand { since_ns: run[0].begin_ns(), steps: [x, y] }).chain(after)
    })
}
