//! Waveforms of every wire as a Value Change Dump, for GTKWave, Surfer or PulseView.

use std::collections::BTreeMap;
use std::io;

use isostep_motion::{AXES, Axis, Motor};
use vcd::{IdCode, SimulationCommand, TimescaleUnit, VarType, Writer};

use crate::record::{Wave, Wire};
use crate::tool::{ToolChange, ToolOutput};

/// A signal of a dump.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Signal {
    Wire(Wire),
    Tool(ToolOutput),
}

/// A change of a signal.
#[derive(Clone, Copy)]
enum Change {
    Wire(Wave),
    Tool(ToolChange),
}

/// Writes `waves` and the changes of the `tool` since power-up, both in order. `limits_high` are the initial levels of
/// the limit switches. The tool is off initially. The duty of PWM is a real number from 0 to 1.
///
/// # Errors
/// Those of `out`.
pub fn write(waves: &[Wave], tool: &[ToolChange], limits_high: [bool; AXES], out: impl io::Write) -> io::Result<()> {
    let mut vcd = Writer::new(out);
    vcd.timescale(1, TimescaleUnit::NS)?;
    vcd.add_module("isostep")?;
    let mut ids = BTreeMap::new();
    for (wire, name, _) in wires(limits_high, waves) {
        ids.insert(Signal::Wire(wire), vcd.add_wire(1, &name)?);
    }
    for output in ToolOutput::ALL {
        let (kind, bits) = if output == ToolOutput::Pwm { (VarType::Real, 64) } else { (VarType::Wire, 1) };
        ids.insert(Signal::Tool(output), vcd.add_var(kind, bits, &format!("tool_{output}"), None)?);
    }
    vcd.upscope()?;
    vcd.enddefinitions()?;
    vcd.begin(SimulationCommand::Dumpvars)?;
    for (wire, _, high) in wires(limits_high, waves) {
        vcd.change_scalar(ids[&Signal::Wire(wire)], high)?;
    }
    for output in ToolOutput::ALL {
        set_tool(ToolChange { t_ns: 0, output, duty: 0 }, &ids, &mut vcd)?;
    }
    vcd.end()?;
    changes(waves, tool, &ids, &mut vcd)?;
    vcd.flush()
}

type Ids = BTreeMap<Signal, IdCode>;

fn changes(waves: &[Wave], tool: &[ToolChange], ids: &Ids, vcd: &mut Writer<impl io::Write>) -> io::Result<()> {
    let mut last_ns = None;
    for change in merged(waves, tool) {
        let t_ns = change.t_ns();
        if last_ns != Some(t_ns) {
            vcd.timestamp(t_ns)?;
            last_ns = Some(t_ns);
        }
        match change {
            Change::Wire(wave) => vcd.change_scalar(ids[&Signal::Wire(wave.wire)], wave.high)?,
            Change::Tool(change) => set_tool(change, ids, vcd)?,
        }
    }
    Ok(())
}

fn set_tool(change: ToolChange, ids: &Ids, vcd: &mut Writer<impl io::Write>) -> io::Result<()> {
    let id = ids[&Signal::Tool(change.output)];
    match change.output {
        ToolOutput::Pwm => vcd.change_real(id, change.duty_ratio()),
        _ => vcd.change_scalar(id, change.duty > 0),
    }
}

/// All changes of both in order of time.
fn merged(waves: &[Wave], tool: &[ToolChange]) -> impl Iterator<Item = Change> {
    let mut waves = waves.iter().copied().peekable();
    let mut tool = tool.iter().copied().peekable();
    std::iter::from_fn(move || {
        let next_ns = waves.peek().map_or(u64::MAX, |wave| wave.t_ns);
        let change = tool.next_if(|change| change.t_ns < next_ns).map(Change::Tool);
        change.or_else(|| waves.next().map(Change::Wire)).or_else(|| tool.next().map(Change::Tool))
    })
}

impl Change {
    fn t_ns(&self) -> u64 {
        match self {
            Self::Wire(wave) => wave.t_ns,
            Self::Tool(change) => change.t_ns,
        }
    }
}

/// Every wire with its name and its level at power-up.
fn wires(limits_high: [bool; AXES], waves: &[Wave]) -> Vec<(Wire, String, bool)> {
    let mut wires = of_some_machines(waves);
    for axis in Axis::ALL {
        let motor = Motor::first(axis);
        wires.push((Wire::Step(motor), format!("step_{motor}"), false));
        wires.push((Wire::Dir(motor), format!("dir_{motor}"), false));
        wires.push((Wire::Limit(motor), format!("limit_{motor}_n"), limits_high[axis as usize]));
    }
    wires.push((Wire::Enable, "enable_n".to_owned(), true));
    wires.push((Wire::EmergencyStop, "emergency_stop_n".to_owned(), true));
    wires.push((Wire::Probe, "probe_n".to_owned(), true));
    wires.push((Wire::Hold, "hold_n".to_owned(), true));
    wires.push((Wire::Start, "start_n".to_owned(), true));
    wires
}

/// The wires of a second motor and the alarms of drives that have changed. Before its first change a level was the other one.
fn of_some_machines(waves: &[Wave]) -> Vec<(Wire, String, bool)> {
    let of_axis = |axis: Axis| {
        let motor = Motor::second(axis);
        [
            (Wire::Step(motor), format!("step_{motor}")),
            (Wire::Dir(motor), format!("dir_{motor}")),
            (Wire::Limit(motor), format!("limit_{motor}_n")),
            (Wire::DriveAlarm(axis), format!("drive_alarm_{axis}_n")),
        ]
    };
    let before = |wire: Wire| waves.iter().find(|wave| wave.wire == wire).map(|first| !first.high);
    let all = Axis::ALL.into_iter().flat_map(of_axis);
    all.filter_map(|(wire, name)| Some((wire, name, before(wire)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_come_back_out_of_a_parser() {
        let wave = |t_ns, wire, high| Wave { t_ns, wire, high };
        let waves = [
            wave(0, Wire::Dir(Axis::Y.into()), true),
            wave(5_000, Wire::Step(Axis::Y.into()), true),
            wave(5_000, Wire::Limit(Axis::Y.into()), false),
            wave(8_000, Wire::Step(Axis::Y.into()), false),
        ];
        let change = |t_ns, output, duty| ToolChange { t_ns, output, duty };
        let tool = [
            change(5_000, ToolOutput::Enable, u16::MAX),
            change(6_000, ToolOutput::Pwm, 13_107),
            change(9_000, ToolOutput::Pwm, 0),
        ];
        let mut out = Vec::new();
        write(&waves, &tool, [true; 3], &mut out).unwrap();
        let mut parser = vcd::Parser::new(&out[..]);
        let header = parser.parse_header().unwrap();
        let code = |name: &str| header.find_var(&["isostep", name]).unwrap().code;
        let (step, enable, pwm) = (code("step_Y"), code("tool_enable"), code("tool_pwm"));
        let mut now = 0;
        let (mut steps, mut enables, mut duties) = (Vec::new(), Vec::new(), Vec::new());
        for command in parser.map(Result::unwrap) {
            match command {
                vcd::Command::Timestamp(at) => {
                    assert!(at >= now);
                    now = at;
                }
                vcd::Command::ChangeScalar(id, value) if id == step => steps.push((now, value)),
                vcd::Command::ChangeScalar(id, value) if id == enable => enables.push((now, value)),
                vcd::Command::ChangeReal(id, value) if id == pwm => duties.push((now, value)),
                _ => {}
            }
        }
        assert_eq!(steps, [(0, vcd::Value::V0), (5_000, vcd::Value::V1), (8_000, vcd::Value::V0)]);
        assert_eq!(enables, [(0, vcd::Value::V0), (5_000, vcd::Value::V1)]);
        assert_eq!(duties, [(0, 0.0), (6_000, 0.2), (9_000, 0.0)]);
    }
}
