//! Says in words what keeps a program from going faster.

use super::{BOARD_MOVES_PER_S, CornerLimit, LEAST_SHOWN_S, Pace, Rule, Second, SlowPlace, Why};

use isostep_console::Settings;

use crate::remarks::{AXIS_NAMES, words};

/// A limit that holds for a smaller part of the time is left out.
const LEAST_SHOWN_PERCENT: f64 = 0.05;
/// The number of slow places that are printed.
const WORST_REPORTED: usize = 3;

/// `the feed 62.0 %, corners 21.3 %`: the limit that holds for longest comes first; limits that hardly ever hold are
/// left out.
pub fn limited_by(pace: &Pace) -> String {
    if pace.limits_changed {
        return "what is not reported: the program changes its limits on the way".to_owned();
    }
    let shares = &pace.shares;
    let top_speeds = AXIS_NAMES.iter().zip(shares.top_speed_s).map(|(name, s)| (format!("{name}'s top speed"), s));
    let others = [
        ("the feed", shares.feed_s),
        ("acceleration at corners", shares.corners_s),
        ("acceleration at stops", shares.standstill_s),
        ("a curved speed profile", shares.speed_profile_s),
        ("short moves", shares.short_moves_s),
        ("the look-ahead", shares.look_ahead_s),
        ("shapers at stops", shares.shaping_s),
        ("standing", shares.standing_s),
    ];
    let others = others.map(|(name, s)| (name.to_owned(), s));
    let (feed, others) = others.split_at(1);
    let mut named = [feed, &top_speeds.collect::<Vec<_>>(), others].concat();
    named.sort_by(|one, other| other.1.total_cmp(&one.1));
    let total_s = pace.total_s();
    let shares = named.into_iter().map(|(name, s)| (name, 100.0 * s / total_s));
    let reported = shares.filter(|(_, percent)| *percent >= LEAST_SHOWN_PERCENT);
    let reported = reported.map(|(name, percent)| format!("{name} {percent:.1} %"));
    reported.collect::<Vec<_>>().join(", ")
}

/// `0.316 s at 94 corners, 0.114 s at 1 stop`; `None` where hardly any time is lost.
pub fn lost(pace: &Pace) -> Option<String> {
    let kinds = pace.slow.kinds.iter().filter(|kind| kind.lost_s >= LEAST_SHOWN_S && kind.why != Why::Ends);
    let reported: Vec<_> =
        kinds.map(|kind| format!("{:.3} s at {}", kind.lost_s, counted(kind.why, kind.count))).collect();
    (!reported.is_empty()).then(|| reported.join(", "))
}

fn counted(why: Why, count: usize) -> String {
    let (one, many) = match why {
        Why::Corner => ("corner", "corners"),
        Why::Arc => ("arc", "arcs"),
        Why::ExactStop => ("exact stop (G61.1, holes)", "exact stops (G61.1, holes)"),
        Why::Thirds => ("stop of the thirds split ($900)", "stops of the thirds split ($900)"),
        Why::Stop => ("stop", "stops"),
        Why::SpeedProfile => (
            "move too short for its curved speed profile ($940)",
            "moves too short for their curved speed profile ($940)",
        ),
        Why::ShortMoves => ("short move", "short moves"),
        Why::LookAhead => ("end of the look-ahead", "ends of the look-ahead"),
        Why::Ends => ("end", "ends"),
    };
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A line for each of the places that cost the most time, [`corners`] apart. Places that cost hardly any time are left
/// out.
pub fn worst(pace: &Pace) -> impl Iterator<Item = String> + '_ {
    let places = pace.slow.worst.iter().filter(|place| place.lost_s >= LEAST_SHOWN_S && place.why != Why::Corner);
    places.take(WORST_REPORTED).map(|each| format!("{}: {}", place(each), each.why.words()))
}

/// A line for each of the corners that cost the most time, with what would make it faster. Corners that cost hardly any
/// time are left out.
pub fn corners(pace: &Pace) -> impl Iterator<Item = String> + '_ {
    let corners = pace.slow.corners.iter().filter(|place| place.lost_s >= LEAST_SHOWN_S);
    corners.map(|corner| format!("{}: {}", place(corner), corner.limit.map_or(String::new(), faster)))
}

/// The change that would make a corner faster.
fn faster(limit: CornerLimit) -> String {
    let CornerLimit { rule, axis, deviation_mm } = limit;
    let acceleration = format!("more acceleration of {}", AXIS_NAMES[axis]);
    match rule {
        Rule::Junction => format!("faster with $11 above {deviation_mm:.3} mm, or {acceleration}"),
        Rule::Deviation => format!("faster with P of G64 above {deviation_mm:.3} mm, or {acceleration}"),
        Rule::Room => format!("faster with longer moves, or {acceleration}; not with another P of G64"),
        Rule::NoBlend => "a stop, as it is too sharp for a blend between such short moves, or came too late".to_owned(),
        Rule::Reversal => format!("a stop, as the path goes back; shorter with {acceleration}"),
    }
}

fn place(place: &SlowPlace) -> String {
    let line = place.lines[1].map_or(String::new(), |line| format!("line {line}, "));
    let turn =
        if place.turn_deg > 0.05 { format!(" turns by {:.0} degrees and", place.turn_deg) } else { String::new() };
    format!(
        "{line}at {}:{turn} goes at {:.1} of {:.1} mm/s, {:.3} s lost",
        words(place.place_mm.map(|mm| format!("{mm:.2}"))),
        place.taken_mm_s,
        place.asked_mm_s,
        place.lost_s
    )
}

/// The place of this second in time and program, its speed and the number of its moves, in words.
pub fn second(second: &Second) -> String {
    let lines = match second.lines {
        [Some(first), Some(last)] if first != last => format!(", lines {first} to {last}"),
        [Some(line), _] | [None, Some(line)] => format!(", line {line}"),
        [None, None] => String::new(),
    };
    format!(
        "from {:.1} s on, {:.2} mm/s on average, moves that begin: {}{lines}",
        second.start_s, second.mean_mm_s, second.moves_begun
    )
}

/// A sentence about moves that come faster than the board plans them; `None` if it carries them.
pub fn beyond_board(pace: &Pace) -> Option<String> {
    if pace.longer_on_board_s < LEAST_SHOWN_S {
        return None;
    }
    let busiest =
        pace.busiest_second.as_ref().map_or(String::new(), |second| format!("{} moves a second, ", second.moves_begun));
    Some(format!(
        "{busiest}where it plans {BOARD_MOVES_PER_S:.0} (emulated, docs/figures.md): it takes at least {:.3} s longer there",
        pace.longer_on_board_s
    ))
}

/// The axis that comes nearest to its top speed.
pub fn fastest(pace: &Pace, settings: &Settings) -> Option<String> {
    let axis = pace.fastest_axis?;
    let of = &pace.axes[axis];
    let unit = if settings.is_rotary(axis) { "degrees/s" } else { "mm/s" };
    Some(format!(
        "{}: {:.2} of {:.2} {unit}, {:.0} %",
        AXIS_NAMES[axis],
        of.highest_mm_s,
        of.top_mm_s,
        100.0 * of.share
    ))
}

#[cfg(test)]
mod tests {
    use isostep_sim::{Config, run};

    use super::*;

    fn pace(program: &str) -> Pace {
        Pace::of(&run(program.as_bytes(), &Config::default()).unwrap())
    }

    #[test]
    fn of_changed_limits_nothing_is_claimed() {
        let pace = pace("$100=100\nG0 X150\nG4 P0\n$100=50\nG0 X0\n");
        assert_eq!(limited_by(&pace), "what is not reported: the program changes its limits on the way");
        assert_eq!(
            (lost(&pace), worst(&pace).count(), corners(&pace).count(), fastest(&pace, &Settings::DEFAULT)),
            (None, 0, 0, None)
        );
    }

    #[test]
    fn losses_that_would_read_as_nothing_are_left_out() {
        let mut pace = pace("G1 X10 F3000\nY10\n");
        assert!(lost(&pace).is_some() && corners(&pace).count() == 1, "{pace:?}");
        pace.slow.kinds.iter_mut().for_each(|kind| kind.lost_s = 0.0004);
        pace.slow.corners[0].lost_s = 0.0004;
        assert_eq!((lost(&pace), corners(&pace).count()), (None, 0));
    }
}
