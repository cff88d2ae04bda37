//! The delay of a move's start: what the machine adds to its plan between a line and the first edge.

use anyhow::Result;

use super::board::Board;
use super::figure::{Better, Figure, Findings};

/// The delays of some starts, without what the plan itself takes to its first step.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    /// With flash's cache empty, ms.
    pub cold_ms: Vec<f64>,
    /// Right after a move of the same kind, ms.
    pub warm_ms: Vec<f64>,
}

/// Measures `count` starts of either kind.
///
/// # Errors
/// When the board is gone.
pub fn measure(board: &mut dyn Board, found: &mut Findings, count: u32) -> Result<()> {
    board.note(&format!("{count} starts, cold and warm"));
    let (measured, method) = (board.starts(count)?, board.method());
    let of = |starts: &Starts, key| if key == "warm" { starts.warm_ms.clone() } else { starts.cold_ms.clone() };
    for (key, what) in [("warm", "right after a move of the same kind"), ("cold", "with flash's cache empty")] {
        let what = format!("from {} to the start of a move, {what}", method.start_from);
        let figure = |key: String, what: String| {
            Figure::new(key, what, "ms").flattered_by(method.starts).compared(Better::Lower, 0.15, 0.2)
        };
        let most = figure(format!("start.{key}"), format!("{what}, at most"));
        match &measured {
            Ok(starts) => {
                let mut sorted_ms = of(starts, key);
                sorted_ms.sort_by(f64::total_cmp);
                let finely = format!("{}, {} starts", super::finely(method.unit_ns), sorted_ms.len());
                let at = |index: usize| sorted_ms.get(index).copied().unwrap_or(f64::NAN);
                let last = sorted_ms.len().saturating_sub(1);
                found.add(most.measured(at(last), &*finely));
                found.add(
                    figure(format!("start.{key}.median"), format!("{what}, median")).measured(at(last / 2), finely),
                );
            }
            Err(why_not) => found.add(most.missing(why_not)),
        }
    }
    Ok(())
}
