//! The levels of the laser's pin: dark when nothing asked for light, and, only if somebody says that nothing is
//! connected, its share at some powers.

use anyhow::Result;

use super::super::stamped::Stamped;
use crate::measure::{Better, Figure, Findings};

/// The pad of the PWM.
const PAD: u8 = 13;
const POWERS: [u32; 3] = [250, 500, 1_000];

pub fn measure(board: &mut Stamped, found: &mut Findings) -> Result<()> {
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
