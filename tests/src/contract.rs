//! The position contract: for every way in which a motion ends, what is left of the position, and what clears it.
//!
//! One list of cases, as rows of `docs/position.md`. Each is a script that a simulated machine and the firmware on the emulated
//! board carry out alike: see [`crate::script_runner`].

use std::fmt::Write as _;
use std::iter;

use isostep_sim::Port;

/// What the tool's outputs are when the motion has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outputs {
    /// As they were.
    Stay,
    /// Off, and on again when the motion goes on.
    Paused,
    /// Off.
    Off,
}

/// The count of steps when the motion has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// Of the edges that left.
    Exact,
    /// It has begun anew, at 0.
    Zero,
}

/// Which machines know this way to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    /// All.
    Every,
    /// The emulated board alone.
    Board,
    /// The emulated board that steps by this port.
    BoardBy(Port),
}

/// A way in which a motion ends.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its row in the table.
    pub name: &'static str,
    /// Which machines know it.
    pub on: On,
    /// How it is brought about: from rest, with X homed, M3 and M8.
    pub happens: &'static str,
    /// The count.
    pub count: Count,
    /// What is homed stays homed.
    pub trusted: bool,
    /// What a status report calls the state.
    pub state: &'static str,
    /// What leads from there to Idle.
    pub cleared: &'static str,
    /// The tool.
    pub outputs: Outputs,
    /// The motors are energised.
    pub motors: bool,
}

/// What lines of the scripts in capitals stand for.
fn meaning(word: &str) -> Option<String> {
    let lines = match word {
        // A move of half a second, a fifth of a second after its line.
        "UNDER_WAY" => "send G91G1X20F3000\nexpect ok\nwait-ms 200\n",
        "AWAY" => "send G91G0X5\nexpect ok\nwait-idle\n",
        // The seek, which takes longer.
        "HOMING" => "send $HX\nwait-ms 50\n",
        "RELEASE_ESTOP" => "send $X\nexpect error:9\nestop released\nwait-ms 5\n",
        "RELEASE_SWITCH" => "switch X normal\nwait-ms 5\n",
        "UNLOCK" => "send $X\nexpect ok\n",
        // More steps than the processor makes one by one.
        "TOO_FAST" => return Some(set(&[(110, 120_000), (120, 20_000)])),
        // A curved ramp so steep that it cannot be compiled fast enough.
        "TOO_STEEP" => return Some(set(&[(100, 1_000), (110, 14_880), (120, 100_000)]) + "send $940=2\nexpect ok\n"),
        "GENTLE" => return Some("send $940=0\nexpect ok\n".to_owned() + &set(&GENTLE)),
        _ => return None,
    };
    Some(lines.to_owned())
}

/// Steps/mm, mm/min, mm/s² of each axis: such that its moves are short.
const GENTLE: [(u32, u32); 3] = [(100, 50), (110, 12_000), (120, 2_000)];

/// Lines that set these, with the number for X, of all axes.
fn set(settings: &[(u32, u32)]) -> String {
    let of_axis = |axis: u32| settings.iter().map(move |(number, value)| format!("${}={value}", number + axis));
    (0..3).flat_map(of_axis).map(|line| format!("send {line}\nexpect ok\n")).collect()
}

impl Case {
    const fn new(name: &'static str, happens: &'static str) -> Self {
        Self {
            name,
            on: On::Every,
            happens,
            count: Count::Exact,
            trusted: true,
            state: "Idle",
            cleared: "",
            outputs: Outputs::Stay,
            motors: true,
        }
    }

    /// It ends in this alarm, with all outputs off.
    const fn alarm(name: &'static str, happens: &'static str, trusted: bool) -> Self {
        let case = Self::new(name, happens);
        Self { trusted, state: "Alarm", cleared: "UNLOCK\n", outputs: Outputs::Off, ..case }
    }

    /// The chip begins anew.
    const fn restart(name: &'static str, happens: &'static str) -> Self {
        let case = Self::new(name, happens);
        let (on, count) = (On::Board, Count::Zero);
        Self { on, count, trusted: false, outputs: Outputs::Off, motors: false, ..case }
    }
}

/// Every way, but those that a test of their own holds: see the table.
pub const CASES: [Case; 30] = [
    Case::new("it is complete", "AWAY\n"),
    Case {
        state: "Hold:0",
        cleared: "bytes 7e\nwait-idle\n",
        ..Case::new("feed hold", "UNDER_WAY\nbytes 21\nwait-ms 300\n")
    },
    Case {
        state: "Hold:0",
        cleared: "bytes 7e\nexpect ok\nwait-idle\n",
        ..Case::new("M0", "send G91G0X5\nexpect ok\nsend M0\nwait-ms 500\n")
    },
    Case {
        state: "Door:0",
        cleared: "bytes 7e\nwait-idle\n",
        outputs: Outputs::Paused,
        ..Case::new("safety door", "UNDER_WAY\nbytes 84\nwait-ms 300\n")
    },
    Case::new("jog cancel", "send $J=G91X20F3000\nexpect ok\nwait-ms 200\nbytes 85\nwait-idle\n"),
    Case { outputs: Outputs::Off, ..Case::new("reset at rest", "bytes 18\nexpect Grbl\n") },
    Case { outputs: Outputs::Off, ..Case::new("reset", "UNDER_WAY\nbytes 18\nexpect Grbl\n") },
    Case {
        outputs: Outputs::Off,
        ..Case::new("reset in a hold", "UNDER_WAY\nbytes 21\nwait-ms 300\nbytes 18\nexpect Grbl\n")
    },
    Case::alarm("second reset", "UNDER_WAY\nbytes 18\nwait-ms 5\nbytes 18\nexpect ALARM:3\nexpect Grbl\n", false),
    Case::alarm("limit switch", "UNDER_WAY\nswitch X stuck-closed\nexpect ALARM:1\nRELEASE_SWITCH\n", false),
    Case::alarm(
        "onto a closed limit switch",
        "AWAY\nswitch X stuck-closed\nwait-ms 5\nsend G91G0X-1\nexpect ALARM:1\nexpect ok\nRELEASE_SWITCH\n",
        false,
    ),
    Case::alarm(
        "onto a limit switch that has just closed",
        "AWAY\nswitch X stuck-closed\nsend G91G0X-1\nexpect ALARM:1\nexpect ok\nRELEASE_SWITCH\n",
        false,
    ),
    Case::alarm("emergency stop", "UNDER_WAY\nestop pressed\nexpect ALARM:10\nRELEASE_ESTOP\n", false),
    Case::alarm("emergency stop at rest", "estop pressed\nexpect ALARM:10\nRELEASE_ESTOP\n", true),
    Case::alarm(
        "emergency stop in a hold",
        "UNDER_WAY\nbytes 21\nwait-ms 300\nestop pressed\nexpect ALARM:10\nRELEASE_ESTOP\n",
        false,
    ),
    Case::alarm("reset while homing", "HOMING\nbytes 18\nexpect ALARM:6\nexpect Grbl\n", false),
    Case::alarm("safety door while homing", "HOMING\nbytes 84\nexpect ALARM:7\nexpect error:9\n", false),
    Case::alarm(
        "homing: the switch stays closed",
        "switch X stuck-closed\nwait-ms 5\nsend $HX\nexpect ALARM:8\nexpect error:9\nRELEASE_SWITCH\n",
        false,
    ),
    Case::alarm("soft limit", "send G90G53G0X-1\nexpect ALARM:2\nexpect error:9\n", true),
    Case {
        cleared: "UNLOCK\nsend $130=350\nexpect ok\n",
        // It would last for more than 1,000,000 s.
        ..Case::alarm(
            "a move that cannot be planned",
            "send $130=10000\nexpect ok\nsend G91G1X9900Y9999Z9999F1\nexpect ALARM:21\nexpect ok\n",
            true,
        )
    },
    Case::new(
        "probe: contact",
        "send G91G38.2X20F600\nwait-ms 300\nprobe pressed\nexpect [PRB:\nexpect ok\nprobe released\n",
    ),
    Case::alarm("probe: no contact", "send G91G38.2X1F600\nexpect ALARM:5\nexpect ok\n", true),
    Case::alarm(
        "probe: contact before it moves",
        "probe pressed\nsend G91G38.2X1F600\nexpect ALARM:4\nexpect ok\nprobe released\n",
        true,
    ),
    Case {
        on: On::BoardBy(Port::Timer),
        // Far from its switch: back by the count, so that homing finds it.
        cleared: "UNLOCK\nsend G90G53G0X5\nexpect ok\nwait-idle\n",
        ..Case::alarm("a late step", "TOO_FAST\nsend G91G0X100Y99Z98\nexpect ok\nexpect ALARM:20\nGENTLE\n", false)
    },
    Case {
        on: On::BoardBy(Port::Pio),
        // Far from its switch: back by the count, so that homing finds it.
        cleared: "UNLOCK\nsend G90G53G0X5\nexpect ok\nwait-idle\n",
        ..Case::alarm(
            "a step port runs dry",
            "TOO_STEEP\nsend G91G0X100Y100Z100\nexpect ok\nexpect ALARM:22\nGENTLE\n",
            false,
        )
    },
    Case::restart(
        "hard fault",
        "UNDER_WAY\ncrash\nstop-within 20\nwait-ms 1\nmotors off\nwait-reset\ncheck-stopped\nexpect [MSG:Restarted after a hard fault\nexpect Grbl\n",
    ),
    Case::restart(
        "panic",
        "UNDER_WAY\npanic PANIC\nstop-within 20\nwait-ms 1\nmotors off\nwait-reset\ncheck-stopped\nexpect [MSG:Restarted after a panic\nexpect Grbl\n",
    ),
    Case::restart(
        "watchdog",
        "UNDER_WAY\nhang\nstop-within 100000\nwait-reset\ncheck-stopped\nexpect [MSG:Restarted by the watchdog\nexpect Grbl\n",
    ),
    // SWI_IRQ_2, of the executor of the axes: what is below goes on, and only their beats fail to come.
    Case::restart(
        "watchdog of the axes",
        "UNDER_WAY\nmask-irq 28\nstop-within 100000\nwait-reset\ncheck-stopped\nexpect [MSG:Restarted by the watchdog\nexpect Grbl\n",
    ),
    Case::restart("power cut", "UNDER_WAY\npower-cycle\nexpect Grbl\n"),
];

impl Case {
    /// Brings it about, and holds the machine to it; then X is homed again, if need be.
    fn script(&self) -> String {
        let Self { name, happens, count, trusted, state, cleared, outputs, motors, .. } = *self;
        let on = |on: bool| if on { "on" } else { "off" };
        let coolant = |is_on: bool| format!("wait-output flood {}\n", on(is_on));
        let mut script = format!("# case: {name}\nsend M3S500M8\nexpect ok\n{happens}");
        let check = match count {
            Count::Exact => "check-position\n",
            Count::Zero => "bytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000\n",
        };
        _ = write!(script, "bytes 3f\nexpect <{state}\nmotors {}\n{check}", on(motors));
        script += &coolant(outputs == Outputs::Stay);
        if state == "Alarm" {
            script += "send G0X1\nexpect error:9\n";
        }
        _ = write!(script, "{cleared}bytes 3f\nexpect <Idle\n{check}");
        script += &coolant(outputs != Outputs::Off);
        // Beyond the travel of a homed axis: whoever does not know where it is goes there.
        script += "send $J=G90G53X-1F60\n";
        script += if trusted { "expect error:15\n" } else { "expect ok\nbytes 85\nwait-idle\nsend $HX\nexpect ok\n" };
        script + "send M5M9\nexpect ok\n"
    }
}

impl Case {
    /// Its row in the table of `docs/position.md`.
    #[must_use]
    pub fn row(&self) -> String {
        let Self { name, count, trusted, happens, outputs, motors, on, .. } = *self;
        let count = match count {
            Count::Exact => "exact",
            Count::Zero => "begins at 0",
        };
        let trusted = if trusted { "trusted" } else { "not trusted" };
        let alarm = happens.split_once("ALARM:").and_then(|(_, rest)| rest.lines().next());
        let state = alarm.map_or(format!("`{}`", self.state), |number| format!("`ALARM:{number}`"));
        let cleared = self.clearing();
        let outputs = match outputs {
            Outputs::Stay => "as they were",
            Outputs::Paused => "off, on again with `~`",
            Outputs::Off => "off",
        };
        let motors = if motors { "on" } else { "free" };
        let on = match on {
            On::Every => "simulator, board",
            On::Board => "board",
            On::BoardBy(Port::Pio) => "board, `PioPort`",
            On::BoardBy(Port::Timer) => "board, `TimerPort`",
        };
        format!("| {name} | {count} | {trusted} | {state} | {cleared} | {outputs} | {motors} | {on} |")
    }

    /// What clears it, in words.
    fn clearing(&self) -> &'static str {
        match self.cleared {
            _ if self.happens.contains("RELEASE_ESTOP") => "let go, `$X`",
            _ if self.cleared.contains("UNLOCK") => "`$X`",
            _ if self.cleared.contains("bytes 7e") => "`~`",
            _ => "",
        }
    }
}

/// All cases that a machine knows, one after the other from power-up with X [`START_MM`] above its switch. `panic` is the
/// address of a function of the firmware that panics, in hexadecimal.
#[must_use]
pub fn script(knows: impl Fn(On) -> bool, panic: &str) -> String {
    let quick_homing = "send $26=1\nexpect ok\nsend $24=600\nexpect ok\nsend $25=2880\nexpect ok\n";
    let begin = format!("expect Grbl\n{quick_homing}GENTLE\nsend $HX\nexpect ok\n");
    let cases = CASES.iter().filter(|case| knows(case.on)).map(Case::script);
    let lines = iter::once(begin).chain(cases).collect::<String>().replace("PANIC", panic);
    lines.lines().map(|line| meaning(line).unwrap_or_else(|| format!("{line}\n"))).collect()
}

/// Where X stands at first, mm above its switch: near, so that homing is short.
pub const START_MM: f64 = 3.0;
