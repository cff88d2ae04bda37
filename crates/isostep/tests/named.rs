//! The lines, seconds and places that texts name, read back and compared with the trace of the steps and with the program's text,
//! which are read here by other means.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const STEPS_PER_MM: f64 = 80.0;
const ACCEL_MM_S2: f64 = 2_000.0;
/// Seconds that are searched begin at multiples of this.
const GRID_S: f64 = 0.1;

/// A corner at a small angle, one at a large one, two right angles, a slow line for a little more than a second, a wait for a person,
/// and 300 moves of 0.4 mm.
fn program() -> String {
    let short: String = (1..=300).map(|number| format!("X{:.1}\n", -40.0 - 0.4 * f64::from(number))).collect();
    format!(
        "%\nG90 G61 (corners are taken exactly)\nF6000\n(the first side)\nG1 X60\nX110 Y20\n\nY90\nX49.5\nX42 Y82.5 F600\n\
         (and fast again)\nX-40 F6000\nM0 (look)\nY20\n{short}Y-20\nM2\n"
    )
}

/// Straight lines in one direction at one feed, which follow each other.
#[derive(Clone, Debug)]
struct Straight {
    /// Their numbers in the program.
    lines: Vec<usize>,
    from_mm: [f64; 2],
    to_mm: [f64; 2],
    mm_s: f64,
    /// A person is waited for before it.
    waits: bool,
}

impl Straight {
    fn mm(&self) -> f64 {
        (self.to_mm[0] - self.from_mm[0]).hypot(self.to_mm[1] - self.from_mm[1])
    }

    fn direction(&self) -> [f64; 2] {
        [0, 1].map(|axis| (self.to_mm[axis] - self.from_mm[axis]) / self.mm())
    }

    fn turn_deg(&self, next: &Self) -> f64 {
        let ([x, y], [to_x, to_y]) = (self.direction(), next.direction());
        (x * to_y - y * to_x).atan2(x * to_x + y * to_y).to_degrees().abs()
    }
}

/// The straights of a program, and the target of each line that moves.
fn straights(program: &str) -> (Vec<Straight>, Vec<(usize, [f64; 2])>) {
    let (mut straights, mut targets) = (Vec::<Straight>::new(), Vec::new());
    let (mut at_mm, mut mm_s, mut waits) = ([0.0; 2], 0.0, false);
    for (number, line) in (1..).zip(program.lines()) {
        let mut to_mm: [f64; 2] = at_mm;
        for word in line.split('(').next().unwrap().split_whitespace() {
            match (word.get(..1), word.get(1..).and_then(|value| value.parse::<f64>().ok())) {
                (Some("X"), Some(mm)) => to_mm[0] = mm,
                (Some("Y"), Some(mm)) => to_mm[1] = mm,
                (Some("F"), Some(mm_min)) => mm_s = mm_min / 60.0,
                (Some("M"), Some(0.0)) => waits = true,
                _ => {}
            }
        }
        if to_mm == at_mm {
            continue;
        }
        targets.push((number, to_mm));
        let straight = Straight { lines: vec![number], from_mm: at_mm, to_mm, mm_s, waits };
        match straights.last_mut().filter(|last| !waits && last.mm_s == mm_s && last.turn_deg(&straight) < 0.01) {
            Some(last) => (last.to_mm, last.lines) = (to_mm, [&last.lines[..], &[number]].concat()),
            None => straights.push(straight),
        }
        (at_mm, waits) = (to_mm, false);
    }
    (straights, targets)
}

/// The steps as the trace has them: instant in s, axis, and the place after it in steps.
fn edges(trace: &Path) -> Vec<(f64, usize, i64)> {
    let text = fs::read_to_string(trace).unwrap();
    let edges = text.lines().skip(1).map(|line| {
        let [t_ns, axis, _, place] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        (t_ns.parse::<f64>().unwrap() * 1e-9, "XYZ".find(axis).unwrap(), place.parse().unwrap())
    });
    edges.collect()
}

/// A run, by its trace: how far along its path it is at which instant, and when it is where its lines end.
struct Run {
    /// Instants of the longer axis, s, and the way until then, mm.
    way: Vec<(f64, f64)>,
    /// Each line that moves: its number, when it begins and when it ends, s since power-up.
    lines: Vec<(usize, f64, f64)>,
    /// When the first move begins.
    begin_s: f64,
}

impl Run {
    fn new(program: &str, edges: &[(f64, usize, i64)]) -> Self {
        let (_, targets) = straights(program);
        let half_step_s = (1.0 / STEPS_PER_MM / ACCEL_MM_S2).sqrt();
        let begin_s = edges[0].0 - half_step_s;
        let (mut way, mut lines) = (Vec::new(), Vec::new());
        let (mut rest, mut at, mut made_mm, mut from_s) = (edges, [0_i64; 2], 0.0, begin_s);
        for (number, to_mm) in targets {
            let to = to_mm.map(|mm| (mm * STEPS_PER_MM).round() as i64);
            let count = (at[0].abs_diff(to[0]) + at[1].abs_diff(to[1])) as usize;
            let (own, later) = rest.split_at(count);
            let longer = usize::from(at[1].abs_diff(to[1]) > at[0].abs_diff(to[0]));
            let steps = at[longer].abs_diff(to[longer]) as f64;
            let mm = (at[0] - to[0]).abs().pow(2) + (at[1] - to[1]).abs().pow(2);
            let mm = (mm as f64).sqrt() / STEPS_PER_MM;
            let of_longer = own.iter().filter(|(_, axis, _)| *axis == longer);
            way.extend(
                of_longer.zip(0..).map(|((t_s, ..), index)| (*t_s, made_mm + (f64::from(index) + 0.5) / steps * mm)),
            );
            let last = |axis: usize| own.iter().rfind(|edge| edge.1 == axis).map_or(at[axis], |edge| edge.2);
            assert_eq!([last(0), last(1)], to, "line {number} ends elsewhere");
            // The end is half a step behind its last edge, and in front of the next.
            let last_s = own.last().unwrap().0;
            let end_s = later.first().map_or(last_s, |next| (last_s + next.0) / 2.0);
            lines.push((number, from_s, end_s));
            (rest, at, made_mm, from_s) = (later, to, made_mm + mm, end_s);
        }
        assert!(rest.is_empty(), "{} edges are of no line", rest.len());
        Self { way, lines, begin_s }
    }

    fn way_mm(&self, t_s: f64) -> f64 {
        let at = self.way.partition_point(|(s, _)| *s <= t_s).clamp(1, self.way.len() - 1);
        let [(from_s, from_mm), (to_s, to_mm)] = [self.way[at - 1], self.way[at]];
        from_mm + (to_mm - from_mm) * ((t_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0)
    }

    fn at_s(&self, way_mm: f64) -> f64 {
        let at = self.way.partition_point(|(_, mm)| *mm <= way_mm).clamp(1, self.way.len() - 1);
        let [(from_s, from_mm), (to_s, to_mm)] = [self.way[at - 1], self.way[at]];
        from_s + (to_s - from_s) * (way_mm - from_mm) / (to_mm - from_mm)
    }

    /// The way of a second from the start of the first move, and how many lines begin in it.
    fn second(&self, start_s: f64) -> (f64, usize) {
        let from_s = self.begin_s + start_s;
        let begun = self.lines.iter().filter(|(_, begin_s, _)| (from_s..from_s + 1.0).contains(begin_s)).count();
        (self.way_mm(from_s + 1.0) - self.way_mm(from_s), begun)
    }

    fn seconds(&self) -> impl Iterator<Item = (f64, usize)> {
        let lasts_s = self.lines.last().unwrap().2 - self.begin_s;
        (0..((lasts_s - 1.0) / GRID_S) as u32).map(|number| self.second(f64::from(number) * GRID_S))
    }

    /// This line is under way at an instant from the start of the first move, good to 2 ms.
    fn is_under_way(&self, line: usize, t_s: f64) -> bool {
        let t_s = self.begin_s + t_s;
        self.lines
            .iter()
            .any(|&(number, begin_s, end_s)| number == line && (begin_s - 0.002..end_s + 0.002).contains(&t_s))
    }

    fn line(&self, number: usize) -> (f64, f64) {
        self.lines.iter().find(|line| line.0 == number).map(|line| (line.1, line.2)).unwrap()
    }
}

/// The words of a program's run, its trace, and its page.
struct Said {
    sim: String,
    check: String,
    page: String,
    edges: Vec<(f64, usize, i64)>,
}

fn said(name: &str, program: &str, more: &str) -> Said {
    let folder = std::env::temp_dir().join(format!("isostep-named-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name).display().to_string();
    let machine =
        fs::read_to_string(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../programs/machines/c.txt")).unwrap();
    fs::write(file("my.txt"), machine + more).unwrap();
    fs::write(file("my.nc"), program).unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_isostep")).args(arguments).output().unwrap();
        String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
    };
    let (nc, txt, trace, page) = (file("my.nc"), file("my.txt"), file("trace.csv"), file("page"));
    let sim = run(&["sim", &nc, "--settings", &txt, "--start", "200,200,200", "--trace", &trace, "--report", &page]);
    let check = run(&["check", &nc, "--settings", &txt]);
    let page = fs::read_to_string(Path::new(&page).join("index.html")).unwrap();
    let edges = edges(Path::new(&trace));
    fs::remove_dir_all(folder).unwrap();
    Said { sim, check, page, edges }
}

/// The number behind some words in a text.
fn number(text: &str, behind: &str) -> f64 {
    let rest = text.split_once(behind).unwrap_or_else(|| panic!("no `{behind}` in `{text}`")).1;
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != '-').unwrap_or(rest.len());
    rest[..end].trim_end_matches('.').parse().unwrap_or_else(|_| panic!("no number behind `{behind}` in `{text}`"))
}

/// The cells of a table's rows.
fn cells(row: &str) -> Vec<String> {
    let cells =
        row.split("<td").skip(1).map(|cell| cell.split_once('>').unwrap().1.split('<').next().unwrap().to_owned());
    cells.collect()
}

fn rows<'p>(page: &'p str, heading: &str) -> impl Iterator<Item = Vec<String>> + use<'p> {
    let behind = page.split_once(heading).unwrap_or_else(|| panic!("no {heading}")).1;
    let table = behind.split("</table>").next().unwrap();
    table.split("<tr").skip(1).map(cells).filter(|cells| !cells.is_empty())
}

/// Instants at which the path is at most as fast as it turns: straights that follow each other without a wait, at one feed.
fn corners(straights: &[Straight]) -> impl Iterator<Item = (&Straight, &Straight)> {
    let pairs = straights.iter().zip(&straights[1..]);
    pairs.filter(|(from, to)| !to.waits && from.mm_s == to.mm_s)
}

#[test]
fn a_corner_is_named_by_its_line_its_place_and_what_it_costs() {
    let program = program();
    let (straights, _) = straights(&program);
    let said = said("corners", &program, "");
    let run = Run::new(&program, &said.edges);
    let before_mm = |straight: &Straight| {
        straights.iter().take_while(|other| other.lines != straight.lines).map(Straight::mm).sum::<f64>()
    };
    let reported = said.check.split_once("those that cost most\n").unwrap().1;
    let reported: Vec<_> = reported.lines().take_while(|line| line.starts_with("    line ")).collect();
    assert_eq!(reported.len(), corners(&straights).count(), "{}", said.check);
    let mut dearest_s = f64::INFINITY;
    for line in reported {
        let named = number(line, "line ") as usize;
        let (from, to) = corners(&straights).find(|(_, to)| to.lines[0] == named).unwrap_or_else(|| panic!("{line}"));
        let place = format!(" at X{:.2} Y{:.2} Z0.00: ", to.from_mm[0], to.from_mm[1]);
        assert!(line.contains(&place), "{line} for {place}");
        assert!((number(line, "turns by ") - from.turn_deg(to)).abs() <= 0.51, "{line}: {}", from.turn_deg(to));
        // From the middle of one straight to that of the next.
        let at_mm = before_mm(to);
        let took_s = run.at_s(at_mm + to.mm() / 2.0) - run.at_s(at_mm - from.mm() / 2.0);
        let lost_s = took_s - (from.mm() + to.mm()) / 2.0 / to.mm_s;
        let reported_s = number(line, "mm/s, ");
        assert!((reported_s - lost_s).abs() < 0.001 && reported_s <= dearest_s, "{line}: {lost_s}");
        dearest_s = reported_s;
        // The page has it with its instant, and with both of its lines.
        let lines = format!("{} to {named}", from.lines.last().unwrap());
        let row = rows(&said.page, "Time lost at slow places")
            .chain(rows(&said.page, "<h3>"))
            .find(|row| row.get(2) == Some(&lines));
        let row = row.unwrap_or_else(|| panic!("no {lines} on the page"));
        assert_eq!(row[3], format!("{:.2}, {:.2}, 0.00", to.from_mm[0], to.from_mm[1]));
        let at_s: f64 = row[7].parse().unwrap();
        assert!((at_s - (run.line(named).0 - run.begin_s)).abs() < 0.003, "{row:?}: {:?}", run.line(named));
    }
}

#[test]
fn a_second_is_named_by_its_beginning_its_speed_and_its_lines() {
    let program = program();
    let said = said("seconds", &program, "");
    let run = Run::new(&program, &said.edges);
    let reported = |which: &str| {
        let line = said.sim.lines().find(|line| line.contains(&format!("the {which} second: "))).unwrap();
        let (start_s, lines) = (number(line, "from "), line.rsplit_once(", line").unwrap().1.trim_start_matches('s'));
        let lines: Vec<usize> = lines.split(" to ").map(|number| number.trim().parse().unwrap()).collect();
        let (first, last) = (lines[0], lines[lines.len() - 1]);
        assert!(run.is_under_way(first, start_s) && run.is_under_way(last, start_s + 1.0), "{line}: {:?}", run.lines);
        (line.to_owned(), run.second(start_s))
    };
    let (line, (mm, begun)) = reported("slowest");
    assert!((number(&line, "s on, ") - mm).abs() < 0.02, "{line}: {mm}");
    assert!(number(&line, "that begin: ") as usize == begun, "{line}: {begun}");
    let mut ways_mm: Vec<f64> = run.seconds().map(|second| second.0).collect();
    ways_mm.sort_by(f64::total_cmp);
    assert!((ways_mm[0] - mm).abs() < 0.02 && ways_mm[1] > mm + 0.1, "{line}: {ways_mm:?}");
    let (line, (_, begun)) = reported("busiest");
    let reported = number(&line, "that begin: ");
    let most = run.seconds().map(|second| second.1).max().unwrap();
    assert!((reported - begun as f64).abs() <= 1.0 && (reported - most as f64).abs() <= 1.0, "{line}: {begun}, {most}");
}

#[test]
fn a_move_a_jump_and_a_wait_are_named_by_their_lines() {
    let program = program();
    let (straights, targets) = straights(&program);
    let said = said("moves", &program, "");
    let run = Run::new(&program, &said.edges);
    let order = |line: usize| 1 + targets.iter().position(|target| target.0 == line).unwrap();
    // The longest move.
    let longest = run.lines.iter().max_by(|one, other| (one.2 - one.1).total_cmp(&(other.2 - other.1))).unwrap();
    let reported = said.sim.lines().find(|line| line.contains("the longest lasts ")).unwrap();
    assert!(reported.ends_with(&format!(": move {}, line {}", order(longest.0), longest.0)), "{reported}: {longest:?}");
    assert!((number(reported, "lasts ") - (longest.2 - longest.1)).abs() < 0.003, "{reported}: {longest:?}");
    // Where the speed of each axis jumps most: the speed at a corner is that of the way around it.
    for (axis, name) in [(0, "X"), (1, "Y")] {
        let jump = |(from, to): &(&Straight, &Straight)| {
            let at_s = run.line(to.lines[0]).0;
            let around_mm = run.way_mm(at_s + 0.001) - run.way_mm(at_s - 0.001);
            around_mm / 0.002 * (to.direction()[axis] - from.direction()[axis]).abs()
        };
        let (_, to) = corners(&straights).max_by(|one, other| jump(one).total_cmp(&jump(other))).unwrap();
        let reported = said.sim.lines().find(|line| line.starts_with(&format!("   {name} "))).unwrap();
        let place = format!("to move {}, line {}", order(to.lines[0]), to.lines[0]);
        assert!(reported.ends_with(&place), "{reported} for {place}");
        let row = rows(&said.page, ">Axes and their limits</h2>").find(|row| row[0] == name).unwrap();
        assert_eq!(row[6..8], [order(to.lines[0]).to_string(), to.lines[0].to_string()]);
    }
    // Where an axis is most above its limit, in the caption of the picture.
    let reported = said.page.split_once("this run: at most ").unwrap().1.split_once(" times the limit (").unwrap().1;
    let jumps = corners(&straights).map(|(from, to)| {
        let at_s = run.line(to.lines[0]).0;
        let mm_s = (run.way_mm(at_s + 0.001) - run.way_mm(at_s - 0.001)) / 0.002;
        let of_axes = [0, 1].map(|axis| mm_s * (to.direction()[axis] - from.direction()[axis]).abs());
        (of_axes[0].max(of_axes[1]), if of_axes[0] > of_axes[1] { "X" } else { "Y" }, to)
    });
    let (_, name, to) = jumps.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap();
    let place = format!("{name}, line {}, at X{:.2} Y{:.2} Z0.00)", to.lines[0], to.from_mm[0], to.from_mm[1]);
    assert!(reported.starts_with(&place), "{} for {place}", reported.split_once(')').unwrap().0);
    // The wait for a person.
    let waits = 1 + program.lines().position(|line| line.starts_with("M0")).unwrap();
    let reported = said.sim.lines().find(|line| line.contains("`M0`")).unwrap();
    let before = run.lines.iter().rfind(|line| line.0 < waits).unwrap();
    assert_eq!(number(reported, "line ") as usize, waits, "{reported}");
    assert!((number(reported, "at ") - before.2).abs() < 0.02, "{reported}: {before:?}");
    // The table of the page has every move with its line and its end.
    let mut listed = 0;
    for row in rows(&said.page, ">Moves</h2>").filter(|row| !row[0].is_empty()) {
        let (line, to_mm) = targets[row[0].parse::<usize>().unwrap() - 1];
        assert_eq!([row[1].as_str(), &row[2]], [&line.to_string(), &format!("{:.2}, {:.2}, 0.00", to_mm[0], to_mm[1])]);
        listed += 1;
    }
    assert!(listed >= 20, "{listed}");
}

#[test]
fn a_loss_is_named_by_its_second_and_its_line() {
    let program = "G90 G61\nF600 G1 X5\n(now fast)\nG0 X600\n\nG1 X590\nM2\n";
    let said = said("losses", program, "$110=60000\n$120=3000\n");
    let losses: Vec<_> = said.sim.lines().filter(|line| line.contains(" steps lost: ")).take(1).collect();
    let (line, t_s) = (number(losses[0], ": line "), number(&format!("at{}", losses[0].trim()), "at"));
    assert_eq!((line, number(losses[0], ", move ")), (4.0, 2.0), "{}", losses[0]);
    let own = |from: i64, to: i64| {
        let inside = said.edges.iter().filter(move |edge| (from..=to).contains(&edge.2));
        inside.map(|edge| edge.0).fold([f64::INFINITY, 0.0], |[least, most], s| [s.min(least), s.max(most)])
    };
    let [begin_s, _] = own(5 * 80 + 1, 5 * 80 + 1);
    let [end_s, _] = own(600 * 80, 600 * 80);
    assert!((begin_s..end_s).contains(&t_s), "{}: {begin_s} to {end_s}", losses[0]);
}
