//! Texts printed for a machine on a pseudo-terminal: how to reach it, and a summary at its end.

use std::fmt::Write;
use std::path::Path;

use super::Closing;
use super::bridge::Tally;
use crate::flight::{Flight, WINDOW_BYTES};
use isostep_console::AXIS_NAMES;
use isostep_report::remarks::words;

/// Hints for reaching the machine.
pub fn hints(path: &Path) -> String {
    let path = path.display();
    format!(
        "A Grbl 1.1 port at 115200 baud for any sender, for as long as this runs; Ctrl-C ends it.\n  \
         terminal   isostep console {path}\n  \
         Python     python3 -m serial.tools.miniterm --eol LF {path} 115200\n  \
         senders    docs/senders.md\n"
    )
}

/// The summary of a run.
pub fn text(duration_ns: u64, tally: &Tally, closing: &Closing) -> String {
    let mut text = String::from("\n");
    machine(&mut text, duration_ns, tally.behind_s, closing).expect("a String takes all");
    let Tally { bytes_in, bytes_out, dropped_bytes, .. } = tally;
    let dropped = match dropped_bytes {
        0 => String::new(),
        count => format!(", {count} of them dropped: the client did not read them within 0.2 s"),
    };
    text += &format!("console         {bytes_in} bytes in, {bytes_out} out{dropped}\n");
    text + &flight(&tally.flight)
}

fn machine(text: &mut String, duration_ns: u64, behind_s: f64, closing: &Closing) -> std::fmt::Result {
    let place = words(closing.position_mm.map(|mm| format!(" {mm:.3}")));
    let steps = closing.position_steps.map(|n| n.to_string()).join(", ");
    let each: Vec<_> = AXIS_NAMES.iter().zip(closing.steps).map(|(name, n)| format!("{name} {n}")).collect();
    let lost = closing.steps_lost.map_or(String::new(), |lost| format!(", {lost} lost by the motors"));
    let behind = if behind_s > 0.0 { format!(", {behind_s:.1} s behind the wall clock") } else { String::new() };
    writeln!(text, "machine time    {:.3} s{behind}", duration_ns as f64 * 1e-9)?;
    writeln!(text, "state           {}", closing.state)?;
    writeln!(text, "position        {place} mm ({steps} steps)")?;
    writeln!(text, "steps           {} ({}){lost}", closing.steps.iter().sum::<u64>(), each.join(", "))
}

fn flight(flight: &Flight) -> String {
    let Flight { lines, answered, refused, alarms, most, times_over, .. } = flight;
    let over = match times_over {
        0 => format!("never more than the {WINDOW_BYTES} of Grbl's buffer"),
        1 => format!("once more than the {WINDOW_BYTES} of Grbl's buffer"),
        n => format!("{n} times more than the {WINDOW_BYTES} of Grbl's buffer"),
    };
    let refused = if *refused > 0 { format!(", {refused} of them by an error") } else { String::new() };
    let alarms = if *alarms > 0 { format!("; {alarms} alarms") } else { String::new() };
    format!(
        "lines           {lines} sent, {answered} answered{refused}{alarms}\n\
         in flight       at most {most} unanswered bytes, {over}\n"
    )
}
