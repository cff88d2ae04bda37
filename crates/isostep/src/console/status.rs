//! Parses status reports.

use std::fmt;

use isostep_console::AXES;

/// The part of a status report that is shown all the time.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// The state with its number, such as Idle, Run, Alarm or Hold:0.
    pub state: String,
    /// The position of the machine in mm or inches, in machine or work coordinates, as the report gives it: of
    /// three axes, or of four.
    pub place: Vec<f64>,
}

impl Status {
    /// Parses `<Idle|MPos:0.000,0.000,0.000|...>`; `None` if the line is not such a report.
    pub fn read(line: &str) -> Option<Self> {
        let mut fields = line.strip_prefix('<')?.strip_suffix('>')?.split('|');
        let state = fields.next()?.to_owned();
        let places = fields.find_map(|field| field.strip_prefix("MPos:").or_else(|| field.strip_prefix("WPos:")))?;
        let place: Vec<_> = places.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        matches!(place.len(), 3 | 4).then_some(Self { state, place })
    }

    /// The machine is moving and will come to rest by itself.
    pub fn is_moving(&self) -> bool {
        matches!(self.state.as_str(), "Run" | "Home" | "Jog")
    }

    /// The program goes on when somebody resumes it: after a hold, at M0 or M6, in a change of the tool, behind the safety door.
    pub fn is_held(&self) -> bool {
        self.is_tool() || matches!(self.state.as_str(), "Hold:0" | "Door:0" | "Door:1")
    }

    /// In a change of the tool, and not in a jog or a hold in it.
    pub fn is_tool(&self) -> bool {
        self.state == "Tool"
    }

    /// A change of the tool is under way behind a report of one: jogs and holds may be in it.
    pub fn goes_on_changing(&self) -> bool {
        let name = self.state.split(':').next().unwrap_or_default();
        matches!(name, "Tool" | "Jog" | "Hold" | "Door")
    }

    /// The machine is locked, and refuses G-code.
    pub fn is_locked(&self) -> bool {
        self.state.starts_with("Alarm") || self.state == "Sleep"
    }
}

/// The text has the same width for any machine shorter than 100 m.
impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<6}", self.state)?;
        "XYZA".chars().zip(&self.place).try_for_each(|(name, place)| write!(f, " {name}{place:>9.3}"))
    }
}

/// The width of the text.
pub const WIDTH: usize = 6 + AXES * 11;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read_and_shown_in_a_fixed_width() {
        let status = Status::read("<Hold:0|WPos:1.000,-20.500,300.000|FS:0,0>").unwrap();
        assert_eq!(status, Status { state: "Hold:0".into(), place: vec![1.0, -20.5, 300.0] });
        assert_eq!(status.to_string(), "Hold:0 X    1.000 Y  -20.500 Z  300.000");
        let four = Status::read("<Idle|MPos:1.000,-20.500,300.000,-7.25|FS:0,0>").unwrap();
        assert_eq!(four.to_string(), "Idle   X    1.000 Y  -20.500 Z  300.000 A   -7.250");
        let longest = if AXES == 4 { four.to_string() } else { status.to_string() };
        assert_eq!(longest.len(), WIDTH);
        assert_eq!(Status { state: "Idle".into(), ..status.clone() }.to_string().len(), status.to_string().len());
    }

    #[test]
    fn a_change_of_the_tool_waits_and_goes_on_through_jogs_and_holds() {
        let status = |state: &str| Status { state: state.into(), place: vec![0.0; 3] };
        assert!(status("Tool").is_held() && status("Tool").is_tool() && !status("Tool").is_moving());
        assert!(["Tool", "Jog", "Hold:1", "Door:0"].iter().all(|state| status(state).goes_on_changing()));
        assert!(!["Run", "Idle", "Alarm", "Home"].iter().any(|state| status(state).goes_on_changing()));
    }

    #[test]
    fn other_lines_are_no_report() {
        for line in [
            "ok",
            "<Idle",
            "<Idle>",
            "<Idle|MPos:1,2>",
            "<Idle|MPos:1,2,3,4,5>",
            "<Idle|MPos:a,b,c>",
            "[MSG:<Idle|MPos:1,2,3>]",
        ] {
            assert_eq!(Status::read(line), None, "{line}");
        }
    }
}
