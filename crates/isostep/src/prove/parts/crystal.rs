//! The crystal against the frames of USB, of which the host sends one each millisecond by a clock of its own.

use anyhow::Result;

use super::super::stamped::Stamped;
use crate::measure::{Better, Figure, Findings};

/// Frames are counted modulo this.
const FRAMES: f64 = 2_048.0;
const FRAME_US: f64 = 1_000.0;

pub fn measure(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let [from_frame, from_us] = board.session.numbers("$PROVE=FRAME", "FRAME")?;
    board.session.wait(board.how.effort.crystal_s)?;
    let [to_frame, to_us] = board.session.numbers("$PROVE=FRAME", "FRAME")?;
    let figure = Figure::new("crystal", "the chip's clock against the frames of this computer's USB", "ppm");
    let (frames, ppm) = fast_ppm([from_frame, to_frame], to_us - from_us);
    let figure = if frames > 0.0 {
        let resolution_ppm = 2.0 / (frames * FRAME_US) * 1e6;
        figure
            .measured(ppm, format!("{resolution_ppm:.2} ppm, over {frames:.0} frames"))
            .flattered_by("both clocks are in it: a computer's may be off by 100 ppm itself, and is allowed 500")
            .compared(Better::Neither, 0.0, 100.0)
    } else {
        figure.missing("no frame was counted: the console is not on USB")
    };
    found.add(figure);
    Ok(())
}

/// How many frames there were, and how much faster than they the chip's clock is, ppm. The clock says about how many
/// there were, the numbers exactly.
fn fast_ppm([from, to]: [f64; 2], us: f64) -> (f64, f64) {
    let apart = (to - from).rem_euclid(FRAMES);
    let turns = ((us / FRAME_US - apart) / FRAMES).round();
    let frames = apart + turns * FRAMES;
    (frames, if frames > 0.0 { (us / (frames * FRAME_US) - 1.0) * 1e6 } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::fast_ppm;

    #[test]
    fn frames_are_counted_beyond_their_numbers() {
        let us = 28_820_000.0 * (1.0 + 20e-6);
        let (frames, ppm) = fast_ppm([2_000.0, 100.0], us);
        assert_eq!(frames, 148.0 + 14.0 * 2_048.0);
        assert!((ppm - 20.0).abs() < 0.01, "{ppm}");
        assert_eq!(fast_ppm([0.0, 0.0], 10.0), (0.0, 0.0));
    }
}
