//! Tables of how the time of a program is spent, and where it is lost.

use isostep_motion::{AXES, LeastTimes};

use super::chart::{Axis, Chart, Curve, Scale, picture};
use super::document::{Picture, Section, Table};
use super::theme::{AXIS, AXIS_NAMES, BOUND, CURVE, Colour, RACK, SPEED};
use crate::pace::{LEAST_SHOWN_S, Pace, Second, SlowPlace, Why};

/// A fraction of the time: its name, its colour and its duration, s.
struct Share {
    name: String,
    colour: Colour,
    s: f64,
}

/// The section about how the time is spent.
pub fn shares(pace: &Pace) -> Section {
    let total_s = pace.total_s().max(1e-9);
    let shares: Vec<_> = of(pace).into_iter().filter(|share| share.s > 0.0).collect();
    let row = |share: &Share| {
        vec![share.name.clone(), format!("{:.3}", share.s), format!("{:.1}", 100.0 * share.s / total_s)]
    };
    let key: Vec<_> = shares.iter().map(|share| (share.colour, share.name.clone())).collect();
    Section {
        heading: "Where time goes".to_owned(),
        text: [vec![how_spent(pace)], ramps(pace)].concat(),
        pictures: vec![Picture::new("time", picture("Shares of the time", &key, 1, 100, &[bar(&shares)]), "")],
        tables: vec![Table::new(&["limited by", "s", "%"], shares.iter().map(row).collect())],
    }
}

/// All shares in a row.
fn bar(shares: &[Share]) -> Chart {
    let total_s: f64 = shares.iter().map(|share| share.s).sum();
    let mut end_s = 0.0;
    let curves = shares.iter().map(|share| {
        let begin_s = end_s;
        end_s += share.s;
        Curve::bars(share.colour, [[(begin_s, 0.0), (end_s, 1.0)]])
    });
    let curves = curves.collect();
    Chart::new(Axis::from("s").within(0.0, total_s.max(1e-9)), Axis::scaled("", Scale::Levels).within(0.0, 1.0), curves)
}

fn how_spent(pace: &Pace) -> String {
    let [total, moving, standing] = [pace.total_s(), pace.moving_s, pace.standing_s].map(duration);
    let (length, mean, limits) = if pace.limits_changed {
        let limits = " The program changes its limits on the way, so what limits it is not reported.";
        (String::new(), String::new(), limits)
    } else if pace.moving_s > 0.0 {
        let mean_mm_s = pace.distance_mm / pace.moving_s;
        (format!("{:.1} mm in ", pace.distance_mm), format!("; {mean_mm_s:.2} mm/s on the mean while it moves"), "")
    } else {
        (format!("{:.1} mm in ", pace.distance_mm), String::new(), "")
    };
    format!(
        "{length}{total}: {moving} in motion, {standing} standing{mean}. A ramp counts to the slow place that it leads to or comes \
         from. Homing is left out.{limits}"
    )
}

fn of(pace: &Pace) -> Vec<Share> {
    let share = |name: &str, colour, s| Share { name: name.to_owned(), colour, s };
    let shares = &pace.shares;
    let feed = share("the feed asked for", AXIS[2], shares.feed_s);
    let axes = (0..AXES).map(|axis| Share {
        name: format!("the top speed of {} ($11{axis})", AXIS_NAMES[axis]),
        colour: [SPEED[0], AXIS[0], CURVE[5], AXIS[3]][axis],
        s: shares.top_speed_s[axis],
    });
    let others = [
        share("acceleration, from and to corners", AXIS[1], shares.corners_s),
        share("acceleration, from and to standstill", CURVE[4], shares.standstill_s),
        share("acceleration, by a curved speed profile over short moves", RACK, shares.speed_profile_s),
        share("the board's time for short moves", SPEED[1], shares.short_moves_s),
        share("acceleration, from and to the end of the look-ahead", CURVE[6], shares.look_ahead_s),
        share("shapers, at stops", RACK, shares.shaping_s),
        share("standing", BOUND, shares.standing_s),
        share("not known: limits change on the way", AXIS[2], shares.unknown_s),
    ];
    [feed].into_iter().chain(axes).chain(others).collect()
}

/// A sentence on the axes that limit the acceleration, and one on the fastest.
fn ramps(pace: &Pace) -> Vec<String> {
    let ramps_s: f64 = pace.axes.iter().map(|axis| axis.ramps_s).sum();
    let axes = pace.axes.iter().zip(AXIS_NAMES).filter(|(axis, _)| axis.ramps_s > 0.0);
    let axes: Vec<_> = axes.map(|(axis, name)| format!("{name} {:.3} s", axis.ramps_s)).collect();
    let ramps = (ramps_s > 0.0).then(|| {
        format!("Ramps take {ramps_s:.3} s, by the axis whose acceleration limits them: {}.", axes.join(", "))
    });
    let fastest = pace.fastest_axis.map(|axis| {
        let own = &pace.axes[axis];
        let (found, top) = (own.highest_mm_s, own.top_mm_s);
        format!("{} comes nearest to its top speed: {found:.2} of {top:.2} mm/s.", AXIS_NAMES[axis])
    });
    ramps.into_iter().chain(fastest).collect()
}

fn seconds(pace: &Pace) -> impl Iterator<Item = String> {
    let text = |name: &str, second: &Second| {
        format!(
            "{name} second: {:.1} s after the first start, {:.2} mm/s on the mean, {} moves begin, {}.",
            second.start_s,
            second.mean_mm_s,
            second.moves_begun,
            lines(second.lines)
        )
    };
    let both = [("Slowest", &pace.slowest_second), ("Busiest", &pace.busiest_second)];
    both.into_iter().filter_map(move |(name, second)| Some(text(name, second.as_ref()?)))
}

/// The section about lost time; `None` if limits changed.
pub fn slow_places(pace: &Pace) -> Option<Section> {
    if pace.limits_changed {
        return None;
    }
    let kinds: Vec<_> = pace.slow.kinds.iter().filter(|kind| kind.lost_s >= LEAST_SHOWN_S).collect();
    let worst: Vec<_> = pace.slow.worst.iter().filter(|place| place.lost_s >= LEAST_SHOWN_S).collect();
    let of: usize = kinds.iter().filter(|kind| kind.why != Why::Ends).map(|kind| kind.count).sum();
    let rows = kinds.iter().map(|kind| {
        let times = [kind.ramps_s, kind.lost_s].map(|s| format!("{s:.3}"));
        [vec![kind.why.words().to_owned(), kind.count.to_string()], times.to_vec()].concat()
    });
    let kinds = Table::new(&["why", "places", "ramps, s", "lost, s"], rows.collect());
    let head =
        ["lost, s", "why", "lines", "X, Y, Z mm", "turns by", "taken at, mm/s", "asked, mm/s", "at, s", "stands, s"];
    let caption = if of > worst.len() {
        format!("The {} that cost most, of {of}", worst.len())
    } else {
        "All of them".to_owned()
    };
    let worst =
        (!worst.is_empty()).then(|| Table::new(&head, worst.into_iter().map(slow_place).collect()).captioned(caption));
    Some(Section {
        heading: "Time lost at slow places".to_owned(),
        text: [what_is_lost(pace)].into_iter().chain(seconds(pace)).collect(),
        tables: [kinds].into_iter().chain(worst).collect(),
        ..Section::default()
    })
}

fn what_is_lost(pace: &Pace) -> String {
    let mut text =
        "Lost is what ramps take longer than the same way at the speed asked for. Less than 0.5 ms is left out."
            .to_owned();
    if pace.slow.of(Why::LookAhead).count > 0 {
        text += " Where the look-ahead ends the moves that were known were too short to brake on from a higher speed, or came too late.";
    }
    if pace.slow.of(Why::ShortMoves).count > 0 {
        let LeastTimes { straight_s, blend_s, together_s, join_s, .. } = pace.least_times;
        text += &format!(
            " A short move lasts {:.2} ms, with a blend {:.2}, which the board takes for it; several that are taken together last {:.2} ms \
             longer, and {:.2} ms for each of them: longer moves are faster.",
            straight_s * 1e3,
            blend_s * 1e3,
            together_s * 1e3,
            join_s * 1e3
        );
    }
    text
}

fn slow_place(place: &SlowPlace) -> Vec<String> {
    vec![
        format!("{:.4}", place.lost_s),
        place.why.words().to_owned(),
        place_lines(place.lines),
        place.place_mm.map(|mm| format!("{:.2}", mm + 0.0)).join(", "),
        format!("{:.1}°", place.turn_deg),
        format!("{:.2}", place.taken_mm_s),
        format!("{:.2}", place.asked_mm_s),
        format!("{:.3}", place.at_s),
        if place.standing_s > 0.0 { format!("{:.3}", place.standing_s) } else { "-".to_owned() },
    ]
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
        let section = shares(&pace);
        let names: Vec<_> = section.tables[0].rows.iter().map(|row| row[0].as_str()).collect();
        assert!(names.contains(&"the feed asked for") && names.contains(&"standing"), "{names:?}");
        assert!(!names.contains(&"the top speed of Z ($112)"), "{names:?}");
        assert!(names.iter().all(|name| section.pictures[0].svg.contains(name)));
        let bar = bar(&of(&pace));
        let spans_s: Vec<_> = bar.curves.iter().map(|bars| bars.points[1].0 - bars.points[0].0).collect();
        assert!(spans_s.iter().zip(of(&pace)).all(|(s, share)| (s - share.s).abs() < 1e-9), "{spans_s:?}");
    }

    #[test]
    fn the_worst_places_say_where_and_why() {
        let section = slow_places(&pace("G91 G1 F600 X10\nY10\n")).unwrap();
        let [kinds, worst] = &section.tables[..] else { panic!("{section:?}") };
        assert!(kinds.rows.iter().any(|row| row[0] == "corner"), "{kinds:?}");
        assert_eq!((worst.caption.as_str(), worst.rows.len()), ("All of them", 1));
        assert_eq!(worst.rows[0][1..5], ["corner", "1 to 2", "10.00, 0.00, 0.00", "90.0°"]);
    }

    #[test]
    fn how_long_a_short_move_lasts_is_that_of_the_board() {
        let mut config = Config::default();
        (config.settings.soft_limits, config.settings.accel_mm_s2) = (false, [2_000.0; AXES]);
        let times = &mut config.least_times;
        (times.straight_s, times.blend_s, times.together_s, times.join_s) = (1e-3, 2e-3, 3e-3, 0.25e-3);
        let program = format!("G91 G61 G1 F3000\nX8\n{}X8\n", "X0.02\n".repeat(200));
        let text = slow_places(&Pace::of(&run(program.as_bytes(), &config).unwrap())).unwrap().text.join(" ");
        let words = "A short move lasts 1.00 ms, with a blend 2.00, which the board takes for it; several that are taken together last \
                     3.00 ms longer, and 0.25 ms for each of them: longer moves are faster.";
        assert!(text.contains(words), "{text}");
    }

    #[test]
    fn of_changed_limits_only_the_time_is_reported() {
        let pace = pace("G0 X20\nG4 P0\n$100=100\nG0 X0\n");
        let (section, slow) = (shares(&pace), slow_places(&pace));
        let text = section.text.join(" ");
        assert!(
            text.contains("The program changes its limits on the way, so what limits it is not reported."),
            "{text}"
        );
        assert!(!text.contains(" mm") && !text.contains("top speed") && slow.is_none(), "{text} {slow:?}");
    }

    #[test]
    fn losses_that_would_read_as_nothing_are_left_out() {
        let mut pace = pace("G91 G1 F600 X10\nY10\n");
        pace.slow.kinds[Why::Corner as usize].lost_s = 0.0004;
        pace.slow.worst[0].lost_s = 0.0004;
        let section = slow_places(&pace).unwrap();
        assert!(
            section.tables.len() == 1 && section.tables[0].rows.iter().all(|row| row[0] != "corner"),
            "{section:?}"
        );
    }

    #[test]
    fn times_are_reported_as_people_read_them() {
        assert_eq!([12.3456, 61.25, 3_723.0].map(duration), ["12.346 s", "1 min 1.2 s", "1 h 2 min 3 s"]);
    }
}
