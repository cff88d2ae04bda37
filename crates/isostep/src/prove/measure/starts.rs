//! How soon a move begins: what the machine adds between its line and its first edge.
//!
//! # Method
//! A line that pulls a pad down comes right before the line of the move, in one packet. The pad is stamped, so the time
//! from there to the start of the move is on one clock: to read a line, plan, compile, and let all axes go.

use anyhow::{Context, Result, ensure};

use super::super::board::Answer;
use super::super::edges;
use super::super::proof::{Better, Figure};
use super::{Bench, Jumper, OUT, PADS, together};

/// What is done right before the line of the move, and the name of it.
const KINDS: [(&str, &str, &str); 2] = [
    ("warm", "$PROVE=OUT,0", "right after a move of the same kind"),
    ("cold", "$PROVE=COLD", "with flash's cache empty"),
];

pub fn measure(bench: &mut Bench) -> Result<()> {
    let (machine, mut course) = together(100_000, 0.02, 0.0)?;
    bench.set_up(&machine)?;
    ensure!(
        !bench.how.jumpers.contains(&Jumper::Estop),
        "the pad that is pulled down would press the emergency stop: take the wire away"
    );
    // The wire may lead to a limit switch.
    bench.board.ask("$21=0")?;
    for (key, before, what) in KINDS {
        let mut delays_ms = Vec::new();
        for index in 0..=bench.how.effort.starts {
            bench.board.ask("$PROVE=OUT")?;
            bench.board.arm([PADS[0], PADS[1], OUT], 0)?;
            let moved = course.line();
            bench.board.say(&format!("{before}\n{moved}\n"))?;
            for line in [before, &moved] {
                let answer = bench.board.answer(line)?;
                ensure!(matches!(answer, Answer::Done(_)), "`{line}` was answered {answer:?}");
            }
            bench.board.wait(course.duration_s())?;
            bench.board.rest()?;
            let stamps = bench.board.read(0)?;
            let pulled_ns =
                stamps[2].instants_ns().first().copied().with_context(|| format!("GP{OUT} was not seen to go low"))?;
            let verdict = edges::judge(&course, &bench.windows(&[0, 1], &stamps, 0));
            // The first one warms up.
            if index > 0 {
                delays_ms.push((verdict.start_ns - pulled_ns) * 1e-6);
            }
            course = course.back();
        }
        let most_ms = delays_ms.iter().copied().fold(0.0, f64::max);
        let what = format!("from the line before it to the start of a move, {what}, at most");
        let figure = Figure::new(format!("start.{key}"), what, "ms")
            .measured(most_ms, format!("16 ns, {} starts", delays_ms.len()))
            .flattered_by("both lines come in one packet, so the time on the cable is not in it")
            .compared(Better::Lower, 0.15, 0.2);
        bench.add(figure);
    }
    bench.board.ask("$PROVE=OUT").map(drop)
}
