//! Writes the figures as a page of pictures and tables.

use isostep_report::pictures::bench::{self, Series};
use isostep_report::pictures::document::{Page, Picture, Section, Table};

use super::accuracy::MoveErrors;
use super::beside::beside;
use super::board::Moving;
use super::chip::Chip;
use super::figures::{Figures, PortFigures, together};
use super::micro::{GeneratorFigures, MicroFigures};
use super::outputs::OffFigures;
use super::starts::{Delay, StartMeasurement};
use super::stops::Latency;
use super::table;
use super::target::Target;
use super::{flow, laws, levels};
use isostep::screen::grouped;

const TITLE: &str = "Step ports on the emulated board";

/// The page.
pub fn page(figures: &Figures) -> Page {
    let ports = [
        targets(figures),
        rates(figures),
        accuracy(figures),
        load(figures),
        stops(figures),
        starts(figures),
        moves(figures),
        levels(figures),
    ];
    let (chip, ideal) = (figures.chip.mathematics.as_ref(), figures.ideal_flash.mathematics.as_ref());
    let mathematics = chip
        .into_iter()
        .flat_map(|one| [costs(one, ideal), laws(one, ideal), flow(one, ideal), generators(one, ideal)]);
    let conditions = format!("{} {}", table::conditions(&figures.conditions), table::BESIDE);
    Page {
        title: TITLE.to_owned(),
        lead: vec![conditions],
        command: figures.conditions.command.clone(),
        sections: ports.into_iter().chain(mathematics).collect(),
        ..Page::default()
    }
}

fn targets(figures: &Figures) -> Section {
    let row = |target: &Target| {
        let mark = if target.met { "met" } else { "not met" };
        [vec![mark.to_owned(), target.what.clone(), target.aim()], table::measured_cells(target, figures).to_vec()]
            .concat()
    };
    let chips = [Chip::AsItIs, Chip::IdealFlash, Chip::CostlyMiss].map(Chip::name);
    let head = [["", "figure", "target"], chips].concat();
    Section {
        heading: "Targets".to_owned(),
        text: vec!["What was aimed at, and what was measured: on the chip as it is, on one whose flash reads like RAM, and on \
               one on which what flash's cache does not hold takes twice as long to come.".to_owned()],
        tables: vec![Table::new(&head, figures.chip.targets.iter().map(row).collect())],
        ..Section::default()
    }
}

fn rates(figures: &Figures) -> Section {
    let axes: Vec<usize> =
        figures.chip.ports.first().map_or(Vec::new(), |port| port.machine.rates.iter().map(|one| one.axes).collect());
    let groups: Vec<String> = axes.into_iter().map(table::axes_words).collect();
    let series = each_port(figures, |port| {
        port.machine.rates.iter().map(|rates| rates.highest_steps_s.map(f64::from)).collect()
    });
    let row = |port: &PortFigures| {
        let rows = port.machine.rates.iter().map(|rates| {
            let rate = |rate: Option<u32>| rate.map_or("-".to_owned(), |rate| grouped(rate.into()));
            vec![
                port.port.name().to_owned(),
                rates.axes.to_string(),
                rate(rates.highest_steps_s),
                rates.errors.map_or("-".to_owned(), |errors| format!("{:.0}", errors.max_ns)),
                rate(rates.next_steps_s),
                rates.why_not.clone().unwrap_or_default(),
            ]
        });
        rows.collect::<Vec<_>>()
    };
    let head = ["port", "axes", "steps/s of each", "max. error, ns", "not", "because"];
    Section {
        heading: "Highest rate sustained".to_owned(),
        text: vec![
            "Axes that move at once, all at the same rate, there and back, from rest: no line refused, no alarm, no \
               edge nearer to another step's instant than to its own. Found by bisection."
                .to_owned(),
        ],
        pictures: vec![Picture::new(
            "rates",
            bench::bars("Highest rate sustained", "steps/s of each axis", &groups, &series),
            "The highest rate of each axis, over a logarithmic scale.",
        )],
        tables: vec![Table::new(&head, both(figures, row, 2))],
    }
}

fn accuracy(figures: &Figures) -> Section {
    let measured = || {
        let ports = figures.chip.ports.iter().enumerate();
        ports.filter_map(|(index, port)| Some((index, port, port.machine.accuracy.edges.figure()?)))
    };
    let pictures = measured().map(|(index, port, edges)| {
        let name = port.port.name();
        let bound_ns = port.port.error_bound_ns();
        Picture::new(
            format!("errors-{}", name.to_lowercase()),
            bench::histogram(&format!("Edge errors of {name}"), &edges.histogram, bound_ns, index),
            format!(
                "{name}: {} edges of one move of {:.1} s, {}. Dashed: {} ns.",
                grouped(edges.errors.edges),
                edges.move_s,
                together(port.machine.accuracy.rate_steps_s),
                grouped(bound_ns as u64),
            ),
        )
    });
    let row = |port: &PortFigures| {
        let Some(MoveErrors { errors, drift, .. }) = port.machine.accuracy.edges.figure() else { return Vec::new() };
        let ns = |ns: f64| format!("{ns:.0}");
        vec![vec![
            port.port.name().to_owned(),
            grouped(port.machine.accuracy.rate_steps_s.into()),
            grouped(errors.edges),
            ns(errors.median_ns),
            ns(errors.p99_ns),
            ns(errors.max_ns),
            format!("{:+.2}", drift.slope_ns_s),
            format!("{:+.1}", drift.last_less_first_ns),
        ]]
    };
    let head =
        ["port", "steps/s of each", "edges", "median, ns", "p99, ns", "max., ns", "drift, ns/s", "last less first, ns"];
    Section {
        heading: "Edges against the closed form".to_owned(),
        text: vec![
            "Every rising edge of STEP of three axes, through both ramps and the cruise, against the instant that the \
               plan's closed form gives. Instants count from the first edge. Drift is the slope of a line fitted \
               through the errors, and what the last edges are later, on average, than the first."
                .to_owned(),
        ],
        pictures: pictures.collect(),
        tables: vec![Table::new(&head, both(figures, row, 1))],
    }
}

fn load(figures: &Figures) -> Section {
    let series = each_port(figures, |port| {
        let points =
            port.machine.load.iter().map(|load| Some((load.rate_steps_s.into(), load.cruising.figure()?.load * 100.0)));
        points.flatten().collect()
    });
    let row = |port: &PortFigures| {
        let rows = port.machine.load.iter().map(|load| {
            let rate = grouped(load.rate_steps_s.into());
            vec![
                port.port.name().to_owned(),
                rate,
                load.cruising.words(Moving::words),
                load.ramping.words(Moving::words),
            ]
        });
        rows.collect::<Vec<_>>()
    };
    Section {
        heading: "Load of the core".to_owned(),
        text: vec![
            "The share of the time that the core is awake while three axes move: planning, compiling, stepping, USB \
               and status reports. Ramps are from rest to the rate and back without a cruise."
                .to_owned(),
        ],
        pictures: vec![Picture::new(
            "load",
            bench::curves("Load of the core", "steps/s of each of 3 axes", "awake, %", &series),
            "Cruising at the rate.",
        )],
        tables: vec![Table::new(&["port", "steps/s of each", "cruising", "in ramps"], both(figures, row, 2))],
    }
}

fn stops(figures: &Figures) -> Section {
    let row = |port: &PortFigures| {
        let rows = port.machine.stops.iter().map(|stop| {
            let rate = grouped(stop.rate_steps_s.into());
            let words = stop.latency.words(Latency::words);
            vec![port.port.name().to_owned(), stop.input.name().to_owned(), rate, words]
        });
        rows.collect::<Vec<_>>()
    };
    Section {
        heading: "Stops".to_owned(),
        text: vec!["From the edge of an input, or a second reset byte's arrival while the first has the machine brake, to the \
               last rising edge of any axis, at random instants of moves of three axes; and whether the position reported after all of them is that of the edges \
               counted.".to_owned()],
        tables: vec![Table::new(&["port", "by", "steps/s of each", "to the last edge"], both(figures, row, 2))],
        ..Section::default()
    }
}

fn starts(figures: &Figures) -> Section {
    let row = |port: &PortFigures| {
        let name = port.port.name().to_owned();
        let words = |start: &StartMeasurement| start.delay.words(Delay::words);
        port.starts.iter().map(|start| vec![name.clone(), start.cache.name().to_owned(), words(start)]).collect()
    };
    Section {
        heading: "Starts".to_owned(),
        text: vec!["From the arrival of a line's last byte in the chip's USB buffer to the first rising edge of any axis, less \
               what the plan itself takes to its first step: moves of three axes after random rests, with flash's cache \
               empty as the line arrives (cold), and right after a move of the same kind (warm).".to_owned()],
        tables: vec![Table::new(&["port", "cache", "what the machine adds"], both(figures, row, 2))],
        ..Section::default()
    }
}

fn costs(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> Section {
    let of = |figures: &MicroFigures| {
        table::costs(figures).into_iter().map(|(name, words)| vec![name, words]).collect::<Vec<_>>()
    };
    Section {
        heading: "Mathematics of a move".to_owned(),
        text: vec![
            "What planning, compiling and replaying cost on the chip, timed by its own SysTick. Every result was \
               computed on the host too, and is the same to the bit."
                .to_owned(),
        ],
        tables: vec![Table::new(&["work", "cost"], beside(of(figures), ideal.map_or(Vec::new(), of), 1))],
        ..Section::default()
    }
}

fn laws(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> Section {
    let row = |one: &laws::LawFigures| [vec![one.law.to_owned()], one.cells().to_vec()].concat();
    let of = |figures: &MicroFigures| figures.laws.iter().map(row).collect::<Vec<_>>();
    let head = [&["law"], laws::HEAD.as_slice()].concat();
    Section {
        heading: "Speed laws".to_owned(),
        text: vec!["What each law costs on the chip. A plan is of three axes, with and without a cruise; a beginning is the first \
               segment of each axis, which computes what a ramp needs. Segments are those of ramps; replaying a step costs the same under every law.".to_owned()],
        tables: vec![Table::new(&head, beside(of(figures), ideal.map_or(Vec::new(), of), 1))],
        ..Section::default()
    }
}

fn moves(figures: &Figures) -> Section {
    let row = |port: &PortFigures| {
        let moves = &port.machine.moves;
        let count = grouped(moves.moves as u64);
        let row = |[name, carried]: [String; 2]| vec![port.port.name().to_owned(), name, count.clone(), carried];
        moves.rows().map(row).into()
    };
    Section {
        heading: "Short moves carried".to_owned(),
        text: vec![
            "A curve of short moves, sent over USB as far ahead as the window of characters allows, at a feed \
               that the core can hardly keep: how many a second are made in the middle half of the stream."
                .to_owned(),
        ],
        tables: vec![Table::new(&["port", "moves", "how many", "carried"], both(figures, row, 2))],
        ..Section::default()
    }
}

fn levels(figures: &Figures) -> Section {
    let row = |port: &PortFigures| {
        let levels = &port.levels;
        let rates = [&levels.carried_constant, &levels.carried_by_speed].map(|rate| rate.words(levels::rate_words));
        let off = port.outputs.words(OffFigures::words);
        vec![
            [vec![port.port.name().to_owned(), levels.distances.words(levels::words)], rates.to_vec(), vec![off]]
                .concat(),
        ]
    };
    Section {
        heading: "Levels of a laser".to_owned(),
        text: vec!["Lines of pixels of 0.1 mm: how far the change of a level is from the middle between the two steps that it belongs \
               between, at 1,000 moves a second; and how many pixels a second are carried, with constant levels (M3) and \
               with levels by speed (M4).".to_owned()],
        tables: vec![Table::new(&["port", "from their steps", "carried, M3", "carried, M4", "from a stop to dark"], both(figures, row, 1))],
        ..Section::default()
    }
}

fn flow(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> Section {
    let row = |one: &flow::FlowFigures| [vec![one.case.to_owned()], one.cells().to_vec()].concat();
    let of = |figures: &MicroFigures| figures.flow.iter().map(row).collect::<Vec<_>>();
    let head = [&["case"], flow::HEAD.as_slice()].concat();
    Section {
        heading: "Short moves that flow".to_owned(),
        text: vec![
            "Cycles of a move of 0.2 mm of three axes in a full chain: to read its line, to push it, to plan it, and \
               to compile the segments of all axes; and how many moves a second that is, if the core did nothing else."
                .to_owned(),
        ],
        tables: vec![Table::new(&head, beside(of(figures), ideal.map_or(Vec::new(), of), 1))],
        ..Section::default()
    }
}

fn generators(figures: &MicroFigures, ideal: Option<&MicroFigures>) -> Section {
    let names: Vec<String> = figures.generators.iter().map(|one| one.name.replace('.', "\n")).collect();
    let of = |name: &str, value: fn(&GeneratorFigures) -> f64| Series {
        name: name.to_owned(),
        values: figures.generators.iter().map(|one| Some(value(one))).collect(),
    };
    let errors = [
        of("whole ramp", |one| one.truth.speed_error_max_percent),
        of("above a tenth of the top speed", |one| one.truth.speed_error_max_above_tenth_percent),
    ];
    let cycles = [of("cycles a step", |one| one.cycles_mean)];
    let row = |one: &GeneratorFigures| [vec![one.name.to_owned()], table::generator_cells(one).to_vec()].concat();
    let all = |figures: &MicroFigures| figures.generators.iter().map(row).collect::<Vec<_>>();
    let head = [&["generator"], table::GENERATOR_HEAD.as_slice()].concat();
    Section {
        heading: "Step generators".to_owned(),
        text: vec![format!(
            "Isostep's segments beside the generators of the literature, over the same ramp: {}. Speeds are held \
             against the closed form of the limits each was planned from.",
            table::ramp_words(&figures.ramp)
        )],
        pictures: vec![
            Picture::new(
                "speed-errors",
                bench::bars("Worst speed error", "worst speed error, %", &names, &errors),
                "The worst error of one interval's speed.",
            ),
            Picture::new(
                "cycles",
                bench::bars("Cycles a step", "cycles a step", &names, &cycles),
                "What a step costs on average; isostep's with its share of compiling.",
            ),
        ],
        tables: vec![Table::new(&head, beside(all(figures), ideal.map_or(Vec::new(), all), 1))],
    }
}

fn each_port<T>(figures: &Figures, values: impl Fn(&PortFigures) -> Vec<T>) -> Vec<Series<T>> {
    figures.chip.ports.iter().map(|port| Series { name: port.port.name().to_owned(), values: values(port) }).collect()
}

/// The rows of each port, each followed by the ideal chip's row if that differs. The first `key` cells identify a row.
fn both(figures: &Figures, of: impl Fn(&PortFigures) -> Vec<Vec<String>>, key: usize) -> Vec<Vec<String>> {
    let [chip, ideal] = [&figures.chip, &figures.ideal_flash].map(|chip| chip.ports.iter().flat_map(&of).collect());
    beside(chip, ideal, key)
}
