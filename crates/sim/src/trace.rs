//! The step trace: one row of CSV per STEP rising edge.

use std::io;

use isostep_motion::Axis;

use crate::record::Edge;

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
}
