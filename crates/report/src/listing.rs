//! A `$$` of Grbl, grblHAL or FluidNC, line by line: what is taken, what means something else here, and what is not known.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use isostep_console::{SETTING_TABLE, Settings};
use isostep_motion::AXES;
use isostep_sim::settings::{self, Reason, Refused};
use isostep_sim::{Board, Config};

use crate::check::Row;
use crate::remarks::AXIS_NAMES;

/// A mask of all axes.
const ALL_AXES: u32 = (1 << AXES) - 1;
/// The numbers of Grbl 1.1. Others are grblHAL's, or ours.
const OF_GRBL: [RangeInclusive<u16>; 8] =
    [0..=6, 10..=13, 20..=27, 30..=32, 100..=102, 110..=112, 120..=122, 130..=132];
/// Numbers that only a listing of ours has.
const OURS: RangeInclusive<u16> = 900..=999;
/// grblHAL's passes of homing, each a mask of axes.
const PASSES: RangeInclusive<u16> = 44..=46;
/// The order of homing.
const ORDER: u16 = 901;

/// The subjects of numbers of grblHAL that are not here, and what to do.
const ELSEWHERE: &[(RangeInclusive<u16>, &str)] = &[
    (7..=9, "the PWM output is on whenever the spindle is, and S0 has no duty"),
    (
        14..=19,
        "inputs are low when they are pressed, with a pull-up, and outputs are active high: only an emergency stop may open (--estop nc)",
    ),
    (29..=29, "the time from DIR to STEP is that of the driver (--driver)"),
    (34..=34, "S0 has no duty"),
    (37..=37, "$1=255 keeps all motors on, and nothing else keeps some of them on"),
    (39..=39, "all real-time bytes act"),
    (40..=40, "a jog of a homed axis always keeps to the travel"),
    (41..=43, "the door parks nothing, and homing measures each switch once"),
    (47..=49, "there are no more axes"),
    (56..=61, "the door parks nothing, and a reset restores the overrides"),
    (62..=65, "nothing sleeps by itself, and a hold leaves the laser off"),
    (103..=108, AXIS_A),
    (113..=118, AXIS_A),
    (123..=128, AXIS_A),
    (133..=138, AXIS_A),
    (140..=168, DRIVERS),
    (180..=198, "$24 and $25 hold for all axes"),
    (200..=238, DRIVERS),
    (70..=79, NETWORK),
    (300..=337, NETWORK),
    (338..=339, DRIVERS),
    (345..=345, "$TPW goes up again by $344"),
    (346..=346, "behind M6 the machine goes back to where it was"),
    (370..=373, NETWORK),
    (376..=376, AXIS_A),
    (384..=384, "G92 is forgotten by a reset"),
    (392..=393, "the spindle's time to come up to speed is $394"),
    (396..=398, "the look-ahead has 64 moves, and one spindle"),
    (460..=460, "the address of the VFD is $476"),
    (472..=473, NOTHING),
    (477..=479, "there is one spindle"),
];
const AXIS_A: &str = "firmware with A has it, on four axes: --axes 4; there are no more";
const DRIVERS: &str = "UART drivers are those of an SKR Pico: docs/bring-up.md";
const NETWORK: &str = "there is no network, and no bus to a spindle";
const NOTHING: &str = "nothing here depends on it";

/// A line that is not simply taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Its number, from 1; 0 for what is of several lines.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// The meaning here, and what to do.
    pub words: String,
}

/// The result of a listing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Listing {
    /// The settings that are in force with it, by number, in its order.
    pub taken: Vec<(u16, f32)>,
    /// The number of lines that are taken as they are.
    pub as_they_are: usize,
    /// Those that mean something else here.
    pub otherwise: Vec<Remark>,
    /// Those that are not known here.
    pub unknown: Vec<Remark>,
    /// Those that cannot be.
    pub refused: Vec<Remark>,
    /// The settings with what was taken.
    pub settings: Option<Settings>,
}

impl Listing {
    /// Reads the listing `text`, for a machine of `config`. `name` is that of its file.
    pub fn read(name: &str, text: &[u8], config: &Config) -> Self {
        let mut listing = Self::default();
        let lines = settings::lines(text);
        let numbers = || lines.iter().filter_map(|line| assignment(line)?.0.parse::<u16>().ok());
        let is_hal = !numbers().any(|number| OURS.contains(&number))
            && numbers().any(|number| !OF_GRBL.iter().any(|range| range.contains(&number)));
        let mut passes = Vec::new();
        for (number, line) in (1..).zip(&lines) {
            listing.take(number, line, (config.board, is_hal), &mut passes);
        }
        listing.order(&passes);
        listing.check(name, config);
        listing
    }

    /// The settings as a file of `$n=v` lines.
    pub fn text(&self) -> String {
        self.taken.iter().fold(String::new(), |mut text, (number, value)| {
            let _ = writeln!(text, "${number}={value}");
            text
        })
    }

    /// True if nothing is refused, and what is taken works together.
    pub fn is_good(&self) -> bool {
        self.settings.is_some() && self.refused.is_empty()
    }

    fn take(&mut self, line: usize, text: &str, (board, is_hal): (Board, bool), passes: &mut Vec<(usize, u32)>) {
        let remark = |words: String| Remark { line, text: text.to_owned(), words };
        let Some((number, value)) = assignment(text) else { return };
        let (Ok(number), Ok(value)) = (number.parse::<u16>(), value.parse::<f32>()) else {
            return self
                .unknown
                .push(remark("a name, a text or a start-up line: send $N0= and $I= yourself".to_owned()));
        };
        if is_hal && PASSES.contains(&number) {
            passes.push((line, value as u32));
            return;
        }
        if !is_known(number, board) {
            let elsewhere = ELSEWHERE.iter().find(|(range, _)| range.contains(&number));
            return self.unknown.push(remark(elsewhere.map_or(NOTHING, |(_, words)| words).to_owned()));
        }
        let meaning = meaning(number, value, is_hal);
        let set = meaning.as_ref().and_then(|meaning| meaning.0).unwrap_or(value);
        match Settings::DEFAULT.with(number, set) {
            Err(why) => self.refused.push(remark(meaning.map_or(why.to_string(), |(_, words)| words))),
            Ok(_) => {
                self.taken.push((number, set));
                match meaning {
                    None => self.as_they_are += 1,
                    Some((None, words)) => self.otherwise.push(remark(words)),
                    Some((Some(_), words)) => self.otherwise.push(remark(format!("taken as ${number}={set}: {words}"))),
                }
            }
        }
    }

    /// The order of homing by grblHAL's passes. Axes of one pass home one after the other here.
    fn order(&mut self, passes: &[(usize, u32)]) {
        let axes = passes.iter().flat_map(|(_, mask)| (0..AXES).filter(move |axis| mask >> axis & 1 == 1));
        let digits: String = axes.map(|axis| (axis + 1).to_string()).collect();
        let Some((line, _)) = passes.first() else { return };
        let text = "$44, $45, $46".to_owned();
        let remark = |words: String| Remark { line: *line, text, words };
        match digits.parse::<f32>().ok().filter(|order| Settings::DEFAULT.with(ORDER, *order).is_ok()) {
            Some(order) => {
                self.taken.push((ORDER, order));
                self.otherwise.push(remark(format!("taken as $901={order}: the axes home one after the other")));
            }
            None => self.unknown.push(remark("the order of homing is $901, and has each axis once".to_owned())),
        }
    }

    /// Checks that what is taken works together.
    fn check(&mut self, name: &str, config: &Config) {
        match settings::read(name, self.text().as_bytes(), config.port, config.driver) {
            Ok(settings) => self.settings = Some(settings),
            Err(Refused { reason: Reason::Empty, .. }) => self.refused.push(Remark {
                line: 0,
                text: String::new(),
                words: "there is no $n=v line in it: save what $$ prints".to_owned(),
            }),
            Err(Refused { line, reason, .. }) => {
                let text = line.map_or(String::new(), |(_, text)| text);
                self.refused.push(Remark { line: 0, text, words: reason.to_string() });
            }
        }
    }

    /// All of it in words.
    pub fn rows(&self) -> Vec<Row> {
        let row = |name, remarks: &[Remark], more: &str| {
            let words = if remarks.is_empty() { "none".to_owned() } else { format!("{}{more}", remarks.len()) };
            Row { name, words, places: remarks.iter().map(words_of).collect() }
        };
        let mut rows = vec![
            Row { name: "taken", words: format!("{} as they are", self.as_they_are), places: Vec::new() },
            row("otherwise", &self.otherwise, ", which mean something else here"),
            row("unknown", &self.unknown, ", left out"),
            row("refused", &self.refused, ""),
        ];
        rows.extend(self.settings.iter().flat_map(travel));
        rows
    }
}

fn words_of(Remark { line, text, words }: &Remark) -> String {
    match (line, text.as_str()) {
        (0, "") => words.clone(),
        (0, text) => format!("`{text}`: {words}"),
        (line, text) => format!("line {line} `{text}`: {words}"),
    }
}

/// A text about where the travel of each axis lies, and how Grbl's places follow.
fn travel(settings: &Settings) -> Vec<Row> {
    if !settings.homing {
        return vec![Row {
            name: "travel",
            words: "no axis homes ($22=0), so it has no place".to_owned(),
            places: Vec::new(),
        }];
    }
    let machine = isostep_controller::config(settings);
    let axis = |axis: usize| {
        let (travel, pull_off) = (f64::from(settings.travel_mm[axis]), machine.homing.pull_off_mm);
        let is_low = settings.homing_direction_mask >> axis & 1 == 1;
        let (low, high) = if is_low { (0.0, travel) } else { (-travel, 0.0) };
        let add = if is_low { travel - pull_off } else { pull_off };
        format!("{} {low:.3} to {high:.3} mm; to a place of Grbl's add {add:.3}", AXIS_NAMES[axis])
    };
    let words = "0 is where an axis stands after $H, $27 from its switch. Add to the places of G28, G30, G53 and of work offsets:".to_owned();
    vec![Row { name: "travel", words, places: (0..AXES).map(axis).collect() }]
}

/// `$n=v` of a line, without its remark.
fn assignment(line: &str) -> Option<(&str, &str)> {
    let (name, value) = line.strip_prefix('$')?.split_once('=')?;
    Some((name.trim(), value.split(['(', ';']).next().unwrap_or(value).trim()))
}

/// True if a board has this setting.
fn is_known(number: u16, board: Board) -> bool {
    let row = SETTING_TABLE.iter().find(|row| row.numbers().contains(&number));
    row.is_some_and(|row| !row.is_trinamic() || board == Board::SkrPico)
}

/// The meaning of a value here, if that is not what it means there: the value to set, and why.
fn meaning(number: u16, value: f32, is_hal: bool) -> Option<(Option<f32>, String)> {
    let mask = value as u32;
    let as_flag = |words: &str| (value > 1.0).then(|| (Some(f32::from(u8::from(mask & 1 == 1))), words.to_owned()));
    let any = |words: &str| (value > 1.0).then(|| (Some(1.0), words.to_owned()));
    match number {
        2 if mask != 0 => Some((None, "STEP is active high: leave $2 out, and set the driver to that".to_owned())),
        3 | 8 | 23 if mask > ALL_AXES => {
            Some((Some((mask & ALL_AXES) as f32), format!("there are no more axes than {}", AXIS_NAMES.concat())))
        }
        4 if is_hal => {
            let (set, level) = if mask == 0 { (1.0, "high") } else { (0.0, "low") };
            Some((Some(set), format!("grblHAL's {value} is an ENABLE that is active {level}")))
        }
        5 => any("one setting is for all switches: wire all of them to open when they are pressed"),
        6 => as_flag("bit 1 is no tool setter here"),
        10 if mask > 3 => Some((
            Some((mask & 3) as f32),
            "machine position (1) and buffers (2) are a choice, and all other fields are always reported".to_owned(),
        )),
        11 => Some((None, "it holds with G61; else corners are blends, by $904 and G64 P".to_owned())),
        21 => any("bit 1 asks for nothing here: a switch that is pressed keeps no axis from leaving it"),
        22 => as_flag("bit 0 is homing; $HX homes one axis, and the machine is not locked until it is homed"),
        26 => Some((
            None,
            "a switch counts once it has been steady for so long; 5 is enough for most, and sooner".to_owned(),
        )),
        30 if value == 0.0 => Some((Some(1_000.0), "S would have no full duty: set the S that has it".to_owned())),
        32 if mask == 1 => Some((None, "the beam is on only while the machine moves, with M3 too".to_owned())),
        130..=132 if value < 0.0 => Some((Some(-value), "the travel is a length".to_owned())),
        340 if is_hal && value == 0.0 => {
            Some((Some(5.0), "a VFD's spindle is always waited for: set how far from its speed it may be".to_owned()))
        }
        395 if is_hal && mask != 0 => Some((
            Some(0.0),
            "grblHAL counts the spindles that it was built with: choose the VFD by its number in docs/tool.md"
                .to_owned(),
        )),
        _ => None,
    }
}
