//! Replays what ioSender and gSender do when a tool is changed in a program, by their sources. Each streams
//! programs/two_tools.nc without its `$H`, and what it sends by hand or by itself in between is answered line by line.

use std::fs;

use embassy_time::Duration;
use isostep_console::Settings;
use isostep_sim::{Config, Sim};
use isostep_tests::root;

use crate::talk::{field, homed, powered_up, report, say};

/// The lines of the program as they are when the machine has been homed before.
fn program() -> Vec<String> {
    let text = fs::read_to_string(root().join("programs/two_tools.nc")).unwrap();
    text.lines().filter(|line| !line.starts_with('$')).map(str::to_owned).collect()
}

/// Puts a plate below, which a tool touches with Z at `contact_mm`, `$27` being 2 mm. Below zero the switch is at the top.
fn touch_at(sim: &mut Sim, contact_mm: f64) {
    let side = if contact_mm < 0.0 { "above" } else { "below" };
    sim.set_plate(Some(format!("Z,{},{side}", contact_mm.abs() + 2.0).parse().unwrap()));
}

/// Sends a line, which must be answered by one `ok` and nothing that tells of a fault.
#[track_caller]
fn accepted(sim: &mut Sim, line: &str) -> Vec<String> {
    let heard = say(sim, line);
    let oks = heard.iter().filter(|each| *each == "ok").count();
    assert!(oks == 1 && !heard.iter().any(|each| each.contains(':') && !each.starts_with('[')), "{line}: {heard:?}");
    heard.to_vec()
}

/// The machine position in the next status report, mm.
#[track_caller]
fn position_mm(sim: &mut Sim) -> [f64; 3] {
    let report = report(sim);
    coordinates(report.split("MPos:").nth(1).unwrap())
}

fn coordinates(text: &str) -> [f64; 3] {
    let mut values = text.split(['|', '>']).next().unwrap().split(',').map(|value| value.parse().unwrap());
    std::array::from_fn(|_| values.next().unwrap())
}

/// The work position, as senders compute it.
#[track_caller]
fn work_mm(sim: &mut Sim) -> [f64; 3] {
    let (at, zero) = (position_mm(sim), coordinates(&field(sim, "WCO")));
    std::array::from_fn(|axis| at[axis] - zero[axis])
}

/// ioSender in a job: it counts characters up to nine tenths of the buffer, and polls. From the first report of `Tool` on
/// it counts no `ok` as one of the job's lines, until a report says that the machine runs again or is idle.
struct IoSender<'a> {
    sim: &'a mut Sim,
    lines: Vec<String>,
    poll: Duration,
    sent: usize,
    answered: usize,
    is_counting: bool,
    state: String,
}

/// Nine tenths of 128.
const IO_SENDER_WINDOW: usize = 115;
const STATUS: &[u8] = &[0x80];
const RESUME: &[u8] = &[0x81];
const TOOL_ACKNOWLEDGED: &[u8] = &[0xA3];

impl<'a> IoSender<'a> {
    /// A line with nothing but a comment is sent as an empty one.
    fn new(sim: &'a mut Sim, lines: Vec<String>, poll_ms: u64) -> Self {
        let sent_as = |line: String| if line.starts_with(['(', ';']) { "()".to_owned() } else { line };
        let lines = lines.into_iter().map(sent_as).collect();
        let (poll, state) = (Duration::from_millis(poll_ms), "Idle".to_owned());
        Self { sim, lines, poll, sent: 0, answered: 0, is_counting: true, state }
    }

    /// Streams the job to its end. `change` is called in each change of the tool, with the line that asks for it.
    fn run(&mut self, mut change: impl FnMut(&mut Sim, &str)) {
        for _ in 0..10_000 {
            self.send_more();
            self.sim.run_for(self.poll).unwrap();
            self.hears(STATUS, &mut change);
            if self.answered == self.lines.len() && self.state == "Idle" {
                return;
            }
        }
        panic!("{} of {} lines answered in {}: {}", self.answered, self.lines.len(), self.state, report(self.sim));
    }

    fn send_more(&mut self) {
        while let Some(line) = self.lines.get(self.sent) {
            let unanswered: usize = self.lines[self.answered..self.sent].iter().map(|line| line.len() + 1).sum();
            if !self.is_counting || unanswered >= IO_SENDER_WINDOW - (line.len() + 1) {
                return;
            }
            self.sim.send(format!("{line}\r").as_bytes());
            self.sent += 1;
        }
    }

    fn heard(&mut self, sent: &[u8]) -> Vec<String> {
        self.sim.send(sent);
        self.sim.run_for(Duration::from_millis(1)).unwrap();
        self.sim.replies()
    }

    /// Sends a byte and takes what is heard, in its order.
    fn hears(&mut self, sent: &[u8], change: &mut impl FnMut(&mut Sim, &str)) {
        for line in self.heard(sent) {
            if line == "ok" {
                self.answered += usize::from(self.is_counting);
            } else if let Some(state) = line.strip_prefix('<') {
                self.enters(state.split('|').next().unwrap(), change);
            } else {
                assert!(line.starts_with("[MSG:M6: put in tool") || line == "[MSG:Pgm End]", "{line}");
            }
        }
    }

    fn enters(&mut self, state: &str, change: &mut impl FnMut(&mut Sim, &str)) {
        let before = std::mem::replace(&mut self.state, state.to_owned());
        if state == "Tool" && before != "Tool" {
            self.is_counting = false;
            assert_eq!(self.heard(TOOL_ACKNOWLEDGED), [""; 0]);
            change(self.sim, &self.lines[self.answered - 1]);
            self.hears(RESUME, change);
        } else if state == "Run" || state == "Idle" {
            self.is_counting = true;
        }
    }
}

/// `$341=1`. The first tool becomes the reference by ioSender's page for probing, before the job. In the job it lets nobody
/// send anything but jogs, `$TPW` and `G10L20`.
#[test]
fn io_sender_measures_each_tool_by_tpw() {
    for poll_ms in [100, 200, 400] {
        let mut sim = homed();
        accepted(&mut sim, "$341=1");
        accepted(&mut sim, "G53G0Z30");
        touch_at(&mut sim, 10.0);
        for line in ["G91F100", "G38.3F100Z-25", "G0Z1", "G38.3F25Z-2", "G49", "G53G0Z30.000", "$TLR", "G90"] {
            accepted(&mut sim, line);
        }
        assert!(field(&mut sim, "WCO").ends_with(",0.000"));
        let mut changed = Vec::new();
        let mut sender = IoSender::new(&mut sim, program(), poll_ms);
        sender.run(|sim, line| {
            // The second tool reaches 4 mm farther.
            let length_mm = if line.starts_with("T2") { 4.0 } else { 0.0 };
            touch_at(sim, 10.0 + length_mm);
            changed.push(line.to_owned());
            accepted(sim, "$J=G91G21X5.000F2400");
            accepted(sim, "$J=G91G21Z-65.000F2400");
            let heard = accepted(sim, "$TPW");
            assert!(heard.contains(&format!("[MSG:The length of this tool is {length_mm:.3}]")), "{heard:?}");
        });
        assert_eq!(changed, ["T1 M6 (3 mm drill)", "T2 M6 (6 mm flat end mill)"]);
        assert_eq!(position_mm(&mut sim), [20.0, 20.0, 29.0], "polled every {poll_ms} ms");
        assert_eq!(sim.outcome().drift_steps, [0; 3]);
    }
}

/// The same without a probe: Z is set for each tool where it touches the work.
#[test]
fn io_sender_sets_z_for_each_tool() {
    for poll_ms in [100, 200, 400] {
        let mut sim = homed();
        accepted(&mut sim, "$341=1");
        let mut sender = IoSender::new(&mut sim, program(), poll_ms);
        sender.run(|sim, line| {
            accepted(sim, if line.starts_with("T1") { "$J=G91G21Z-70.000F2400" } else { "$J=G91G21Z-66.000F2400" });
            accepted(sim, "G10L20P0Z0.000");
        });
        assert_eq!(position_mm(&mut sim), [20.0, 20.0, 39.0], "polled every {poll_ms} ms");
        assert_eq!(sim.outcome().drift_steps, [0; 3]);
    }
}

/// A way back of no length leaves no time to poll: the lines that wait are answered at once, and a report comes before.
#[test]
fn io_sender_misses_no_answer_where_there_is_no_way_back() {
    let mut sim = homed();
    accepted(&mut sim, "$341=1");
    let lines = ["G53 G0 Z100", "T1 M6", "G21", "G90", "G0 X5", "G0 X10", "G4 P0.1"].map(str::to_owned).to_vec();
    let mut sender = IoSender::new(&mut sim, lines, 200);
    sender.run(|sim, _| {
        accepted(sim, "G10L20P0Z0.000");
    });
    assert_eq!(position_mm(&mut sim), [10.0, 0.0, 100.0]);
}

/// gSender in a job: it takes M6 and comments out, counts characters up to 100, and stops behind M6 until the machine is
/// idle. `change` then does what the person is led through. The program's lines are all answered by `ok`.
fn gsender_streams(sim: &mut Sim, lines: &[String], mut change: impl FnMut(&mut Sim, usize)) {
    let mut changes = 0;
    let mut in_flight = Vec::new();
    for line in lines {
        let line = line.split(['(', ';']).next().unwrap().trim();
        let (asks, line) = (line.contains("M6"), line.replace("M6", ""));
        if line.is_empty() {
            continue;
        }
        while in_flight.iter().sum::<usize>() + line.len() + 1 > 100 {
            sim.run_for(Duration::from_millis(50)).unwrap();
            let heard = sim.replies();
            assert!(heard.iter().all(|each| each == "ok"), "{heard:?}");
            in_flight.drain(..heard.len());
        }
        sim.send(format!("{line}\n").as_bytes());
        in_flight.push(line.len() + 1);
        if asks {
            sim.run_until_idle().unwrap();
            assert_eq!(sim.replies(), vec!["ok"; in_flight.len()]);
            in_flight.clear();
            changes += 1;
            change(sim, changes);
        }
    }
    sim.run_until_idle().unwrap();
    let mut heard = sim.replies();
    heard.retain(|each| each != "[MSG:Pgm End]");
    assert_eq!((heard, changes), (vec!["ok".to_owned(); in_flight.len()], 2));
}

/// Sends lines one by one, each when the one before is answered, as gSender does outside of a job.
#[track_caller]
fn all_accepted<const N: usize>(sim: &mut Sim, lines: [&str; N]) {
    for line in lines {
        accepted(sim, line);
    }
}

/// How far a probing move at 75 mm/min goes on behind the contact, at most, mm: gSender sets Z there.
const BEHIND_CONTACT_MM: f64 = 0.061;

#[track_caller]
fn ends_at(sim: &mut Sim, wanted_mm: [f64; 3], tolerance_mm: f64) {
    let at = position_mm(sim);
    let is_there = at.iter().zip(wanted_mm).all(|(at, wanted)| (at - wanted).abs() <= tolerance_mm);
    assert!(is_there, "at {at:?}, where {wanted_mm:?} was expected");
    assert!(report(sim).starts_with("<Idle|"));
    assert_eq!(sim.outcome().drift_steps, [0; 3]);
}

/// Its strategy "Standard Re-zero" with a touch plate 15 mm thick. `$341` does not matter, as M6 never comes.
#[test]
fn gsender_sets_zero_again_for_each_tool() {
    let mut sim = homed();
    accepted(&mut sim, "G53 G0 Z60");
    gsender_streams(&mut sim, &program(), |sim, count| {
        touch_at(sim, if count == 1 { 35.0 } else { 39.0 });
        accepted(sim, "G4 P0.5");
        let [x, y, z] = work_mm(sim);
        all_accepted(sim, ["M5", "G91 G21", ""]);
        accepted(sim, if count == 1 { "$J=G21G91 X3 Z-10 F2400" } else { "$J=G21G91 X3 Z20 F2400" });
        all_accepted(sim, ["", "G91", "G38.2 Z-30 F150", "G0 Z4", "G38.2 Z-10 F75", "G4 P0.5", "G10 L20 P0 Z15"]);
        all_accepted(sim, ["G0 G21 Z10", "", "G21"]);
        accepted(sim, &format!("G90 G21 G0 X{x:.3} Y{y:.3}"));
        accepted(sim, &format!("G90 G21 G0 Z{z:.3}"));
        all_accepted(sim, ["", if count == 1 { "M5 G21 G90 F0" } else { "M5 G21 G90 F600" }, "G4 P0.5"]);
    });
    ends_at(&mut sim, [20.0, 20.0, 29.0], BEHIND_CONTACT_MM);
}

/// Its strategy "Fixed Tool Sensor", on a machine whose Z is at zero at the top, as it takes for granted.
#[test]
fn gsender_compares_each_tool_at_its_sensor() {
    let settings = Settings { homing_direction_mask: 3, ..Settings::default() };
    let mut sim = powered_up(&Config { settings, ..Config::default() });
    accepted(&mut sim, "$H");
    accepted(&mut sim, "G53 G0 Z-10");
    let lines: Vec<_> = program().into_iter().map(|line| line.replace("Y20 Z20", "Y20 Z-60")).collect();
    let mut tool_offset_mm = 0.0;
    gsender_streams(&mut sim, &lines, |sim, count| {
        accepted(sim, "G4 P0.5");
        all_accepted(sim, ["", "M5 S0", "G4 P0.5"]);
        let [x, y, z] = work_mm(sim);
        all_accepted(sim, ["G91 G21", "G53 G0 Z-5", ""]);
        let probe = ["G38.2 Z-78.000 F150", "G0 Z4"];
        if count == 1 {
            touch_at(sim, -84.0);
            all_accepted(sim, ["G91 G21", "G53 G0 Z-5", "G53 G0 X5 Y5", "G53 G0 Z-20"]);
            all_accepted(sim, probe);
            all_accepted(sim, ["G38.2 Z-10 F75", "G4 P0.3"]);
            tool_offset_mm = work_mm(sim)[2];
            all_accepted(sim, ["", "G0 Z4", "G90 G21", "G53 G0 Z-5"]);
        }
        // The tool that is put in reaches 4 mm farther, if it is the second one.
        touch_at(sim, if count == 1 { -84.0 } else { -80.0 });
        all_accepted(sim, ["", "G90 G53 G0 Z-5", "G90 G53 G0 X5 Y5", "G53 G0 Z-20", "G91 G21"]);
        all_accepted(sim, probe);
        all_accepted(sim, ["G38.2 Z-15 F75", "", "G4 P0.3"]);
        accepted(sim, &format!("G10 L20 P0 Z{tool_offset_mm:.3}"));
        all_accepted(sim, ["G0 Z4", "G53 G21 G0 Z-5", "G21 G91"]);
        all_accepted(sim, ["", "", "M5 S0", "", "G53 G0 Z-5"]);
        accepted(sim, &format!("G90 G0 X{x:.3} Y{y:.3}"));
        accepted(sim, &format!("G90 G0 Z{z:.3}"));
        all_accepted(sim, ["", "G21 G90 F600", "G4 P0.5", "G4 P0.5"]);
    });
    // Both stops behind the contact are as far, to a step.
    ends_at(&mut sim, [20.0, 20.0, -51.0], 0.041);
}
