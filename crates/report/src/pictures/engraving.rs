//! A picture of the work of a laser: the dose of its beam in the XY plane, dark where it is high.

mod sheet;

use png::{BitDepth, ColorType, Encoder, EncodingError, PixelDimensions, Unit};

use self::sheet::Sheet;
use crate::tool::spells::{self, Spell};
use isostep_motion::AXES;
use isostep_sim::Outcome;

/// A picture and its scale.
pub struct Picture {
    /// The PNG file.
    pub png: Vec<u8>,
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// The side of a pixel, mm.
    pub pixel_mm: f64,
    /// The width of the beam, mm.
    pub spot_mm: f64,
    /// The dose that is drawn black, in s of full duty per mm².
    pub black_s_mm2: f64,
    /// The least and greatest positions at which the beam was on: X and Y.
    pub extent_mm: [(f64, f64); 2],
}

/// The picture, if the tool is a laser at the end of the run, the beam was on, and the run has edges.
pub fn picture(outcome: &Outcome) -> Option<Picture> {
    if !outcome.tool_config.laser || outcome.edges.is_empty() {
        return None;
    }
    let spells = spells::of_spindle(&outcome.tool, true, outcome.duration_ns);
    let extent_mm = extent_mm(outcome, &spells)?;
    let step_mm = [0, 1].map(|axis| 1.0 / outcome.axis_steps_per_mm[axis]);
    let mut sheet = Sheet::new(extent_mm, step_mm[0].max(step_mm[1]), outcome.config.beam_mm);
    places(outcome, &spells, &mut |steps, dose| sheet.add(mm(outcome, steps), dose));
    let strong = sheet.strong();
    let png = encoded(&sheet, strong).expect("drawing into memory does not fail");
    Some(Picture {
        png,
        size: sheet.size(),
        pixel_mm: sheet.pixel_mm,
        spot_mm: sheet.spot_mm(),
        black_s_mm2: f64::from(strong) / (sheet.pixel_mm * sheet.pixel_mm),
        extent_mm,
    })
}

fn mm(outcome: &Outcome, [x, y]: [i32; 2]) -> [f64; 2] {
    let mut steps = [0; AXES];
    (steps[0], steps[1]) = (x, y);
    let [x_mm, y_mm, ..] = outcome.mm(steps);
    [x_mm, y_mm]
}

/// The extent in which the beam was on; `None` if it never was.
fn extent_mm(outcome: &Outcome, spells: &[Spell]) -> Option<[(f64, f64); 2]> {
    let mut extent: Option<[(f64, f64); 2]> = None;
    places(outcome, spells, &mut |steps, _| {
        let mm = mm(outcome, steps);
        let known = extent.unwrap_or(mm.map(|at| (at, at)));
        extent = Some([0, 1].map(|axis| (known[axis].0.min(mm[axis]), known[axis].1.max(mm[axis]))));
    });
    extent
}

/// The position of the carriage between two steps of X or Y.
struct Stand {
    since_ns: u64,
    steps: [i32; 2],
}

/// Calls `take` with every position at which the beam was on, X and Y in steps, and with the dose there, which is duty
/// times s. In order of time.
fn places(outcome: &Outcome, spells: &[Spell], take: &mut impl FnMut([i32; 2], f64)) {
    let mut stands = stands(outcome).peekable();
    let mut spells = spells.iter().peekable();
    while let Some(Stand { since_ns, steps }) = stands.next() {
        let until_ns = stands.peek().map_or(u64::MAX, |next| next.since_ns);
        while let Some(spell) = spells.peek() {
            let (begin_ns, end_ns) = (spell.begin_ns.max(since_ns), spell.end_ns.min(until_ns));
            if begin_ns < end_ns {
                take(steps, (end_ns - begin_ns) as f64 * 1e-9 * spell.duty_ratio);
            }
            if spell.end_ns > until_ns {
                break;
            }
            spells.next();
        }
    }
}

/// All positions of the program, in order. Homing is left out because it resets the origin.
fn stands(outcome: &Outcome) -> impl Iterator<Item = Stand> {
    outcome.runs().flat_map(|(_, run)| {
        let [x, y, ..] = run[0].origin_steps;
        let mut steps = [x, y];
        let edges = outcome.edges_of_run(run).iter().filter(|edge| edge.axis < 2);
        let after = edges.map(move |edge| {
            steps[edge.axis] += edge.direction;
            Stand { since_ns: edge.t_ns, steps }
        });
        std::iter::once(Stand { since_ns: run[0].begin_ns(), steps: [x, y] }).chain(after)
    })
}

fn encoded(sheet: &Sheet, strong: f32) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let [width, height] = sheet.size();
    let mut encoder = Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Eight);
    let per_m = (1_000.0 / sheet.pixel_mm).round() as u32;
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_m, yppu: per_m, unit: Unit::Meter }));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&sheet.greys(strong))?;
    writer.finish()?;
    Ok(file)
}

impl Picture {
    /// Sentences about what the picture shows and how to read it.
    pub fn caption(&self) -> String {
        let [x, y] = self.extent_mm.map(|(low, high)| format!("{:.2} to {:.2}", low + 0.0, high + 0.0));
        let Self { size: [width, height], pixel_mm, spot_mm, black_s_mm2, .. } = self;
        format!(
            "The dose on the XY plane: the beam's duty times its time, where the edges say the carriage was. White is none, black \
             {black_s_mm2:.3} s of full duty per mm² or more, which 99 % of what was lit do not exceed. {width} x {height} pixels \
             of {pixel_mm:.3} mm; the beam is taken to be {spot_mm:.2} mm wide. X {x}, Y {y} mm."
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    fn engraved(program: &str, config: &Config) -> Option<Picture> {
        let outcome = run(program.as_bytes(), config).unwrap();
        assert!(outcome.refusals.is_empty(), "{:?}", outcome.refusals);
        picture(&outcome)
    }

    /// The grey value at a position.
    fn grey(picture: &Picture, at_mm: [f64; 2]) -> u8 {
        let mut reader = png::Decoder::new(std::io::Cursor::new(&picture.png)).read_info().unwrap();
        let mut greys = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut greys).unwrap();
        let [width, height] = picture.size;
        assert_eq!([info.width as usize, info.height as usize], picture.size);
        let around = (width as f64 - (picture.extent_mm[0].1 - picture.extent_mm[0].0) / picture.pixel_mm) / 2.0;
        let [column, row] = [0, 1].map(|axis| {
            ((at_mm[axis] - picture.extent_mm[axis].0) / picture.pixel_mm + around.floor()).round() as usize
        });
        greys[(height - 1 - row) * width + column]
    }

    /// An L upside down; its bar is lighter than its stem.
    const PROGRAM: &str = "$32=1\nG21 G91 F600\nM4 S1000\nG1 Y10\nS400\nX5\nM5\nG1 Y-10\nM2\n";

    #[test]
    fn it_is_dark_where_it_burned_and_white_elsewhere() {
        let picture = engraved(PROGRAM, &Config::default()).unwrap();
        assert_eq!((picture.pixel_mm, picture.extent_mm), (0.05, [(0.0, 5.0), (0.0, 10.0)]));
        let [stem, bar, inside, back] =
            [[0.0, 5.0], [3.0, 10.0], [2.0, 5.0], [5.0, 5.0]].map(|at_mm| grey(&picture, at_mm));
        assert!(stem < 10 && (140..165).contains(&bar), "{stem} {bar}");
        assert_eq!((inside, back), (255, 255));
        // 10 mm/s with a width of 0.1 mm.
        assert!((picture.black_s_mm2 - 1.0).abs() < 0.1, "{}", picture.black_s_mm2);
        assert!(picture.caption().contains("X 0.00 to 5.00, Y 0.00 to 10.00 mm"), "{}", picture.caption());
    }

    /// A beam four times as wide spreads the same light over four times the area, and half as much where it is
    /// half its width away.
    #[test]
    fn a_wide_beam_engraves_wide_lines() {
        let [narrow, wide] =
            [0.1, 0.4].map(|beam_mm| engraved(PROGRAM, &Config { beam_mm, ..Config::default() }).unwrap());
        assert_eq!(grey(&narrow, [0.2, 5.0]), 255);
        assert!((80..200).contains(&grey(&wide, [0.2, 5.0])), "{}", grey(&wide, [0.2, 5.0]));
        assert!((narrow.black_s_mm2 / wide.black_s_mm2 - 4.0).abs() < 0.4, "{}", wide.black_s_mm2);
        assert!(wide.caption().contains("0.40 mm"), "{}", wide.caption());
    }

    #[test]
    fn without_a_laser_a_beam_or_edges_there_is_none() {
        assert!(engraved(&PROGRAM.replace("$32=1", ""), &Config::default()).is_none());
        assert!(engraved(&PROGRAM.replace("S1000", "S0").replace("S400", ""), &Config::default()).is_none());
        assert!(engraved(PROGRAM, &Config { only_time: true, ..Config::default() }).is_none());
    }
}
