//! Random programs. A program is made line by line, as what may be sent depends on where the machine stands.

use oorandom::Rand64;

use super::cycles::is_cycle;
use super::line::{Asked, Line};
use super::machine::{Model, Place, Startup, State};
use super::tools::NUMBER_MAX;
use super::words::{INCH_ANGSTROM, ONE, Word, written};

/// The places between which each axis may move, angstroms.
pub type Room = [(i64, i64); 3];

/// An item of a random program.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// Lines in one packet, and real-time bytes while they are carried out, each with the milliseconds before it.
    Lines(Vec<Line>, Vec<(u64, u8)>),
    /// A real-time byte at rest.
    Byte(u8),
    /// The power is switched off and on.
    PowerCycle,
}

/// Makes programs.
pub struct Author {
    random: Rand64,
    /// True if `$RST=$` would give the machine the steps per millimetre that it has.
    is_default: bool,
}

impl Author {
    /// One for each seed.
    #[must_use]
    pub fn new(random: Rand64, is_default: bool) -> Self {
        Self { random, is_default }
    }

    /// A number below `count`.
    fn below(&mut self, count: u64) -> u64 {
        self.random.rand_range(0..count)
    }

    fn one_in(&mut self, count: u64) -> bool {
        self.below(count) == 0
    }

    fn of<T: Copy>(&mut self, those: &[T]) -> T {
        those[self.below(those.len() as u64) as usize]
    }

    /// The next item for a machine in this state.
    pub fn next(&mut self, model: &Model, room: &Room) -> Item {
        match self.below(40) {
            0 => return Item::PowerCycle,
            1 => return Item::Byte(0x18),
            2..=4 => return Item::Byte(self.of(&OVERRIDES)),
            5 => return Item::Byte(self.of(&[0xA0, 0xA1, b'~', 0x85, 0xB5])),
            6 | 7 => return Item::Lines(vec![self.jog(model, room)], self.bytes_in_jog()),
            8..=11 => return Item::Lines(vec![self.system(model)], Vec::new()),
            12 if self.one_in(8) => return Item::Lines(self.tool_entries(model), Vec::new()),
            _ => {}
        }
        let (mut lines, mut after) = (Vec::new(), model.clone());
        let count = self.of(&[1, 1, 1, 2, 3, 5]);
        while lines.len() < count {
            let line = self.line(&after, room);
            after.on_steps = false;
            after.line(&line);
            lines.push(line);
            if after.on_steps || after.waits > 0 {
                break;
            }
        }
        let is_plain = lines.iter().all(is_move);
        let is_run_through = !after.on_steps && after.waits == 0;
        // Where a line puts the overrides back, it depends on the instant of a byte what they are.
        let bytes = if is_run_through && !lines.iter().any(ends) { self.bytes_in_motion(is_plain) } else { Vec::new() };
        Item::Lines(lines, bytes)
    }

    fn bytes_in_motion(&mut self, may_reset: bool) -> Vec<(u64, u8)> {
        let ms = self.below(400);
        match self.below(8) {
            0 => vec![(ms, self.of(&OVERRIDES))],
            1 => vec![(ms, b'!'), (150, b'?'), (600, b'~')],
            2 => vec![(ms, 0x84), (2_000, b'~')],
            3 if may_reset => vec![(ms, 0x18)],
            4 => vec![(ms, 0x85), (1, b'?')],
            _ => Vec::new(),
        }
    }

    fn bytes_in_jog(&mut self) -> Vec<(u64, u8)> {
        let ms = self.below(400);
        match self.below(4) {
            0 => vec![(ms, self.of(&[0x85, b'!']))],
            1 => vec![(ms, 0x18)],
            _ => Vec::new(),
        }
    }

    /// A line of G-code that leaves the machine in its room, or that soft limits refuse.
    fn line(&mut self, model: &Model, room: &Room) -> Line {
        if self.one_in(30) {
            return self.odd_line();
        }
        for _ in 0..30 {
            let words = self.block(model, room);
            if stays(model, &words, room) {
                return Line { text: written(&words, &mut self.random), asked: Asked::Block(words) };
            }
        }
        Line { text: "G4 P0".to_owned(), asked: Asked::Block(vec![Word::g(40), Word::whole('P', 0)]) }
    }

    fn odd_line(&mut self) -> Line {
        let nothing = Asked::Block(Vec::new());
        let (text, asked) = match self.below(7) {
            5 => ("O1234 (a name)".to_owned(), nothing),
            6 => ("%wait".to_owned(), nothing),
            0 => (String::new(), nothing),
            1 => (" % ".to_owned(), nothing),
            2 => ("(nothing)".to_owned(), nothing),
            3 => ("; nothing".to_owned(), nothing),
            _ => (format!("G1 X1{}", "0".repeat(80)), Asked::Refused(11)),
        };
        Line { text, asked }
    }

    fn block(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        let mut words = match self.below(30) {
            25..=28 => self.cycle(model, room),
            0..=9 => self.straight(model, room),
            10 | 11 => self.arc(model),
            12..=14 => self.offset(model),
            15 if self.one_in(2) => self.tool_length(model),
            15 => vec![self.work_system()],
            16 => vec![Word::g(self.of(&MODES))],
            17 => vec![Word::g(self.of(&[281, 301]))],
            18 => self.go_home(model, room),
            19 => self.tool(),
            20 => vec![Word::g(40), Word { letter: 'P', value: self.below(4) as i64 * ONE / 10 }],
            21 => vec![Word::m(self.of(&[0, 1, 2, 6, 30]))],
            22 => self.probe(model, room),
            _ => self.faulty(model),
        };
        if self.one_in(8) {
            words.insert(0, Word::whole('N', self.below(1000) as i64));
        }
        if self.one_in(6) && !words.iter().any(|word| word.letter == 'M') {
            words.extend(self.tool());
        }
        words
    }

    /// The words of modes, some of them changed, and the modes with them.
    fn with_modes(&mut self, model: &Model) -> (Vec<Word>, bool, bool) {
        let (mut words, mut incremental, mut inches) = (Vec::new(), model.modes.incremental, model.modes.inches);
        if self.one_in(5) {
            incremental = self.one_in(2);
            words.push(Word::g(900 + 10 * i64::from(incremental)));
        }
        if self.one_in(12) {
            inches = self.one_in(2);
            words.push(Word::g(210 - 10 * i64::from(inches)));
        }
        (words, incremental, inches)
    }

    fn straight(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        let (mut words, incremental, inches) = self.with_modes(model);
        let mut motion = model.modes.motion;
        if !matches!(motion, 0 | 10) && !self.one_in(20) || self.one_in(3) {
            motion = self.of(&[0, 10, 10]);
            words.push(Word::g(motion));
        }
        let machine = self.one_in(6);
        if machine {
            words.push(Word::g(530));
        }
        let mut offsets = Vec::new();
        if self.one_in(12) {
            offsets.push(self.work_system());
        }
        if self.one_in(8) {
            offsets.extend(self.tool_length(model));
        }
        // They count before the motion.
        let mut after = model.clone();
        let _ = after.block(&offsets);
        words.extend(offsets);
        if motion != 0 && (model.modes.inverse_time || model.modes.feed < ONE || self.one_in(6)) && !self.one_in(20) {
            words.push(self.feed(model, inches));
        }
        let zero = if machine { [0; 3] } else { after.work_zero() };
        words.extend(self.axis_words(model, room, zero, incremental && !machine, inches));
        words
    }

    /// The word of a work system.
    fn work_system(&mut self) -> Word {
        let number = self.below(9) as i64;
        Word::g(if number < 6 { 540 + 10 * number } else { 585 + number })
    }

    /// A number of a tool; some numbers are more frequent.
    fn tool_number(&mut self, model: &Model) -> i64 {
        let known: Vec<i64> = model.tools.keys().copied().collect();
        match self.below(4) {
            0 | 1 if !known.is_empty() => self.of(&known),
            2 => 1 + self.below(40) as i64,
            _ => self.of(&[1, 2, 7, 606, NUMBER_MAX]),
        }
    }

    /// The words of a tool's length: of the tool in the spindle, which may just have been put there, of another, or of none.
    fn tool_length(&mut self, model: &Model) -> Vec<Word> {
        let number = self.tool_number(model);
        let h = Word::whole('H', number);
        match self.below(9) {
            0..=2 => vec![Word::g(430), h],
            3 => vec![h, Word::g(430)],
            4 => vec![Word::g(430)],
            5 => vec![Word::whole('T', number), Word::m(6), Word::g(430)],
            6 => vec![Word::g(432), h],
            7 => vec![Word::g(430), Word::whole('H', 0)],
            _ => vec![Word::g(490)],
        }
    }

    /// A line of the tool table.
    fn tool_entry(&mut self, model: &Model) -> Vec<Word> {
        let (number, unit) = (self.tool_number(model), ONE / if model.modes.inches { 1_000 } else { 100 });
        let mut words = vec![Word::g(100), Word::whole('L', self.of(&[1, 1, 10, 11])), Word::whole('P', number)];
        let mut of = |letter, most: u64| Word { letter, value: self.below(most) as i64 * unit };
        let (z, r) = (of('Z', 1_500), of('R', 500));
        match self.below(8) {
            0 => words.extend([z, r]),
            1 => words.push(r),
            2 => words.push(Word { value: -z.value, ..z }),
            3 => words.extend([Word { value: 0, ..z }, Word { value: 0, ..r }]),
            _ => words.push(z),
        }
        if self.one_in(6) {
            words.extend(self.tool_length(model));
        }
        if self.one_in(6) {
            words.insert(0, self.work_system());
        }
        words
    }

    /// More tools than the table has room for.
    fn tool_entries(&mut self, model: &Model) -> Vec<Line> {
        let first = self.tool_number(model).min(NUMBER_MAX - 40);
        let entry = |number| {
            let words = vec![Word::g(100), Word::whole('L', 1), Word::whole('P', number), Word::whole('Z', number % 7)];
            Line { text: written(&words, &mut self.random), asked: Asked::Block(words) }
        };
        (first..first + 36).map(entry).collect()
    }

    fn feed(&mut self, model: &Model, inches: bool) -> Word {
        let feed = if model.modes.inverse_time {
            20 + self.below(200)
        } else if inches {
            self.of(&[10, 30, 100])
        } else {
            self.of(&[300, 600, 1_500, 4_000])
        };
        Word::whole('F', feed as i64)
    }

    /// Some of X, Y and Z, so that the machine stays near.
    fn axis_words(&mut self, model: &Model, room: &Room, zero: Place, relative: bool, inches: bool) -> Vec<Word> {
        let reach = self.of(&[1, 1, 3, 10]) * ONE;
        let which = 1 + self.below(7);
        let unit = if inches { INCH_ANGSTROM / 1_000 } else { ONE / self.of(&[100, 100, 1_000]) };
        let mut words = Vec::new();
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate().filter(|&(axis, _)| which >> axis & 1 == 1) {
            let (low, high) = room[axis];
            let here = model.position[axis];
            let mut to = (here - reach + self.below(2 * reach as u64) as i64).clamp(low, high);
            if self.one_in(40) {
                to = self.of(&[low - 5 * ONE, high + 5 * ONE]);
            }
            let units = (to - if relative { here } else { zero[axis] }) / unit;
            let value = units * if inches { ONE / 1_000 } else { unit };
            words.push(Word { letter, value });
        }
        words
    }

    /// A quarter, a half, three quarters or a whole of a circle; some do not fit.
    fn arc(&mut self, model: &Model) -> Vec<Word> {
        let modes = &model.modes;
        let plane = if self.one_in(2) { 17 + self.below(3) as i64 } else { modes.plane };
        let mut words = if plane == modes.plane { Vec::new() } else { vec![Word::g(plane * 10)] };
        let clockwise = self.one_in(2);
        words.push(Word::g(if clockwise { 20 } else { 30 }));
        let relative = modes.incremental || modes.inches;
        if relative && !modes.incremental {
            words.push(Word::g(910));
        }
        if modes.feed < ONE || modes.inverse_time {
            words.push(self.feed(model, modes.inches));
        }
        // G18 turns from Z to X.
        let (across, up) = [(0, 1), (2, 0), (1, 2)][plane as usize - 17];
        let unit = ONE / 1_000 * if modes.inches { 20 } else { 500 };
        let by_radius = self.one_in(3);
        let any: [i64; 2] = std::array::from_fn(|_| self.below(9) as i64 - 4);
        let whole = self.of(&[([3, 4], 5), ([-4, 3], 5), ([0, 2], 2), ([-3, 0], 3), ([4, -3], 5)]);
        let (offset, radius) = if by_radius { whole } else { (any, 0) };
        let (offset, radius) = (offset.map(|units| units * unit), radius * unit);
        let turns = 1 + self.below(4);
        let mut from_centre = [-offset[0], -offset[1]];
        for _ in 0..turns {
            from_centre = if clockwise { [from_centre[1], -from_centre[0]] } else { [-from_centre[1], from_centre[0]] };
        }
        let zero = if relative { model.position } else { model.work_zero() };
        for (index, axis) in [across, up].into_iter().enumerate() {
            let by = offset[index] + from_centre[index];
            let value = by + if modes.inches { 0 } else { model.position[axis] - zero[axis] };
            words.push(Word { letter: ['X', 'Y', 'Z'][axis], value });
            words.extend((!by_radius).then_some(Word { letter: ['I', 'J', 'K'][axis], value: offset[index] }));
        }
        if by_radius {
            words.push(Word { letter: 'R', value: if turns > 2 { -radius } else { radius } });
        }
        if self.one_in(12) {
            // By less than what is allowed, or by more.
            let last = words.last_mut().expect("an arc has words");
            last.value += self.of(&[4, -4, 60, -60, 700]) * ONE / 1_000;
        }
        words
    }

    /// A line of a program that drills: holes, and what may come between them.
    pub fn of_holes(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        match self.below(12) {
            0 if self.one_in(2) => self.straight(model, room),
            0 => self.arc(model),
            1 => vec![Word::g(self.of(&[800, 0, 10]))],
            2 => vec![Word::g(self.of(&[170, 180, 190, 200, 210, 900, 910]))],
            3 => self.offset(model),
            4 => {
                let mut words = vec![Word::g(800)];
                words.extend(self.axis_words(model, room, model.work_zero(), false, model.modes.inches));
                words
            }
            _ => self.cycle(model, room),
        }
    }

    /// A line of a program about the lengths of tools. The table is filled, and emptied.
    pub fn of_lengths(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        match self.below(20) {
            0..=3 => self.straight(model, room),
            4 | 5 => self.tool_length(model),
            6 | 7 => self.offset(model),
            8 => self.cycle(model, room),
            9 => {
                let number = if self.one_in(4) { 0 } else { self.tool_number(model) };
                let (tool, change) = (Word::whole('T', number), Word::m(6));
                self.of(&[&[tool][..], &[tool, change], &[change]]).to_vec()
            }
            10 => vec![self.work_system()],
            11 if self.one_in(3) => vec![Word::m(30)],
            11 => self.faulty(model),
            12 | 13 => self.tool_entry(model),
            14 => {
                let system = Word::whole('P', 1 + self.below(9) as i64);
                vec![Word::g(100), Word::whole('L', 2), system, self.length('Z', model)]
            }
            _ => {
                let number = 1 + self.below(500) as i64;
                vec![Word::g(100), Word::whole('L', 1), Word::whole('P', number), Word::whole('Z', number % 9)]
            }
        }
    }

    /// A line of a canned cycle: one that begins a series, or goes on with it; some lack a word.
    fn cycle(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        let (mut words, incremental, inches) = self.with_modes(model);
        let code = self.of(&[730, 810, 820, 830, 850, 860, 890]);
        let (motion, begins) = if is_cycle(model.modes.motion) && self.one_in(2) {
            (model.modes.motion, false)
        } else {
            words.push(Word::g(code));
            (code, true)
        };
        if self.one_in(3) {
            words.push(Word::g(self.of(&[980, 990])));
        }
        if model.modes.feed < ONE || model.modes.inverse_time {
            words.push(self.feed(model, inches));
        }
        let up = self.of(&['Z', 'Z', 'Z', 'Y', 'X']);
        let axes = self.axis_words(model, room, model.work_zero(), incremental, inches);
        words.extend(axes.into_iter().filter(|word| word.letter != up));
        let unit = ONE / if inches { 25 } else { 1 };
        if begins || self.one_in(3) {
            let axis = ['X', 'Y', 'Z'].iter().position(|&letter| letter == up).unwrap_or_default();
            let here = if incremental { 0 } else { (model.position[axis] - model.work_zero()[axis]) / ONE * unit };
            let (above, depth) = (self.below(5) as i64 - 2, self.below(4) as i64);
            let r = here + above * unit;
            words.push(Word { letter: up, value: if incremental { -depth * unit } else { r - depth * unit } });
            words.extend((!self.one_in(20)).then_some(Word { letter: 'R', value: r }));
            let is_odd = self.one_in(20);
            if matches!(motion, 730 | 830) != is_odd {
                words.push(Word { letter: 'Q', value: unit / 2 * (1 + self.below(4) as i64) });
            }
            if matches!(motion, 820 | 860 | 890) != is_odd {
                words.push(Word { letter: 'P', value: self.below(3) as i64 * ONE / 10 });
            }
        }
        if self.one_in(3) {
            words.push(Word::whole('L', self.of(&[1, 2, 3, 3, 0])));
        }
        words
    }

    fn offset(&mut self, model: &Model) -> Vec<Word> {
        let mut words = match self.below(12) {
            8 | 9 => return self.tool_entry(model),
            10 | 11 => return self.tool_length(model),
            0..=2 => {
                let kind = self.of(&[2, 20]);
                vec![Word::g(100), Word::whole('L', kind), Word::whole('P', self.below(10) as i64)]
            }
            3 => return vec![Word::g(921)],
            4 if self.one_in(2) => return [0, 400, 490, 500, 690, 800, 170].map(Word::g).to_vec(),
            4 => return vec![Word::g(490)],
            5 => vec![Word::g(431)],
            _ => vec![Word::g(920)],
        };
        // Axis words are these codes', whatever the motion mode.
        if self.one_in(4) {
            words.insert(0, Word::g(800));
        }
        if self.one_in(4) {
            words.push(self.work_system());
        }
        let which = if words.contains(&Word::g(431)) { 4 } else { 1 + self.below(7) };
        for (_, letter) in ['X', 'Y', 'Z'].into_iter().enumerate().filter(|&(axis, _)| which >> axis & 1 == 1) {
            words.push(self.length(letter, model));
        }
        words
    }

    fn length(&mut self, letter: char, model: &Model) -> Word {
        let most = if model.modes.inches { 2_000 } else { 60_000 };
        Word { letter, value: (self.below(2 * most) as i64 - most as i64) * ONE / 1_000 }
    }

    fn go_home(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        let mut words = vec![Word::g(self.of(&[280, 300]))];
        if self.one_in(4) {
            words.insert(0, Word::g(self.of(&[800, 0, 10])));
        }
        if self.one_in(2) {
            let modes = &model.modes;
            words.extend(self.axis_words(model, room, model.work_zero(), modes.incremental, modes.inches));
        }
        words
    }

    fn tool(&mut self) -> Vec<Word> {
        match self.below(6) {
            0 => vec![Word::m(self.of(&[3, 4])), Word::whole('S', self.below(1_001) as i64)],
            1 => vec![Word::m(self.of(&[3, 4, 5]))],
            2 => vec![Word::whole('S', self.below(1_000) as i64)],
            3 => vec![Word::whole('T', self.of(&[0, 1, 7, 255, 256, 606, 99_999]))],
            _ => vec![Word::m(self.of(&[7, 8, 9]))],
        }
    }

    fn probe(&mut self, model: &Model, room: &Room) -> Vec<Word> {
        let mut words = vec![Word::g(self.of(&[382, 383, 383, 385]))];
        let modes = &model.modes;
        words.push(self.feed(model, modes.inches));
        words.extend(self.axis_words(model, room, model.work_zero(), modes.incremental, modes.inches));
        words
    }

    /// Words that are often refused.
    fn faulty(&mut self, model: &Model) -> Vec<Word> {
        let x = self.length('X', model);
        let one = |letter| Word::whole(letter, 1);
        let half = |letter| Word { letter, value: 3 * ONE / 2 };
        let z = self.length('Z', model);
        let [g43, g10, of_tool] = [Word::g(430), Word::g(100), Word::whole('L', self.of(&[1, 10, 11]))];
        match self.below(41) {
            25 => vec![g43, half('H')],
            26 => vec![g43, Word::whole('H', -1)],
            27 => vec![g43, Word::whole('H', 100_000)],
            28 => vec![one('H'), self.of(&[Word::g(490), Word::g(0), Word::g(540)])],
            29 => vec![g43, self.of(&[Word::g(490), Word::g(431), Word::g(432)]), one('H')],
            30 => vec![Word::g(432), z],
            31 => vec![g43, one('H'), one('H')],
            32 => vec![g10, of_tool, z],
            33 => vec![g10, of_tool, one('P')],
            34 => vec![g10, of_tool, one('P'), z, x],
            35 => vec![g10, of_tool, Word::whole('P', self.of(&[0, 100_000])), z],
            36 => vec![g10, of_tool, half('P'), z],
            37 => vec![g10, Word::whole('L', self.of(&[10, 11])), one('P'), one('R')],
            38 => vec![g10, of_tool, one('P'), z, Word::whole('R', self.of(&[-1, 1_001]))],
            39 => vec![g10, of_tool, one('P'), Word::whole('Z', 10_500)],
            40 => vec![g10, of_tool, one('P'), z, self.of(&[one('I'), one('Q'), one('H')])],
            22 => vec![half(self.of(&['T', 'N', 'L'])), x],
            23 => vec![Word::g(100), x, Word::whole('L', 2), half('P')],
            24 => vec![Word::g(980), Word::g(990)],
            0 => vec![Word::g(0), Word::g(10), x],
            1 => vec![Word::g(900), Word::g(910)],
            2 => vec![Word::g(100), Word::g(920), x],
            3 => vec![x, x],
            4 => vec![Word::whole('F', -1)],
            5 => vec![Word::whole('T', 100_000)],
            6 => vec![Word::whole('N', 10_000_001)],
            7 => vec![Word::g(40)],
            8 => vec![Word::g(100), x, Word::whole('L', 2)],
            9 => vec![Word::g(100), x, Word::whole('L', 2), Word::whole('P', 10)],
            10 => vec![Word::g(594)],
            11 => vec![Word::g(100), Word::whole('L', 2), one('P')],
            12 => vec![Word::g(920)],
            13 => vec![Word::g(431), x],
            14 => vec![one('I')],
            15 => vec![one('P')],
            16 => vec![Word::g(530), Word::g(800), Word::g(20)],
            17 => vec![Word::g(530), Word::g(800)],
            18 => vec![Word::g(20)],
            19 => vec![Word::g(410)],
            20 => vec![Word::m(60)],
            _ => vec![Word::g(920), Word::whole('Y', 10_500)],
        }
    }

    fn jog(&mut self, model: &Model, room: &Room) -> Line {
        for _ in 0..30 {
            let (mut words, incremental, inches) = self.with_modes(model);
            let machine = self.one_in(8);
            if machine {
                words.push(Word::g(530));
            }
            let zero = if machine { [0; 3] } else { model.work_zero() };
            words.extend(self.axis_words(model, room, zero, incremental && !machine, inches));
            if !self.one_in(15) {
                words.push(Word::whole('F', self.of(&[10, 50, 600]) * if inches { 1 } else { 20 }));
            }
            if self.one_in(15) {
                words.push(self.of(&[Word::g(170), Word::m(3), Word::whole('S', 5), Word::whole('P', 5)]));
            }
            let mut after = model.clone();
            let mut free = Model { homed: [false; 3], ..model.clone() };
            let is_clear = match after.jog(&words) {
                Ok(()) => is_within(&after.position, room),
                Err(15) => free.jog(&words).is_ok() && is_clearly_outside(&free.position, room),
                Err(_) => true,
            };
            if is_clear {
                let text = format!("$J={}", written(&words, &mut self.random));
                return Line { text, asked: Asked::Jog(words) };
            }
        }
        Line { text: "$J=G53".to_owned(), asked: Asked::Refused(if model.state == State::Idle { 22 } else { 8 }) }
    }

    fn system(&mut self, model: &Model) -> Line {
        let is_locked = matches!(model.state, State::Alarm(_));
        let line = |text: &str, asked: Asked| Line { text: text.to_owned(), asked };
        let choice = match model.settings.check() {
            Err(_) => self.below(20),
            Ok(()) => self.below(if is_locked { 6 } else { 20 }),
        };
        match choice {
            0 => line("$H", Asked::Home(None)),
            1 => {
                let axis = self.below(3) as usize;
                line(["$HX", "$HY", "$HZ"][axis], Asked::Home(Some(axis)))
            }
            2..=5 => line("$X", Asked::Unlock),
            6 => line("$C", Asked::Check),
            7 => line("$RST=#", Asked::Restore('#')),
            8 if self.is_default => line("$RST=$", Asked::Restore('$')),
            9 => self.startup(),
            10 => {
                let text = self.of(&["", "MILL3", "A"]);
                Line { text: format!("$I={text}"), asked: Asked::Build(text.to_owned()) }
            }
            _ => {
                let (number, values) = SETTINGS[self.below(SETTINGS.len() as u64) as usize];
                let value = self.of(values);
                Line { text: format!("${number}={value}"), asked: Asked::Set(number, value) }
            }
        }
    }

    fn startup(&mut self) -> Line {
        let index = self.below(2) as usize;
        let words: &[Word] = &[
            vec![],
            vec![Word::g(560)],
            vec![Word::g(592)],
            vec![Word::g(910), Word::g(180)],
            vec![Word::m(8)],
            vec![Word::whole('F', 777)],
        ][self.below(6) as usize];
        let text: String = words.iter().map(ToString::to_string).collect();
        let startup = Startup { words: words.to_vec(), text: text.clone() };
        Line { text: format!("$N{index}={text}"), asked: Asked::Startup(index, startup) }
    }
}

/// Tenths of the numbers of modes, frequent ones more than once.
const MODES: [i64; 18] = [170, 180, 190, 200, 210, 210, 700, 710, 710, 900, 910, 930, 940, 940, 610, 611, 800, 500];

/// Bytes of overrides.
const OVERRIDES: [u8; 13] = [0x90, 0x91, 0x91, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x99, 0x9A, 0x9B, 0x9C];

/// Settings, and values of them; some are refused.
const SETTINGS: [(u16, &[f64]); 20] = [
    (1, &[0.0, 25.0, 255.0]),
    (10, &[0.0, 1.0, 2.0, 3.0, 4.0]),
    (11, &[0.0, 0.01, 0.02, -1.0]),
    (12, &[0.002, 0.01]),
    (13, &[0.0, 0.0, 1.0]),
    (20, &[0.0, 1.0, 1.0]),
    (22, &[0.0, 1.0, 1.0]),
    (24, &[60.0, 100.0]),
    (27, &[1.0, 2.0, 2.5]),
    (28, &[0.0, 1.0, 2.0]),
    (99, &[1.0]),
    (110, &[3_000.0, 5_000.0]),
    (121, &[300.0, 800.0]),
    (922, &[0.0, 400.0]),
    (341, &[0.0, 0.0, 4.0]),
    (394, &[0.0, 0.5]),
    (940, &[0.0, 1.0, 2.0]),
    (950, &[0.0, 1.0, 6.0]),
    (952, &[0.0, 2.0, 4.0, 5.0]),
    (961, &[20.0, 60.0]),
];

/// True if a line does nothing but move, or nothing at all.
fn is_move(line: &Line) -> bool {
    let moves = |word: &Word| match word.letter {
        'X' | 'Y' | 'Z' | 'F' | 'N' => true,
        'G' => matches!(word.tenths(), 0 | 10 | 900 | 910 | 200 | 210 | 530),
        _ => false,
    };
    matches!(&line.asked, Asked::Block(words) if words.iter().all(moves))
}

/// M2 or M30.
fn ends(line: &Line) -> bool {
    let ends = |word: &Word| word.letter == 'M' && matches!(word.tenths(), 20 | 300);
    matches!(&line.asked, Asked::Block(words) if words.iter().any(ends))
}

/// The distance that arcs keep from the ends of the room: what is made of an arc may be outside of it by this.
const ROUND_ANGSTROM: f64 = 0.1 * ONE as f64;

/// True if a block leaves the machine in its room, or is clearly outside and refused for it.
fn stays(model: &Model, words: &[Word], room: &Room) -> bool {
    let mut after = model.clone();
    after.path.clear();
    let refused = after.block(words).is_err();
    let is_arc_inside = after.bend.is_none_or(|(reach, _)| {
        let is_inside = |((low, high), (from, to)): (&(f64, f64), &(i64, i64))| {
            *low - ROUND_ANGSTROM >= *from as f64 && *high + ROUND_ANGSTROM <= *to as f64
        };
        reach.iter().zip(room).all(is_inside)
    });
    let is_way_inside = after.path.iter().all(|place| is_within(place, room));
    match after.state {
        // What lies beyond by less than a step may be rounded to a place within. The way to it has been made.
        State::Alarm(2) if refused => is_way_inside && after.is_clearly_outside(words, model, room),
        _ => is_arc_inside && is_within(&after.position, room) && is_way_inside,
    }
}

impl Model {
    /// True if the target of a block that was refused is beyond the room by a millimetre at least.
    fn is_clearly_outside(&self, words: &[Word], before: &Model, room: &Room) -> bool {
        let mut free = before.clone();
        free.homed = [false; 3];
        free.path.clear();
        free.state = State::Idle;
        let _ = free.block(words);
        let mut places = free.path.clone();
        places.push(free.position);
        places.iter().all(|place| is_clearly_outside(place, room))
    }
}

/// True if each axis is in the room, or beyond it by a millimetre at least.
fn is_clearly_outside(place: &Place, room: &Room) -> bool {
    place.iter().zip(room).all(|(place, (low, high))| {
        let by = (low - place).max(place - high);
        by <= 0 || by > ONE
    })
}

fn is_within(place: &Place, room: &Room) -> bool {
    place.iter().zip(room).all(|(place, (low, high))| (low..=high).contains(&place))
}
