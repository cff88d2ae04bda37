//! Parses status reports.

use std::fmt;

/// The part of a status report that is shown all the time.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// The state with its number, such as Idle, Run, Alarm or Hold:0.
    pub state: String,
    /// The position of the machine in mm or inches, in machine or work coordinates, as the report gives it.
    pub place: [f64; 3],
}

impl Status {
    /// Parses `<Idle|MPos:0.000,0.000,0.000|...>`; `None` if the line is not such a report.
    pub fn read(line: &str) -> Option<Self> {
        let mut fields = line.strip_prefix('<')?.strip_suffix('>')?.split('|');
        let state = fields.next()?.to_owned();
        let places = fields.find_map(|field| field.strip_prefix("MPos:").or_else(|| field.strip_prefix("WPos:")))?;
        let mut places = places.split(',').map(str::parse);
        let mut next = || places.next()?.ok();
        Some(Self { state, place: [next()?, next()?, next()?] })
    }

    /// Whether the machine is moving and will come to rest by itself.
    pub fn is_moving(&self) -> bool {
        matches!(self.state.as_str(), "Run" | "Home" | "Jog")
    }

    /// Whether the machine stands still until somebody resumes it: after a hold, at M0 or M6, behind the safety door.
    pub fn is_held(&self) -> bool {
        matches!(self.state.as_str(), "Hold:0" | "Door:0" | "Door:1")
    }

    /// Whether the machine is locked, and refuses G-code.
    pub fn is_locked(&self) -> bool {
        self.state.starts_with("Alarm") || self.state == "Sleep"
    }
}

/// The text has the same width for any machine shorter than 100 m.
impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.place;
        write!(f, "{:<6} X{x:>9.3} Y{y:>9.3} Z{z:>9.3}", self.state)
    }
}

/// The width of the text.
pub const WIDTH: usize = 6 + 3 * 11;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read_and_shown_in_a_fixed_width() {
        let status = Status::read("<Hold:0|WPos:1.000,-20.500,300.000|FS:0,0>").unwrap();
        assert_eq!(status, Status { state: "Hold:0".into(), place: [1.0, -20.5, 300.0] });
        assert_eq!(status.to_string(), "Hold:0 X    1.000 Y  -20.500 Z  300.000");
        assert_eq!(status.to_string().len(), WIDTH);
        assert_eq!(Status { state: "Idle".into(), ..status }.to_string().len(), WIDTH);
    }

    #[test]
    fn other_lines_are_no_report() {
        for line in ["ok", "<Idle", "<Idle>", "<Idle|MPos:1,2>", "<Idle|MPos:a,b,c>", "[MSG:<Idle|MPos:1,2,3>]"] {
            assert_eq!(Status::read(line), None, "{line}");
        }
    }
}
