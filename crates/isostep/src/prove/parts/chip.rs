//! Figures of the chip: its time to start, its flash, its crystal, and the levels of a pin.

use anyhow::Result;

use super::super::stamped::{Stamped, ramp};
use crate::measure::planned_move::PROVED;
use crate::measure::{Better, Figure, Findings, Machine};

/// A mean is given in hundredths of a cycle.
const PARTS: f64 = 100.0;
/// Frames are counted modulo this.
const FRAMES: f64 = 2_048.0;
const FRAME_US: f64 = 1_000.0;
/// The pad of the PWM.
const PAD: u8 = 13;
const POWERS: [u32; 3] = [250, 500, 1_000];

/// The time from power to ready, as the image itself has noted it.
pub fn ready(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let figure = Figure::new("ready", "from the start of the chip's timer to ready consoles", "ms");
    let figure = figure.compared(Better::Lower, 0.3, 1.0);
    found.add(match board.identity.ready_us {
        Some(us) => figure.measured(us * 1e-3, "1 us").flattered_by(
            "what is before it, some 0.3 s: the boot loader in ROM, and copying the image to RAM by the slow first clock",
        ),
        None => figure.missing("the image does not say"),
    });
    Ok(())
}

/// The cost of reading flash on this chip: the one assumption of the emulator that no data sheet settles.
pub fn cache(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let [hit, cold, uncached] = board.session.numbers::<3>("$PROVE=CACHE", "CACHE")?.map(|parts| parts / PARTS);
    let costs = [
        ("cache.hit", "reading a word of flash that is in the cache", hit),
        ("cache.cold", "the same if it is not, a line of 8 bytes each", cold),
        ("cache.uncached", "the same by the alias that has no cache", uncached),
        ("cache.miss", "what a miss costs more than a hit", cold - hit),
    ];
    for (key, what, cycles) in costs {
        let figure = Figure::new(key, what, "cycles")
            .measured(cycles, "0.01 cycles, a mean of many reads")
            .flattered_by("reads one after the other; the instructions around them are counted in")
            .compared(Better::Lower, 0.05, 0.5);
        found.add(figure);
    }
    let machine = Machine::new(100_000, ramp(0.02));
    let planned = machine.straight(PROVED, 0.1)?;
    board.set_up(&machine)?;
    board.session.numbers::<2>("$PROVE=COUNT", "COUNT")?;
    for planned in [planned.clone(), planned.back()] {
        board.make(&planned)?;
    }
    let [hits, accesses] = board.session.numbers("$PROVE=COUNT", "COUNT")?;
    let share = if accesses > 0.0 { 100.0 * hits / accesses } else { 0.0 };
    let what = "reads of flash that its cache answered, in two moves and their lines, by the chip's counters";
    let figure = Figure::new("cache.hits", what, "%")
        .measured((share * 100.0).round() / 100.0, format!("{hits} of {accesses} reads"))
        .compared(Better::Higher, 0.0, 1.0);
    found.add(figure);
    Ok(())
}

/// The crystal against the frames of USB, of which the host sends one each millisecond by a clock of its own.
pub fn crystal(board: &mut Stamped, found: &mut Findings) -> Result<()> {
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

/// The number of frames, and how much faster than they the chip's clock is, ppm. The clock says about how many
/// there were, the numbers exactly.
fn fast_ppm([from, to]: [f64; 2], us: f64) -> (f64, f64) {
    let apart = (to - from).rem_euclid(FRAMES);
    let turns = ((us / FRAME_US - apart) / FRAMES).round();
    let frames = apart + turns * FRAMES;
    (frames, if frames > 0.0 { (us / (frames * FRAME_US) - 1.0) * 1e6 } else { 0.0 })
}

/// The levels of the laser's pin: dark when nothing asked for light, and, only if somebody says that nothing is connected, its share at some powers.
pub fn laser(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let dark = high_percent(board)?;
    let figure =
        Figure::new("laser.dark", format!("the laser's pin (GP{PAD}) is high while nothing asked for light"), "%")
            .measured(dark, "one read of many, over 10 ms")
            .flattered_by("a flash shorter than the time between two reads may not be seen")
            .compared(Better::Lower, 0.0, 0.0)
            .promised(0.0);
    found.add(figure);
    if board.how.laser {
        for setting in ["$32=0", "$30=1000", "$31=0", "$33=1000", "$35=0", "$36=100", "$394=0"] {
            board.session.ask(setting)?;
        }
    }
    for power in POWERS {
        let figure =
            Figure::new(format!("laser.{power}"), format!("the laser's pin is high at M3 S{power} of 1000"), "%");
        if !board.how.laser {
            found.add(figure.missing("needs --laser, and nothing connected to the pin"));
            continue;
        }
        board.session.ask(&format!("M3 S{power}"))?;
        board.session.wait(0.02)?;
        let high = high_percent(board)?;
        board.session.ask("M5")?;
        found.add(figure.measured(high, "some percent: reads over 10 periods").compared(Better::Neither, 0.05, 3.0));
    }
    Ok(())
}

fn high_percent(board: &mut Stamped) -> Result<f64> {
    let [high, of] = board.session.numbers(&format!("$PROVE=PAD,{PAD}"), "PAD")?;
    Ok((1e4 * high / of.max(1.0)).round() / 100.0)
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
