//! Tables of how the time of a program is spent, and where it is lost.

use isostep_motion::{AXES, BLEND_S, STRAIGHT_S};
use maud::{Markup, html};

use super::theme::AXIS_NAMES;
use crate::pace::{LEAST_SHOWN_S, Pace, Second, SlowPlace, Why};

/// A fraction of the time: its name, its colour and its duration, s.
struct Share {
    name: String,
    colour: &'static str,
    s: f64,
}

/// The table of how the time is spent.
pub fn shares(pace: &Pace) -> Markup {
    let total_s = pace.total_s().max(1e-9);
    let shares: Vec<_> = of(pace).into_iter().filter(|share| share.s > 0.0).collect();
    html! {
        h2 { "Where time goes" }
        p {
            @if !pace.limits_changed { (format!("{:.1} mm in ", pace.distance_mm)) }
            (format!("{}: {} in motion, {} standing", duration(pace.total_s()), duration(pace.moving_s), duration(pace.standing_s)))
            @if pace.moving_s > 0.0 && !pace.limits_changed { (format!("; {:.2} mm/s on the mean while it moves", pace.distance_mm / pace.moving_s)) }
            ". A ramp counts to the slow place that it leads to or comes from. Homing is left out."
            @if pace.limits_changed { " The program changes its limits on the way, so what limits it is not reported." }
        }
        div.shares { @for share in &shares {
            div style=(format!("width: {:.3}%; background: var({})", 100.0 * share.s / total_s, share.colour)) title=(share.name) {}
        } }
        div.scroll { table {
            thead { tr { th { "limited by" } th { "s" } th { "%" } } }
            tbody { @for share in &shares { tr {
                td { span.key style=(format!("background: var({})", share.colour)) {} (share.name) }
                td.number { (format!("{:.3}", share.s)) }
                td.number { (format!("{:.1}", 100.0 * share.s / total_s)) }
            } } }
        } }
        (ramps(pace))
    }
}

fn of(pace: &Pace) -> Vec<Share> {
    let share = |name: &str, colour, s| Share { name: name.to_owned(), colour, s };
    let shares = &pace.shares;
    let feed = share("the feed asked for", "--z", shares.feed_s);
    let axes = (0..AXES).map(|axis| Share {
        name: format!("the top speed of {} ($11{axis})", AXIS_NAMES[axis]),
        colour: ["--speed-4", "--x", "--curve-6", "--a"][axis],
        s: shares.top_speed_s[axis],
    });
    let others = [
        share("acceleration, from and to corners", "--y", shares.corners_s),
        share("acceleration, from and to standstill", "--curve-5", shares.standstill_s),
        share("acceleration, by a curved law over short moves", "--rack", shares.speed_law_s),
        share("the board's time for short moves", "--speed-5", shares.short_moves_s),
        share("acceleration, from and to the end of the look-ahead", "--curve-7", shares.look_ahead_s),
        share("shapers, at stops", "--rack", shares.shaping_s),
        share("standing", "--bound", shares.standing_s),
        share("not known: limits change on the way", "--z", shares.unknown_s),
    ];
    [feed].into_iter().chain(axes).chain(others).collect()
}

/// A sentence on the axes that limit the acceleration.
fn ramps(pace: &Pace) -> Markup {
    let ramps_s: f64 = pace.axes.iter().map(|axis| axis.ramps_s).sum();
    let axes = pace.axes.iter().zip(AXIS_NAMES).filter(|(axis, _)| axis.ramps_s > 0.0);
    let axes: Vec<_> = axes.map(|(axis, name)| format!("{name} {:.3} s", axis.ramps_s)).collect();
    let fastest = pace.fastest_axis.map(|axis| {
        let own = &pace.axes[axis];
        let (found, top) = (own.highest_mm_s, own.top_mm_s);
        format!("{} comes nearest to its top speed: {found:.2} of {top:.2} mm/s.", AXIS_NAMES[axis])
    });
    html! {
        p {
            @if ramps_s > 0.0 { "Ramps take " (format!("{ramps_s:.3} s")) ", by the axis whose acceleration limits them: " (axes.join(", ")) ". " }
            @if let Some(fastest) = fastest { (fastest) }
        }
    }
}

fn seconds(pace: &Pace) -> Markup {
    let text = |second: &Second| {
        format!(
            "{:.1} s after the first start, {:.2} mm/s on the mean, {} moves begin, {}",
            second.start_s,
            second.mean_mm_s,
            second.moves_begun,
            lines(second.lines)
        )
    };
    html! {
        @if let Some(second) = &pace.slowest_second { p { b { "Slowest second: " } (text(second)) "." } }
        @if let Some(second) = &pace.busiest_second { p { b { "Busiest second: " } (text(second)) "." } }
    }
}

/// The tables of where time is lost; empty if limits changed.
pub fn slow_places(pace: &Pace) -> Markup {
    let kinds: Vec<_> = pace.slow.kinds.iter().filter(|kind| kind.lost_s >= LEAST_SHOWN_S).collect();
    let worst: Vec<_> = pace.slow.worst.iter().filter(|place| place.lost_s >= LEAST_SHOWN_S).collect();
    html! { @if !pace.limits_changed {
        h2 { "Time lost at slow places" }
        p {
            "Lost is what ramps take longer than the same way at the speed asked for. Less than 0.5 ms is left out."
            @if pace.slow.of(Why::LookAhead).count > 0 { " Where the look-ahead ends the moves that were known were too short to brake on from a higher speed, or came too late." }
            @if pace.slow.of(Why::ShortMoves).count > 0 { " A short move lasts " (format!("{:.2}", STRAIGHT_S * 1e3)) " ms, with a blend " (format!("{:.2}", BLEND_S * 1e3)) ", which the board takes for it: longer moves are faster." }
        }
        div.scroll { table {
            thead { tr { th { "why" } th { "places" } th { "ramps, s" } th { "lost, s" } } }
            tbody { @for kind in &kinds { tr {
                td { (kind.why.words()) }
                td.number { (kind.count) }
                td.number { (format!("{:.3}", kind.ramps_s)) }
                td.number { (format!("{:.3}", kind.lost_s)) }
            } } }
        } }
        @if !worst.is_empty() {
            @let of: usize = kinds.iter().filter(|kind| kind.why != Why::Ends).map(|kind| kind.count).sum();
            h3 { (if of > worst.len() { format!("The {} that cost most, of {of}", worst.len()) } else { "All of them".to_owned() }) }
            div.scroll { table {
                thead { tr {
                    th { "lost, s" } th { "why" } th { "lines" } th { "X, Y, Z mm" } th { "turns by" } th { "taken at, mm/s" } th { "asked, mm/s" } th { "at, s" } th { "stands, s" }
                } }
                tbody { @for place in &worst { (slow_place(place)) } }
            } }
        }
        (seconds(pace))
    } }
}

fn slow_place(place: &SlowPlace) -> Markup {
    html! { tr {
        td.number { (format!("{:.4}", place.lost_s)) }
        td { (place.why.words()) }
        td { (place_lines(place.lines)) }
        td { (place.place_mm.map(|mm| format!("{:.2}", mm + 0.0)).join(", ")) }
        td.number { (format!("{:.1}°", place.turn_deg)) }
        td.number { (format!("{:.2}", place.taken_mm_s)) }
        td.number { (format!("{:.2}", place.asked_mm_s)) }
        td.number { (format!("{:.3}", place.at_s)) }
        td.number { (if place.standing_s > 0.0 { format!("{:.3}", place.standing_s) } else { "-".to_owned() }) }
    } }
}

fn place_lines([before, after]: [Option<usize>; 2]) -> String {
    match (before, after) {
        (Some(before), Some(after)) if before != after => format!("{before} to {after}"),
        (Some(line), _) | (_, Some(line)) => line.to_string(),
        (None, None) => "-".to_owned(),
    }
}

fn lines([first, last]: [Option<usize>; 2]) -> String {
    match (first, last) {
        (Some(first), Some(last)) if first != last => format!("lines {first} to {last}"),
        (Some(line), _) | (_, Some(line)) => format!("line {line}"),
        (None, None) => "of lines that are not known".to_owned(),
    }
}

/// A duration for people.
fn duration(s: f64) -> String {
    match s {
        0.0..60.0 => format!("{s:.3} s"),
        60.0..3600.0 => format!("{:.0} min {:.1} s", (s / 60.0).floor(), s % 60.0),
        _ => format!("{:.0} h {:.0} min {:.0} s", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor(), s % 60.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    fn pace(program: &str) -> Pace {
        let mut config = Config::default();
        config.settings.soft_limits = false;
        Pace::of(&run(program.as_bytes(), &config).unwrap())
    }

    #[test]
    fn shares_of_the_time_are_all_of_it() {
        let pace = pace("G91 G0 X20\nG1 F600 X10\nY10\nG4 P0.5\nG2 X10 I5\n");
        let sum_s: f64 = of(&pace).iter().map(|share| share.s).sum();
        assert!((sum_s / pace.total_s() - 1.0).abs() < 1e-9);
        let html = shares(&pace).into_string();
        assert!(html.contains("the feed asked for") && html.contains("standing"), "{html}");
        assert!(!html.contains("the top speed of Z"), "{html}");
    }

    #[test]
    fn the_worst_places_say_where_and_why() {
        let html = slow_places(&pace("G91 G1 F600 X10\nY10\n")).into_string();
        assert!(html.contains("1 to 2") && html.contains("90.0°") && html.contains("10.00, 0.00, 0.00"), "{html}");
        assert!(html.contains("<td>corner</td>") && html.contains("All of them"), "{html}");
    }

    #[test]
    fn of_changed_limits_only_the_time_is_reported() {
        let pace = pace("G0 X20\nG4 P0\n$100=100\nG0 X0\n");
        let html = shares(&pace).into_string() + &slow_places(&pace).into_string();
        assert!(
            html.contains("The program changes its limits on the way, so what limits it is not reported."),
            "{html}"
        );
        assert!(!html.contains(" mm") && !html.contains("top speed") && !html.contains("lost"), "{html}");
    }

    #[test]
    fn losses_that_would_read_as_nothing_are_left_out() {
        let mut pace = pace("G91 G1 F600 X10\nY10\n");
        pace.slow.kinds[Why::Corner as usize].lost_s = 0.0004;
        pace.slow.worst[0].lost_s = 0.0004;
        let html = slow_places(&pace).into_string();
        assert!(!html.contains("<td>corner</td>") && !html.contains("All of them"), "{html}");
    }

    #[test]
    fn times_are_reported_as_people_read_them() {
        assert_eq!([12.3456, 61.25, 3_723.0].map(duration), ["12.346 s", "1 min 1.2 s", "1 h 2 min 3 s"]);
    }
}
