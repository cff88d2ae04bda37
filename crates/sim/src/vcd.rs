//! Waveforms of every wire as a Value Change Dump, for GTKWave, Surfer or PulseView.

use std::collections::BTreeMap;
use std::io;

use isostep_motion::Axis;
use vcd::{IdCode, SimulationCommand, TimescaleUnit, Writer};

use crate::record::{Wave, Wire};

/// Writes `waves` from power-up on; the limit switches start as `limits_high` says.
///
/// # Errors
/// Those of `out`.
pub fn write(waves: &[Wave], limits_high: [bool; 3], out: impl io::Write) -> io::Result<()> {
    let mut vcd = Writer::new(out);
    vcd.timescale(1, TimescaleUnit::NS)?;
    vcd.add_module("isostep")?;
    let mut ids = BTreeMap::new();
    for (wire, name, _) in wires(limits_high) {
        ids.insert(wire, vcd.add_wire(1, &name)?);
    }
    vcd.upscope()?;
    vcd.enddefinitions()?;
    vcd.begin(SimulationCommand::Dumpvars)?;
    for (wire, _, high) in wires(limits_high) {
        vcd.change_scalar(ids[&wire], high)?;
    }
    vcd.end()?;
    changes(waves, &ids, &mut vcd)?;
    vcd.flush()
}

fn changes(waves: &[Wave], ids: &BTreeMap<Wire, IdCode>, vcd: &mut Writer<impl io::Write>) -> io::Result<()> {
    let mut last_ns = None;
    for wave in waves {
        if last_ns != Some(wave.t_ns) {
            vcd.timestamp(wave.t_ns)?;
            last_ns = Some(wave.t_ns);
        }
        vcd.change_scalar(ids[&wave.wire], wave.high)?;
    }
    Ok(())
}

/// Every wire with its name and its level at power-up.
fn wires(limits_high: [bool; 3]) -> Vec<(Wire, String, bool)> {
    let mut wires = Vec::new();
    for axis in Axis::ALL {
        wires.push((Wire::Step(axis), format!("step_{axis}"), false));
        wires.push((Wire::Dir(axis), format!("dir_{axis}"), false));
        wires.push((Wire::Limit(axis), format!("limit_{axis}_n"), limits_high[axis as usize]));
    }
    wires.push((Wire::Enable, "enable_n".to_owned(), true));
    wires.push((Wire::EmergencyStop, "emergency_stop_n".to_owned(), true));
    wires.push((Wire::Probe, "probe_n".to_owned(), true));
    wires.push((Wire::Hold, "hold_n".to_owned(), true));
    wires.push((Wire::Start, "start_n".to_owned(), true));
    wires
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_come_back_out_of_a_parser() {
        let wave = |t_ns, wire, high| Wave { t_ns, wire, high };
        let waves = [
            wave(0, Wire::Dir(Axis::Y), true),
            wave(5_000, Wire::Step(Axis::Y), true),
            wave(5_000, Wire::Limit(Axis::Y), false),
            wave(8_000, Wire::Step(Axis::Y), false),
        ];
        let mut out = Vec::new();
        write(&waves, [true; 3], &mut out).unwrap();
        let mut parser = vcd::Parser::new(&out[..]);
        let header = parser.parse_header().unwrap();
        let step = header.find_var(&["isostep", "step_Y"]).unwrap().code;
        let mut now = 0;
        let mut seen = Vec::new();
        for command in parser.map(Result::unwrap) {
            match command {
                vcd::Command::Timestamp(at) => now = at,
                vcd::Command::ChangeScalar(id, value) if id == step => seen.push((now, value)),
                _ => {}
            }
        }
        assert_eq!(seen, [(0, vcd::Value::V0), (5_000, vcd::Value::V1), (8_000, vcd::Value::V0)]);
    }
}
