//! Jobs of other people, each with words that not every machine knows, on the interpreter, on the simulated machine and on the model of
//! the dialect: which are accepted, which line is the first that is not, and whether those that are accepted go where the model says.
//! The jobs are not part of the project: `ISOSTEP_CORPUS` names a folder with `words/`. Without it there is nothing to test.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use expect_test::expect_file;
use isostep_console::{Settings, report};
use isostep_motion::AXES;
use isostep_report::survey::{LISTED_MAX, Refused, Survey};
use isostep_report::timing;
use isostep_sim::Config;
use isostep_sim::program::Program;
use isostep_tests::axes::xyz_a;
use isostep_tests::model::{Followed, TOOLS_MAX, follow};

/// The machine has room for each job.
const TRAVEL_MM: f32 = 6_000.0;
const STEPS_PER_MM: f32 = 80.0;
/// The model counts in 1e-7 mm, of which the words of a line in inches are rounded to 25.
const ROUNDED_MM: f64 = 5e-6;

/// The columns of the table. `lines` are refused in all.
const HEAD: &str = "job                                                        result    line word    error  lines whose fault; or the least and the greatest place, and the end, mm\n";
const NAME_WIDE: usize = 58;

/// A range, mm.
type Range = (f64, f64);

fn settings() -> Settings {
    Settings {
        travel_mm: xyz_a([TRAVEL_MM; 3], 0.0),
        steps_per_mm: [STEPS_PER_MM; AXES],
        max_rate_mm_min: [5_000.0; AXES],
        accel_mm_s2: [500.0; AXES],
        jerk_or_0_mm_s3: [0.0; AXES],
        // The machine takes corners exactly.
        blend_deviation_mm: 0.0,
        ..Settings::DEFAULT
    }
}

/// A job that has been read.
struct Job {
    name: String,
    program: Program,
    survey: Survey,
    followed: Followed,
}

impl Job {
    fn of(path: &Path, settings: &Settings, listing: &[String]) -> Self {
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let program = Program::read_raw(&fs::read(path).expect("a file")).expect("a text");
        Self::read(name, program, settings, listing)
    }

    fn read(name: String, program: Program, settings: &Settings, listing: &[String]) -> Self {
        let survey = Survey::of(&program, settings, timing::middle_mm(settings));
        let followed = follow(&program, listing);
        Self { name, program, survey, followed }
    }

    /// The same job on a machine whose tools have lengths, each another one.
    fn with_tools(&self, settings: &Settings, listing: &[String]) -> Self {
        let entry = |number: usize| format!("G10 L1 P{number} Z{}.25", 3 * number).into_bytes();
        let lines = (1..=TOOLS_MAX).map(entry).chain(self.program.iter().cloned());
        Self::read(format!("{} with tools", self.name), lines.collect(), settings, listing)
    }

    /// Compares all but the table.
    fn compare(&self, settings: &Settings) -> Vec<String> {
        let is_accepted = self.survey.refused_total == 0;
        let plan = is_accepted.then(|| self.compare_plan(settings)).and_then(Result::err);
        [self.compare_refusals().err(), self.compare_reach().err(), plan].into_iter().flatten().collect()
    }

    /// Compares the lines that the interpreter and the model refuse. Those with the code 0 make no line for the machine.
    fn compare_refusals(&self) -> Result<(), String> {
        let refused = self.survey.refused.iter().filter(|refused| refused.code != 0);
        let refused: Vec<_> = refused.map(|refused| (refused.line, refused.code)).collect();
        let by_model = self.followed.refused.iter().map(|&(index, code)| (self.program.number(index + 1), code));
        let by_model: Vec<_> = by_model.take(LISTED_MAX).collect();
        if refused == by_model {
            return Ok(());
        }
        let one_of = |these: &[(usize, u8)], those: &[(usize, u8)]| {
            these.iter().find(|line| !those.contains(line)).map_or("-".to_owned(), |line| format!("{line:?}"))
        };
        let (only, only_model) = (one_of(&refused, &by_model), one_of(&by_model, &refused));
        Err(format!("{}: line and error {only} not by the model; {only_model} by the model alone", self.name))
    }

    /// Compares the reach of what is accepted with that of the model, arcs in closed form.
    fn compare_reach(&self) -> Result<(), String> {
        let extents = self.survey.extents_mm.unwrap_or_default();
        let told: [Range; 3] = std::array::from_fn(|axis| (extents.low_mm[axis], extents.high_mm[axis]));
        self.same("reach", told, self.followed.reach_mm, ROUNDED_MM + self.followed.misfit_mm)
    }

    /// Compares the reach of the moves that are planned for a job that is accepted whole, and where these end.
    fn compare_plan(&self, settings: &Settings) -> Result<(), String> {
        let reach_mm = self.followed.reach_mm;
        let (planned, end_mm) = self.planned(settings)?;
        // A chord is within `$12` of its arc, or a quarter of a step.
        let (step_mm, chord_mm) = (1.0 / f64::from(STEPS_PER_MM), f64::from(settings.arc_tolerance_mm));
        let half_step_mm = step_mm / 2.0 + ROUNDED_MM;
        self.same("plan", planned, reach_mm, half_step_mm + chord_mm.max(step_mm / 4.0) + self.followed.misfit_mm)?;
        self.same("end", end_mm.map(|mm| (mm, mm)), self.followed.end_mm.map(|mm| (mm, mm)), half_step_mm)
    }

    fn same(&self, what: &str, made: [Range; 3], expected: [Range; 3], within_mm: f64) -> Result<(), String> {
        let is_near = |(made, expected): (&Range, &Range)| {
            (made.0 - expected.0).abs() <= within_mm && (made.1 - expected.1).abs() <= within_mm
        };
        if made.iter().zip(&expected).all(is_near) {
            return Ok(());
        }
        Err(format!("{}: {what} {made:?}, by the model {expected:?}, within {within_mm} mm", self.name))
    }

    /// The reach of the moves that the machine plans, and where they end, mm.
    fn planned(&self, settings: &Settings) -> Result<([Range; 3], [f64; 3]), String> {
        let start_mm = timing::middle_mm(settings);
        let config = Config { settings: *settings, start_mm, only_time: true, keep_waves: false, ..Config::default() };
        let outcome = timing::made(self.program.clone(), &config).map_err(|why| format!("{}: {why}", self.name))?;
        let (mut low, mut high, mut end) = ([0; AXES], [0; AXES], [0; AXES]);
        for record in outcome.program_moves() {
            end = record.end_steps;
            for place in [record.origin_steps, end] {
                for axis in 0..AXES {
                    (low[axis], high[axis]) = (low[axis].min(place[axis]), high[axis].max(place[axis]));
                }
            }
        }
        let [low_mm, high_mm, end_mm] = [low, high, end].map(|steps| outcome.mm(steps));
        Ok((std::array::from_fn(|axis| (low_mm[axis], high_mm[axis])), std::array::from_fn(|axis| end_mm[axis])))
    }

    /// A row of the table.
    fn row(&self) -> String {
        let name = &self.name;
        match self.survey.refused.first() {
            None => format!("{name:<NAME_WIDE$} accepted  {}", self.places()),
            Some(refused) => {
                let (line, code, word) = (refused.line, refused.code, word(refused));
                let count = self.survey.refused_total;
                format!("{name:<NAME_WIDE$} refused   {line:>4} {word:<7} {code:>5} {count:>6} {}", remark(refused))
            }
        }
    }

    /// The reach and the end.
    fn places(&self) -> String {
        let Followed { reach_mm, end_mm, .. } = &self.followed;
        let axes = ['X', 'Y', 'Z'].iter().zip(reach_mm).zip(end_mm);
        let texts = axes.map(|((name, (low, high)), end)| format!("{name} {low:.3} to {high:.3}, {end:.3}"));
        texts.collect::<Vec<_>>().join("; ")
    }
}

/// The word at which a line is refused.
fn word(refused: &Refused) -> &str {
    let named = refused.remedy.split(':').next().filter(|named| named.len() <= 5 && refused.code != 0);
    refused.word.as_deref().or(named).unwrap_or("-")
}

/// Whose fault a refusal is.
fn remark(refused: &Refused) -> &'static str {
    match (refused.code, word(refused)) {
        (0, _) => "the program: a value that it has not, or a file that is elsewhere",
        (22, _) => "the program: no F",
        (33 | 34, _) => "the program: radii that do not fit",
        (20, "G41" | "G42" | "G41.1" | "G42.1" | "G41.2" | "G42.2") => "cutter compensation",
        (20, "G43" | "G43.2") => "tool length by number",
        (20, word) if word.starts_with('A') => "an axis that this machine does not have",
        (20, _) => "a word that is not known",
        (36, _) => "the program: a word that no code on the line uses",
        _ => "the program",
    }
}

#[test]
fn jobs_of_others_go_where_the_model_says() {
    let Some(folder) = std::env::var_os("ISOSTEP_CORPUS").map(PathBuf::from) else { return };
    let settings = settings();
    let mut listing = String::new();
    report::settings(&mut listing, &settings).expect("a text takes all");
    let listing: Vec<String> = listing.lines().map(str::to_owned).collect();
    let files =
        fs::read_dir(folder.join("words")).expect("a folder of jobs").map(|entry| entry.expect("a file").path());
    let mut paths: Vec<_> = files.filter(|path| path.extension().is_none_or(|ends| ends != "csv")).collect();
    paths.sort();
    let (mut table, mut accepted, mut longer, mut differences) = (HEAD.to_owned(), 0, 0, Vec::new());
    for path in &paths {
        let job = Job::of(path, &settings, &listing);
        writeln!(table, "{}", job.row()).expect("a text takes all");
        println!("{}: {:?}", job.name, job.survey.refused_by_word);
        accepted += usize::from(job.survey.refused_total == 0);
        let measured = job.with_tools(&settings, &listing);
        differences.extend([&job, &measured].into_iter().flat_map(|job| job.compare(&settings)));
        longer += usize::from(measured.followed.reach_mm != job.followed.reach_mm);
    }
    println!("{accepted} of {} accepted, {:.1} %", paths.len(), 100.0 * accepted as f64 / paths.len() as f64);
    println!("{longer} go elsewhere where tools have lengths");
    expect_file!["words_corpus.txt"].assert_eq(&table);
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}
