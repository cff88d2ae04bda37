//! The functions and types that JavaScript sees. Everything that can go wrong is thrown as JSON of a [`Trouble`](crate::Trouble).

use isostep_motion::AXES;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::piece::packed;
use crate::{Job, Kept, Lines, Live, Motion, Quick, Trouble, listing, ringing, speed_profiles, table, whole};

type Thrown<T> = Result<T, String>;

fn thrown(trouble: Trouble) -> String {
    serde_json::to_string(&trouble).unwrap_or(trouble.words)
}

/// The rows of a form of settings, as JSON.
#[wasm_bindgen(js_name = settingRows)]
pub fn setting_rows() -> String {
    serde_json::to_string(&table::rows()).unwrap_or_default()
}

/// Why settings, lines of `$n=v`, cannot be together, as JSON; `null` if they can.
#[wasm_bindgen(js_name = settingsRefusal)]
pub fn settings_refusal(lines: &str) -> String {
    serde_json::to_string(&table::refusal(lines)).unwrap_or_default()
}

/// What becomes of a `$$` of another controller, as JSON.
#[wasm_bindgen(js_name = settingsListed)]
pub fn settings_listed(text: &[u8]) -> String {
    serde_json::to_string(&listing::read(text)).unwrap_or_default()
}

/// How far loads of this frequency, Hz, and damping swing, as JSON.
#[wasm_bindgen]
pub fn swings(program: &[u8], settings: &str, natural_hz: f64, damping_ratio: f64) -> Thrown<String> {
    let swings = ringing::swings(program, settings, natural_hz, damping_ratio).map_err(thrown)?;
    Ok(serde_json::to_string(&swings).unwrap_or_default())
}

/// Motion of the axes, as columns, each of which is asked for once: see `Motion`. A column of one number has it throughout.
#[wasm_bindgen(js_name = Motion)]
pub struct MotionColumns(Motion);

#[wasm_bindgen(js_class = Motion)]
impl MotionColumns {
    /// The number of phases.
    #[wasm_bindgen(getter)]
    pub fn phases(&self) -> usize {
        self.0.times_s.len() / 2
    }

    /// The number of axes.
    #[wasm_bindgen(getter)]
    pub fn axes(&self) -> usize {
        AXES
    }

    /// The end of the last phase, s.
    #[wasm_bindgen(getter)]
    pub fn end(&self) -> f64 {
        self.0.end_s()
    }

    /// The beginning of each phase, s.
    pub fn begins(&self) -> Vec<f64> {
        packed(self.0.begins_s())
    }

    /// The time from the phase before to each, s.
    pub fn pauses(&self) -> Vec<f64> {
        packed(self.0.pauses_s())
    }

    /// The kind of motion that each belongs to.
    pub fn kinds(&mut self) -> Vec<u8> {
        packed(std::mem::take(&mut self.0.kinds))
    }

    /// Place, speed or acceleration of an axis at its beginning.
    #[wasm_bindgen(js_name = ofAxis)]
    pub fn of_axis(&self, axis: usize, column: usize) -> Vec<f32> {
        packed(self.0.of_axis(axis, column))
    }

    /// How much larger the acceleration of an axis is at the end, mm/s².
    #[wasm_bindgen(js_name = changesOf)]
    pub fn changes_of(&self, axis: usize) -> Vec<f32> {
        packed(self.0.changes_of(axis))
    }

    /// Its acceleration, or the jump where it begins, in 256ths of their limits.
    pub fn loads(&self, load: usize) -> Vec<u16> {
        packed(self.0.loads_of(load))
    }

    /// The speed along the path that each would have without ramps, mm/s.
    pub fn asked(&mut self) -> Vec<f32> {
        packed(std::mem::take(&mut self.0.asked_mm_s))
    }

    /// The instants at which the tool's power changed, s.
    #[wasm_bindgen(js_name = powerTimes)]
    pub fn power_times(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.0.power.times_s)
    }

    /// To what, from 0 to 1.
    pub fn powers(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.0.power.shares)
    }
}

/// A program under way.
#[wasm_bindgen(js_name = Job)]
pub struct JobHandle {
    job: Option<Job>,
    motion: Motion,
    rows: Vec<u8>,
    lines: Lines,
}

#[wasm_bindgen(js_class = Job)]
impl JobHandle {
    /// A program for a machine with these settings. `kept` is `trace`, `waves`, `plan` or `lines`.
    #[wasm_bindgen(constructor)]
    pub fn new(program: &[u8], settings: &str, kept: &str) -> Thrown<Self> {
        let kept = match kept {
            "trace" => Kept::Trace,
            "waves" => Kept::Waves,
            "plan" => Kept::Plan,
            _ => Kept::Lines,
        };
        let job = Some(Job::new(program, settings, kept).map_err(thrown)?);
        Ok(Self { job, motion: Motion::default(), rows: Vec::new(), lines: Lines::default() })
    }

    /// Runs until this time, us, and returns whether it has ended.
    pub fn advance(&mut self, until_us: f64) -> Thrown<bool> {
        self.job.as_mut().map_or(Ok(true), |job| job.advance(until_us)).map_err(thrown)
    }

    /// Machine time, us.
    #[wasm_bindgen(getter, js_name = nowUs)]
    pub fn now_us(&self) -> f64 {
        self.job.as_ref().map_or(0.0, Job::now_us)
    }

    /// Lines answered.
    #[wasm_bindgen(getter)]
    pub fn answered(&self) -> usize {
        self.job.as_ref().map_or(0, Job::answered)
    }

    /// Lines of the program.
    #[wasm_bindgen(getter)]
    pub fn lines(&self) -> usize {
        self.job.as_ref().map_or(0, Job::lines)
    }

    /// The next whole piece of the motion of the axes, if there is one: see `piece`.
    #[wasm_bindgen(js_name = takePiece)]
    pub fn take_piece(&mut self) -> Option<MotionColumns> {
        self.job.as_mut().map_or_else(|| self.motion.take_piece(), Job::take_piece).map(MotionColumns)
    }

    /// After the end, behind all whole pieces: what is left of it.
    #[wasm_bindgen(js_name = takeRest)]
    pub fn take_rest(&mut self) -> MotionColumns {
        MotionColumns(self.motion.take())
    }

    /// The text since the last call.
    #[wasm_bindgen(js_name = takeRows)]
    pub fn take_rows(&mut self) -> Vec<u8> {
        let rest = std::mem::take(&mut self.rows);
        self.job.as_mut().map_or(rest, Job::take_rows)
    }

    /// Its end, as JSON. What is left of it can be taken after it.
    pub fn end(&mut self) -> Thrown<String> {
        let job = self.job.take().ok_or("the program has ended already")?;
        let end = job.end().map_err(thrown)?;
        (self.motion, self.rows, self.lines) = (end.motion, end.rows, end.lines);
        Ok(end.summary)
    }

    /// When each line began to move the machine, s, since the last call.
    #[wasm_bindgen(js_name = takeLineTimes)]
    pub fn take_line_times(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.lines_since().times_s)
    }

    /// Those lines, 0 for none.
    #[wasm_bindgen(js_name = takeLines)]
    pub fn take_lines(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.lines_since().lines)
    }

    fn lines_since(&mut self) -> &mut Lines {
        self.job.as_mut().map_or(&mut self.lines, Job::lines_since)
    }
}

/// A program under way for its time alone.
#[wasm_bindgen(js_name = Quick)]
pub struct QuickHandle(Quick);

#[wasm_bindgen(js_class = Quick)]
impl QuickHandle {
    /// A program for a machine with these settings.
    #[wasm_bindgen(constructor)]
    pub fn new(program: &[u8], settings: &str) -> Thrown<Self> {
        Quick::new(program, settings).map(Self).map_err(thrown)
    }

    /// Runs until this time, us, and returns whether it has ended.
    pub fn advance(&mut self, until_us: f64) -> Thrown<bool> {
        self.0.advance(until_us).map_err(thrown)
    }

    /// Lines answered.
    #[wasm_bindgen(getter)]
    pub fn answered(&self) -> usize {
        self.0.answered()
    }

    /// Lines of the program.
    #[wasm_bindgen(getter)]
    pub fn lines(&self) -> usize {
        self.0.lines()
    }

    /// Its end, as JSON.
    pub fn end(self) -> Thrown<String> {
        let found = self.0.end().map_err(thrown)?;
        Ok(serde_json::to_string(&found).unwrap_or_default())
    }
}

/// The plain lines of a program that computes or calls, as JSON.
#[wasm_bindgen(js_name = plainLines)]
pub fn plain_lines(program: &[u8]) -> Thrown<String> {
    whole::plain(program).map_err(thrown)
}

/// The findings of `isostep check`, as JSON.
#[wasm_bindgen]
pub fn check(program: &[u8], settings: &str) -> Thrown<String> {
    whole::check(program, settings).map_err(thrown)
}

/// The lines of a program that have M6, as JSON: which tool, and what the program says of it.
#[wasm_bindgen]
pub fn tools(program: &[u8]) -> Thrown<String> {
    whole::tools(program).map_err(thrown)
}

/// The speed profiles for a move, as JSON: distance, steps/mm, start and top speed, acceleration, deceleration and jerk.
#[wasm_bindgen(js_name = speedProfiles)]
pub fn speed_profiles(asked: &[f64]) -> Thrown<String> {
    let &[distance_mm, steps_per_mm, start_mm_s, top_mm_s, accel_mm_s2, decel_mm_s2, jerk_mm_s3] = asked else {
        return Err(format!("{} numbers, where a move has seven", asked.len()));
    };
    speed_profiles::of(&speed_profiles::Asked {
        distance_mm,
        steps_per_mm,
        start_mm_s,
        top_mm_s,
        accel_mm_s2,
        decel_mm_s2,
        jerk_mm_s3,
    })
    .map_err(thrown)
}

/// Every figure, as `isostep sim --json` writes them.
#[wasm_bindgen]
pub fn report(name: &str, program: &[u8], settings: &str) -> Thrown<String> {
    whole::report(name, program, settings).map_err(thrown)
}

/// A machine to operate.
#[wasm_bindgen(js_name = Live)]
pub struct LiveHandle(Live);

#[wasm_bindgen(js_class = Live)]
impl LiveHandle {
    /// A machine with these settings.
    #[wasm_bindgen(constructor)]
    pub fn new(settings: &str) -> Thrown<Self> {
        Live::new(settings).map(Self).map_err(thrown)
    }

    /// Sends bytes to its console.
    pub fn send(&mut self, bytes: &[u8]) {
        self.0.send(bytes);
    }

    /// The bytes from its console since the last call.
    #[wasm_bindgen(js_name = takeOutput)]
    pub fn take_output(&mut self) -> Vec<u8> {
        self.0.take_output()
    }

    /// Runs to this time, us.
    pub fn advance(&mut self, until_us: f64) -> Thrown<()> {
        self.0.advance(until_us).map_err(thrown)
    }

    /// Machine time, us.
    #[wasm_bindgen(getter, js_name = nowUs)]
    pub fn now_us(&self) -> f64 {
        self.0.now_us()
    }

    /// Forgets how the axes have moved.
    #[wasm_bindgen(js_name = forgetMotion)]
    pub fn forget_motion(&mut self) {
        self.0.take_motion();
    }

    /// Presses or releases the emergency stop.
    #[wasm_bindgen(js_name = setEmergencyStop)]
    pub fn set_emergency_stop(&mut self, is_pressed: bool) {
        self.0.set_emergency_stop(is_pressed);
    }

    /// Puts a plate under the tool, mm above the limit switch of Z, or takes it away.
    #[wasm_bindgen(js_name = setPlate)]
    pub fn set_plate(&mut self, place_mm: Option<f64>) {
        self.0.set_plate(place_mm);
    }

    /// Presses or releases a limit switch.
    #[wasm_bindgen(js_name = setLimit)]
    pub fn set_limit(&mut self, axis: usize, is_pressed: bool) {
        self.0.set_limit(axis, is_pressed);
    }

    /// The promises so far, as JSON.
    pub fn verdicts(&self) -> String {
        serde_json::to_string(&self.0.verdicts()).unwrap_or_default()
    }
}
