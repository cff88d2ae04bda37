//! The position contract: for every way in which a motion can end, what is known of the position afterwards, and what
//! clears it.
//!
//! The cases are also the rows of `docs/position.md`. Each case is a script that a simulated machine and the firmware
//! on the emulated board run alike: see [`crate::script_runner`].

use std::fmt::Write as _;
use std::iter;

use isostep_sim::{AXES, Port};

/// The state of the tool's outputs after the end of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outputs {
    /// The outputs stay as they were.
    Stay,
    /// The outputs are off, and are switched on again when the motion continues.
    Paused,
    /// The outputs are off.
    Off,
}

/// The step count after the end of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// The count is that of the edges that left.
    Exact,
    /// The count has restarted at 0.
    Zero,
}

/// The machines on which a motion can end in this way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    /// All machines.
    Every,
    /// Only the emulated board.
    Board,
    /// Only the emulated board with this step port.
    BoardBy(Port),
}

/// A way in which a motion ends.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The name in its row of the table.
    pub name: &'static str,
    /// The machines that it applies to.
    pub on: On,
    /// The script that makes it happen. It begins at rest, with X homed and with M3 and M8 on.
    pub happens: &'static str,
    /// The step count afterwards.
    pub count: Count,
    /// Whether homed axes stay homed.
    pub trusted: bool,
    /// The name of the state in a status report.
    pub state: &'static str,
    /// The script that leads back to Idle.
    pub cleared: &'static str,
    /// The tool's outputs afterwards.
    pub outputs: Outputs,
    /// Whether the motors are energised.
    pub motors: bool,
}

/// The commands that a word in capitals in the scripts stands for.
fn meaning(word: &str) -> Option<String> {
    let lines = match word {
        // A move of half a second, seen a fifth of a second after its line.
        "UNDER_WAY" => "send G91G1X20F3000\nexpect ok\nwait-ms 200\n",
        "AWAY" => "send G91G0X5\nexpect ok\nwait-idle\n",
        // Homing while it seeks the switch. The seek takes longer than this wait.
        "HOMING" => "send $HX\nwait-ms 50\n",
        "RELEASE_ESTOP" => "send $X\nexpect error:9\nestop released\nwait-ms 5\n",
        "RELEASE_SWITCH" => "switch X normal\nwait-ms 5\n",
        "UNLOCK" => "send $X\nexpect ok\n",
        // With `TimerPort` the executor of the task that makes the steps gets no time for a while.
        "STARVE_STEPS" => "mask-irq 29\nwait-ms 2\nunmask-irq 29\n",
        // X gets its second motor, which has not moved with it before, and is homed with it.
        "SQUARED" => "send $905=1\nexpect ok\nsend $349=100\nexpect ok\nsend $HX\nexpect ok\n",
        "SINGLE" => "send $905=0\nexpect ok\n",
        "GENTLE" => return Some("send $940=0\nexpect ok\n".to_owned() + &set(&GENTLE)),
        _ => return None,
    };
    Some(lines.to_owned())
}

/// Steps/mm, mm/min and mm/s² of each axis. With these values the moves are short.
const GENTLE: [(u32, u32); 3] = [(100, 50), (110, 12_000), (120, 2_000)];

/// Commands that set these settings for all axes. Each number is that of X.
fn set(settings: &[(u32, u32)]) -> String {
    let of_axis = |axis: u32| settings.iter().map(move |(number, value)| format!("${}={value}", number + axis));
    (0..AXES as u32).flat_map(of_axis).map(|line| format!("send {line}\nexpect ok\n")).collect()
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

    /// A case that ends in an alarm with all outputs off.
    const fn alarm(name: &'static str, happens: &'static str, trusted: bool) -> Self {
        let case = Self::new(name, happens);
        Self { trusted, state: "Alarm", cleared: "UNLOCK\n", outputs: Outputs::Off, ..case }
    }

    /// A case in which the chip restarts.
    const fn restart(name: &'static str, happens: &'static str) -> Self {
        let case = Self::new(name, happens);
        let (on, count) = (On::Board, Count::Zero);
        Self { on, count, trusted: false, outputs: Outputs::Off, motors: false, ..case }
    }
}

/// Every way in which a motion can end, except those that have a test of their own: see the table.
pub const CASES: [Case; 34] = [
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
    Case {
        cleared: "UNLOCK\nSINGLE\n",
        ..Case::alarm(
            "limit switch of a second motor",
            "SQUARED\nUNDER_WAY\nswitch 2 stuck-closed\nexpect ALARM:1\nswitch 2 normal\nwait-ms 5\n",
            false,
        )
    },
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
    Case {
        cleared: "UNLOCK\nSINGLE\n",
        ..Case::alarm(
            "homing: a motor does not reach its switch",
            "SQUARED\nswitch X stuck-open\nsend $349=1\nexpect ok\nsend $HX\nexpect ALARM:15\nexpect error:9\nRELEASE_SWITCH\n",
            false,
        )
    },
    Case::alarm("soft limit", "send G90G53G0X-1\nexpect ALARM:2\nexpect error:9\n", true),
    Case {
        cleared: "UNLOCK\nsend $130=350\nexpect ok\n",
        // This move would take more than 1,000,000 s.
        ..Case::alarm(
            "a move that cannot be planned",
            "send $130=10000\nexpect ok\nsend G91G1X9900Y9999Z9999F1\nexpect ALARM:21\nexpect ok\n",
            true,
        )
    },
    Case {
        motors: false,
        ..Case::alarm(
            "sleep, which a reset ends",
            "AWAY\nsend $SLP\nexpect ok\nwait-ms 20\nbytes 18\nexpect Grbl\n",
            false,
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
        // The stop is far from the switch. The step count leads back to it, so that homing finds it.
        cleared: "UNLOCK\nsend G90G53G0X5\nexpect ok\nwait-idle\n",
        ..Case::alarm("a late step", "UNDER_WAY\nSTARVE_STEPS\nexpect ALARM:20\n", false)
    },
    Case {
        on: On::BoardBy(Port::Pio),
        ..Case::alarm(
            "the core hangs for a while, and the tool is cut off",
            "send G91G1X5F300\nexpect ok\nwait-ms 200\nhang 25\nexpect ALARM:23\n",
            false,
        )
    },
    Case { on: On::Board, ..Case::alarm("the same at rest", "hang 25\nexpect ALARM:23\n", true) },
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
    // 28 is SWI_IRQ_2, the interrupt of the axis executor. Lower priorities go on, and only the heartbeats of the axes
    // are missing.
    Case::restart(
        "watchdog of the axes",
        "UNDER_WAY\nmask-irq 28\nstop-within 100000\nwait-reset\ncheck-stopped\nexpect [MSG:Restarted by the watchdog\nexpect Grbl\n",
    ),
    Case::restart("power cut", "UNDER_WAY\npower-cycle\nexpect Grbl\n"),
];

impl Case {
    /// Makes the case happen and checks the machine afterwards. Then X is homed again if necessary.
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
        // The target is beyond the travel of a homed axis. Only a machine that is not homed accepts it.
        script += "send $J=G90G53X-1F60\n";
        script += if trusted { "expect error:15\n" } else { "expect ok\nbytes 85\nwait-idle\nsend $HX\nexpect ok\n" };
        script + "send M5M9\nexpect ok\n"
    }
}

impl Case {
    /// The case's row in the table of `docs/position.md`.
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

    /// How to clear it, in words.
    fn clearing(&self) -> &'static str {
        match self.cleared {
            _ if self.happens.contains("RELEASE_ESTOP") => "let go, `$X`",
            _ if self.cleared.contains("UNLOCK") => "`$X`",
            _ if self.cleared.contains("bytes 7e") => "`~`",
            _ => "",
        }
    }
}

/// A script of all cases for a machine, one after the other, from power-up with X [`START_MM`] above its switch. X has a
/// second motor, as far from its own switch, that makes steps in a few cases only.
/// `panic` is the address of a firmware function that panics, in hexadecimal.
#[must_use]
pub fn script(knows: impl Fn(On) -> bool, panic: &str) -> String {
    let quick_homing = "send $26=1\nexpect ok\nsend $24=600\nexpect ok\nsend $25=2880\nexpect ok\n";
    let begin = format!("expect Grbl\nsend $905=0\nexpect ok\n{quick_homing}GENTLE\nsend $HX\nexpect ok\n");
    // A has the second motor's pins.
    let has_motors = |case: &&Case| AXES == 3 || !case.happens.contains("SQUARED");
    let cases = CASES.iter().filter(|case| knows(case.on)).filter(has_motors).map(Case::script);
    let lines = iter::once(begin).chain(cases).collect::<String>().replace("PANIC", panic);
    lines.lines().map(|line| meaning(line).unwrap_or_else(|| format!("{line}\n"))).collect()
}

/// Initial distance of X above its switch, mm. It is small so that homing is short.
pub const START_MM: f64 = 3.0;
