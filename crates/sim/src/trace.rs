//! Traces as CSV: one row per STEP rising edge, and one per change of the tool's outputs.

use std::io;

use isostep_motion::Axis;

use crate::record::Edge;
use crate::tool::{ToolChange, ToolOutput};

/// Duties are written in millionths.
const PARTS: f64 = 1e6;

/// Writes `t_ns,axis,direction,position_steps`: integer nanoseconds since power-up, `X|Y|Z`, `1|-1`, and the position
/// after the edge, counted from power-up or since the axis was homed.
///
/// # Errors
/// Those of `out`.
pub fn write(edges: &[Edge], out: impl io::Write) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(["t_ns", "axis", "direction", "position_steps"])?;
    for edge in edges {
        let axis = Axis::ALL[edge.axis].to_string();
        csv.serialize((edge.t_ns, axis, edge.direction, edge.position_steps))?;
    }
    csv.flush()
}

/// Writes `t_ns,output,value`: integer nanoseconds since power-up, `pwm|enable|direction|flood|mist`, and the value.
/// For PWM this is the duty as a fraction with up to six decimals, otherwise 1 for on and 0 for off. All are 0 before
/// their first row.
///
/// # Errors
/// Those of `out`.
pub fn write_tool(changes: &[ToolChange], out: impl io::Write) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(["t_ns", "output", "value"])?;
    for change in changes {
        csv.write_record([change.t_ns.to_string(), change.output.to_string(), value(*change)])?;
    }
    csv.flush()
}

fn value(change: ToolChange) -> String {
    match change.output {
        // The shortest text of the rounded value, without digits that are not significant.
        ToolOutput::Pwm => ((change.duty_ratio() * PARTS).round() / PARTS).to_string(),
        _ => u8::from(change.duty > 0).to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_as_other_tools_read_them() {
        let edges = [
            Edge { t_ns: 1_500_000, axis: 0, direction: 1, position_steps: 1 },
            Edge { t_ns: 1_502_000, axis: 2, direction: -1, position_steps: -7 },
        ];
        let mut out = Vec::new();
        write(&edges, &mut out).unwrap();
        let expected = "t_ns,axis,direction,position_steps\n1500000,X,1,1\n1502000,Z,-1,-7\n";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }

    /// The emulated board writes the same format, and its rows are compared with these.
    #[test]
    fn rows_come_back_as_they_were() {
        let change = |t_ns, output, duty| ToolChange { t_ns, output, duty };
        let changes = [
            change(1_500, ToolOutput::Enable, u16::MAX),
            change(1_500, ToolOutput::Pwm, 32_768),
            change(2_500, ToolOutput::Pwm, 1),
            change(2_750, ToolOutput::Pwm, u16::MAX),
            change(3_000_000_000, ToolOutput::Pwm, 0),
            change(3_000_000_001, ToolOutput::Mist, u16::MAX),
            change(3_000_000_001, ToolOutput::Direction, 0),
        ];
        let mut out = Vec::new();
        write_tool(&changes, &mut out).unwrap();
        let expected = "t_ns,output,value\n1500,enable,1\n1500,pwm,0.500008\n2500,pwm,0.000015\n2750,pwm,1\n\
                        3000000000,pwm,0\n3000000001,mist,1\n3000000001,direction,0\n";
        assert_eq!(String::from_utf8(out.clone()).unwrap(), expected);
        let mut reader = csv::Reader::from_reader(&out[..]);
        let read = reader.deserialize().map(|row| row.unwrap());
        let back: Vec<ToolChange> = read
            .map(|(t_ns, name, duty_ratio): (u64, String, f64)| {
                let output = ToolOutput::ALL.into_iter().find(|output| output.to_string() == name).unwrap();
                change(t_ns, output, (duty_ratio * f64::from(u16::MAX)).round() as u16)
            })
            .collect();
        assert_eq!(back, changes);
    }
}
