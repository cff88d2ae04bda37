//! How many short moves a second come over this very cable: a curve of them, sent as far ahead as the window of
//! characters allows, at a feed that the core cannot keep.

use std::collections::VecDeque;

use anyhow::{Result, ensure};

use super::super::board::Answer;
use super::super::course::Machine;
use super::super::proof::{Better, Figure};
use super::Bench;
use crate::flight::WINDOW_BYTES;

/// Length of a move, mm.
const MOVE_MM: f64 = 0.2;
/// The curve is an ellipse in space about this place, mm, of this radius.
const CENTRE_MM: f64 = 500.0;
const RADIUS_MM: f64 = 20.0;
/// The machine of the benchmark: no limit of it keeps the moves back.
const SETTINGS: [(u16, u32); 4] = [(100, 80), (110, 48_000), (120, 10_000), (11, 1)];
const FEED_MM_MIN: u32 = 48_000;
/// How far blends may leave the corners, mm.
const BLEND_MM: f64 = 0.05;

pub fn measure(bench: &mut Bench) -> Result<()> {
    // Back to zero while a millimetre is what it was: the same steps are many millimetres afterwards.
    bench.set_up(&Machine::new(100_000, 0.02))?;
    bench.board.ask("G90 G53 G0 X0 Y0 Z0")?;
    bench.board.rest()?;
    for (number, value) in SETTINGS {
        for axis in 0..if number < 100 { 1 } else { 3 } {
            bench.board.ask(&format!("${}={value}", number + axis))?;
        }
    }
    let count = bench.how.effort.moves;
    for (key, what, word) in
        [("exact", "with exact corners", "G61".to_owned()), ("blends", "with blends", format!("G64P{BLEND_MM}"))]
    {
        bench.progress.step(&format!("{count} short moves {what}"));
        bench.board.ask("G21G90G94")?;
        bench.board.ask(&format!("G92X{}Y{CENTRE_MM}Z{CENTRE_MM}", CENTRE_MM + RADIUS_MM))?;
        bench.board.ask(&format!("G1F{FEED_MM_MIN}{word}"))?;
        let per_s = rate(bench, &lines(count))?;
        bench.board.rest()?;
        let figure = Figure::new(
            format!("moves.{key}"),
            format!("short moves of 3 axes a second over this cable, {what}"),
            "moves/s",
        )
        .measured(per_s.round(), format!("by the {count} answers, in the middle half"))
        .flattered_by(
            "a curve of one shape; the cable and this computer count too, so a hub or a busy computer makes it less",
        )
        .compared(Better::Higher, 0.05, 0.0);
        bench.add(figure);
        let alarm = bench.board.take_alarm();
        ensure!(alarm.is_none(), "the moves ended in {}", alarm.unwrap_or_default());
    }
    Ok(())
}

/// The lines of a curve, each a move of [`MOVE_MM`].
fn lines(count: u32) -> Vec<String> {
    let line = |index: u32| {
        let angle = f64::from(index + 1) * MOVE_MM / RADIUS_MM;
        let (x, y) = (CENTRE_MM + RADIUS_MM * angle.cos(), CENTRE_MM + RADIUS_MM * angle.sin());
        format!("X{x:.3}Y{y:.3}Z{:.3}", CENTRE_MM + (y - CENTRE_MM) / 2.0)
    };
    (0..count).map(line).collect()
}

/// Sends the lines as far ahead as the board has room for them. Returns how many a second were accepted in the middle
/// half, where the board's queue stays full.
fn rate(bench: &mut Bench, lines: &[String]) -> Result<f64> {
    let (mut unanswered, mut in_flight) = (VecDeque::new(), 0);
    let mut answered_s = Vec::with_capacity(lines.len());
    let mut waiting = lines.iter().peekable();
    while answered_s.len() < lines.len() {
        let mut packet = String::new();
        while let Some(line) = waiting.next_if(|line| in_flight + line.len() < WINDOW_BYTES) {
            in_flight += line.len() + 1;
            unanswered.push_back(line);
            packet += &format!("{line}\n");
        }
        if !packet.is_empty() {
            bench.board.say(&packet)?;
        }
        let Some(line) = unanswered.pop_front() else { break };
        let answer = bench.board.answer(line)?;
        ensure!(matches!(answer, Answer::Done(_)), "`{line}` was answered {answer:?}");
        in_flight -= line.len() + 1;
        answered_s.push(bench.board.now_s());
    }
    let middle = [answered_s.len() / 4, answered_s.len() * 3 / 4];
    let lasted_s = answered_s[middle[1]] - answered_s[middle[0]];
    ensure!(lasted_s > 0.0, "{} answers came at one instant", answered_s.len());
    Ok((middle[1] - middle[0]) as f64 / lasted_s)
}
