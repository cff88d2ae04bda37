//! The position contract: for every way in which a motion can end, what is known of the position afterwards, and what
//! clears it.
//!
//! The cases are also the rows of `docs/position.md`. Together they are a dialogue ([`crate::dialogue`]) that is carried out on
//! a simulated machine and on the emulated board.

use std::fmt::Write as _;
use std::iter;

use isostep_sim::{AXES, Port};

use crate::dialogue;
use crate::emulated::{is_pico_2, is_skr_pico};

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
    /// The steps that make it happen. They begin at rest, with X homed and with M3 and M8 on.
    pub happens: &'static str,
    /// The step count afterwards.
    pub count: Count,
    /// True if homed axes stay homed.
    pub trusted: bool,
    /// The name of the state in a status report.
    pub state: &'static str,
    /// The steps that lead back to Idle.
    pub cleared: &'static str,
    /// The tool's outputs afterwards.
    pub outputs: Outputs,
    /// True if the motors are energised.
    pub motors: bool,
}

/// The steps that a word in capitals stands for.
fn meaning(word: &str) -> Option<String> {
    let lines = match word {
        // A move of half a second, seen a fifth of a second after its line.
        "UNDER_WAY" => ">> G91G1X20F3000\nwait 200 ms\n< ok\n",
        "AWAY" => "> G91G0X5\n< ok\n",
        "HELD" => "! !\nwait 300 ms\n",
        // Homing while it seeks the switch. The seek takes longer than this wait.
        "HOMING" => ">> $HX\nwait 50 ms\n",
        "STOPPED" => "emergency stop pressed\nwait 20 ms\n< ...\n< ALARM:10\n< ...\n",
        "RELEASE_ESTOP" => "> $X\n< ...\n< error:9\nemergency stop released\nwait 5 ms\n",
        "RELEASE_SWITCH" => "switch X normal\nwait 5 ms\n",
        "UNLOCK" => "> $X\n< ...\n< ok\n",
        "RESET" => "! \\x18\nwait 500 ms\n< ...\n< Grbl...\n< ...\n",
        // The motors are free, the watchdog bites, and no step is made meanwhile.
        "DEAD" => "note\nwait 1 ms\nmotors off\nemulator wait-reset\nno step made\n",
        "HUNG" => "wait 100 ms\nnote\nemulator wait-reset\nno step made\n",
        "RESTARTED" => "until heard\nwait 20 ms\n< Grbl...\n< ...\n",
        // With `TimerPort` the executor of the task that makes the steps gets no time for a while.
        "STARVE_STEPS" => "emulator mask-irq 29\nwait 2 ms\nemulator unmask-irq 29\nwait 20 ms\n",
        // X gets its second motor, which has not moved with it before, and is homed with it.
        "SQUARED" => "> $905=1\n< ...\n< ok\n> $349=100\n< ...\n< ok\n> $HX\n< ...\n< ok\n",
        // The alarm of X's drive is wired, and closes its contact.
        "WATCHED" => "> $745=1\n< ok\n> $744=1\n< ok\n",
        "UNWATCHED" => "> $744=0\n< ok\n",
        "SINGLE" => "> $905=0\n< ...\n< ok\n",
        "GENTLE" => return Some("> $940=0\n< ...\n< ok\n".to_owned() + &set(&GENTLE)),
        _ => {
            let (what, told) = word.split_once(' ')?;
            return match what {
                "TELLS" => Some(format!("wait 30 ms\n< ...\n< {told}\n< ...\n")),
                "WELCOME" => Some(format!("until heard\nwait 100 ms\n< ...\n< {told}...\n< ...\n")),
                _ => None,
            };
        }
    };
    Some(lines.to_owned())
}

/// Steps/mm, mm/min and mm/s² of each axis. With these values the moves are short.
const GENTLE: [(u32, u32); 3] = [(100, 50), (110, 12_000), (120, 2_000)];

/// Lines that set these settings for all axes. Each number is that of X.
fn set(settings: &[(u32, u32)]) -> String {
    let of_axis = |axis: u32| settings.iter().map(move |(number, value)| format!("${}={value}", number + axis));
    (0..AXES as u32).flat_map(of_axis).map(|line| format!("> {line}\n< ...\n< ok\n")).collect()
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
pub const CASES: [Case; 36] = [
    Case::new("it is complete", "AWAY\n"),
    Case { state: "Hold:0", cleared: "! ~\nuntil idle\n", ..Case::new("feed hold", "UNDER_WAY\nHELD\n") },
    Case {
        state: "Hold:0",
        cleared: "! ~\nuntil idle\n< ok\n",
        ..Case::new("M0", ">> G91G0X5\n>> M0\nwait 500 ms\n< ok\n")
    },
    Case {
        state: "Door:0",
        cleared: "! ~\nuntil idle\n",
        outputs: Outputs::Paused,
        ..Case::new("safety door", "UNDER_WAY\n! \\x84\nwait 300 ms\n")
    },
    Case::new("jog cancel", ">> $J=G91X20F3000\nwait 200 ms\n< ok\n! \\x85\nuntil idle\n"),
    Case { outputs: Outputs::Off, ..Case::new("reset at rest", "RESET\n") },
    Case { outputs: Outputs::Off, ..Case::new("reset", "UNDER_WAY\nRESET\n") },
    Case { outputs: Outputs::Off, ..Case::new("reset in a hold", "UNDER_WAY\nHELD\nRESET\n") },
    Case::alarm("second reset", "UNDER_WAY\n! \\x18\nwait 4 ms\n!! \\x18\nTELLS ALARM:3\n", false),
    Case::alarm("limit switch", "UNDER_WAY\nswitch X closed\nTELLS ALARM:1\nRELEASE_SWITCH\n", false),
    Case::alarm(
        "onto a closed limit switch",
        "AWAY\nswitch X closed\nwait 5 ms\n> G91G0X-1\nTELLS ALARM:1\nRELEASE_SWITCH\n",
        false,
    ),
    Case::alarm(
        "onto a limit switch that has just closed",
        "AWAY\nswitch X closed\n> G91G0X-1\nTELLS ALARM:1\nRELEASE_SWITCH\n",
        false,
    ),
    Case {
        cleared: "UNLOCK\nSINGLE\n",
        ..Case::alarm(
            "limit switch of a second motor",
            "SQUARED\nUNDER_WAY\nswitch X2 closed\nTELLS ALARM:1\nswitch X2 normal\nwait 5 ms\n",
            false,
        )
    },
    Case {
        cleared: "UNLOCK\nUNWATCHED\n",
        ..Case::alarm("alarm of a drive", "WATCHED\nUNDER_WAY\ndrive X alarms\nTELLS ALARM:17\ndrive X well\n", false)
    },
    Case {
        cleared: "UNLOCK\nUNWATCHED\n",
        ..Case::alarm("alarm of a drive at rest", "WATCHED\ndrive X alarms\nTELLS ALARM:17\ndrive X well\n", false)
    },
    Case::alarm("emergency stop", "UNDER_WAY\nSTOPPED\nRELEASE_ESTOP\n", false),
    Case::alarm("emergency stop at rest", "STOPPED\nRELEASE_ESTOP\n", true),
    Case::alarm("emergency stop in a hold", "UNDER_WAY\nHELD\nSTOPPED\nRELEASE_ESTOP\n", false),
    Case::alarm("reset while homing", "HOMING\n!! \\x18\nTELLS ALARM:6\n", false),
    Case::alarm("safety door while homing", "HOMING\n!! \\x84\nTELLS ALARM:7\n", false),
    Case::alarm(
        "homing: the switch stays closed",
        "switch X closed\nwait 5 ms\n> $HX\nTELLS ALARM:8\nRELEASE_SWITCH\n",
        false,
    ),
    Case {
        cleared: "UNLOCK\nSINGLE\n",
        ..Case::alarm(
            "homing: a motor does not reach its switch",
            "SQUARED\nswitch X open\n> $349=1\n< ...\n< ok\n> $HX\nTELLS ALARM:15\nRELEASE_SWITCH\n",
            false,
        )
    },
    Case::alarm("soft limit", "> G90G53G0X-1\nTELLS ALARM:2\n", true),
    Case {
        cleared: "UNLOCK\n> $130=350\n< ...\n< ok\n",
        // This move would take more than 1,000,000 s.
        ..Case::alarm(
            "a move that cannot be planned",
            "> $130=10000\n< ...\n< ok\n> G91G1X9900Y9999Z9999F1\nTELLS ALARM:21\n",
            true,
        )
    },
    Case {
        motors: false,
        ..Case::alarm("sleep, which a reset ends", "AWAY\n>> $SLP\nwait 20 ms\n< ok\n< ...\nRESET\n", false)
    },
    Case::new(
        "probe: contact",
        ">> G91G38.2X20F600\nwait 300 ms\nprobe pressed\nwait 300 ms\n< [PRB:...\n< ok\nprobe released\n",
    ),
    Case::alarm("probe: no contact", "> G91G38.2X1F600\nTELLS ALARM:5\n", true),
    Case::alarm(
        "probe: contact before it moves",
        "probe pressed\n> G91G38.2X1F600\nTELLS ALARM:4\nprobe released\n",
        true,
    ),
    Case {
        on: On::BoardBy(Port::Timer),
        // The stop is far from the switch. The step count leads back to it, so that homing finds it.
        cleared: "UNLOCK\n> G90G53G0X5\n< ok\n",
        ..Case::alarm("a late step", "UNDER_WAY\nSTARVE_STEPS\nTELLS ALARM:20\n", false)
    },
    Case {
        on: On::BoardBy(Port::Pio),
        ..Case::alarm(
            "the core hangs for a while, and the tool is cut off",
            ">> G91G1X5F300\nwait 200 ms\n< ok\nemulator hang 25\nTELLS ALARM:23\n",
            false,
        )
    },
    Case { on: On::Board, ..Case::alarm("the same at rest", "emulator hang 25\nTELLS ALARM:23\n", true) },
    Case::restart(
        "hard fault",
        "UNDER_WAY\nemulator crash\nwait 20 us\nDEAD\nWELCOME [MSG:Restarted after a hard fault\n",
    ),
    Case::restart("panic", "UNDER_WAY\nemulator panic PANIC\nwait 20 us\nDEAD\nWELCOME [MSG:Restarted after a panic\n"),
    Case::restart("watchdog", "UNDER_WAY\nemulator hang\nHUNG\nWELCOME [MSG:Restarted by the watchdog\n"),
    // 28 is SWI_IRQ_2, the interrupt of the axis executor. Lower priorities go on, and only the heartbeats of the axes
    // are missing.
    Case::restart(
        "watchdog of the axes",
        "UNDER_WAY\nemulator mask-irq 28\nHUNG\nWELCOME [MSG:Restarted by the watchdog\n",
    ),
    Case::restart("power cut", "UNDER_WAY\npower off and on\nRESTARTED\n"),
];

impl Case {
    /// Makes the case happen and checks the machine afterwards. Then X is homed again if necessary.
    fn steps(&self) -> String {
        let Self { name, happens, count, trusted, state, cleared, outputs, motors, .. } = *self;
        let on = |on: bool| if on { "on" } else { "off" };
        let coolant = |is_on: bool| format!("output flood {}\n", on(is_on));
        let mut steps = format!("# case: {name}\n> M3S500M8\n< ok\nwait 5 ms\n{happens}");
        let check = match count {
            Count::Exact => "counts agree\n",
            Count::Zero => "report Idle MPos:0.000,0.000,0.000...\n",
        };
        _ = write!(steps, "report {state}\nmotors {}\n{check}", on(motors));
        steps += &coolant(outputs == Outputs::Stay);
        if state == "Alarm" {
            steps += "> G0X1\n< error:9\n";
        }
        _ = write!(steps, "{cleared}wait 5 ms\nreport Idle\n{check}");
        steps += &coolant(outputs != Outputs::Off);
        // The target is beyond the travel of a homed axis. Only a machine that is not homed accepts it.
        steps += ">> $J=G90G53X-1F60\nwait 5 ms\n";
        steps += if trusted { "< ...\n< error:15\n" } else { "< ok\n! \\x85\nuntil idle\n> $HX\n< ...\n< ok\n" };
        steps + "> M5M9\n< ok\n"
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
        let happens = happens.replace("STOPPED", "ALARM:10");
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

    /// True if X needs a second motor for it.
    #[must_use]
    pub fn is_squared(&self) -> bool {
        self.happens.contains("SQUARED")
    }

    /// The way to clear it, in words.
    fn clearing(&self) -> &'static str {
        match self.cleared {
            _ if self.happens.contains("RELEASE_ESTOP") => "let go, `$X`",
            _ if self.cleared.contains("UNLOCK") => "`$X`",
            _ if self.cleared.contains("! ~") => "`~`",
            _ => "",
        }
    }
}

/// The dialogue of all cases for a machine, one after the other, from power-up with X a little above its switch. Where one of them
/// needs it, X has a second motor, as far from its own switch, that makes steps in a few cases only.
/// `panic` is the address of a firmware function that panics, in hexadecimal.
fn steps(knows: impl Fn(&Case) -> bool, panic: &str) -> String {
    let quick_homing = "> $26=1\n< ...\n< ok\n> $24=600\n< ...\n< ok\n> $25=2880\n< ...\n< ok\n";
    let begin = format!("powered up\n> $905=0\n< ...\n< ok\n{quick_homing}GENTLE\n> $HX\n< ok\n");
    // A has the second motor's pins, but for the board that has five motors.
    let has_motors = |case: &&Case| AXES == 3 || is_pico_2() || !case.is_squared();
    let has_alarm = !is_skr_pico() && (AXES == 3 || !is_pico_2());
    let has_pins = |case: &&Case| has_motors(case) && (has_alarm || !case.happens.contains("WATCHED"));
    let cases = CASES.iter().filter(|case| knows(case)).filter(has_pins).map(Case::steps);
    let lines = iter::once(begin).chain(cases).collect::<String>().replace("PANIC", panic);
    lines.lines().map(|line| meaning(line).unwrap_or_else(|| format!("{line}\n"))).collect()
}

/// Carries the dialogue out behind these steps about the machine.
///
/// # Panics
/// At the first step that is not so.
pub fn keep(on: dialogue::On, machine: &str, knows: impl Fn(&Case) -> bool, panic: &str) {
    let text = format!("=== contract\nEvery way to end.\n\nwith start 3 40 15\n{machine}{}", steps(knows, panic));
    let dialogues = dialogue::dialogues(&text).unwrap_or_else(|error| panic!("{error}"));
    if let Err(error) = dialogue::carry_out(&dialogues[0], on) {
        let before: Vec<_> = text.lines().take(error.line).collect();
        let case = before.iter().rposition(|line| line.starts_with("# case: ")).unwrap_or(0);
        panic!("{}\n{}", before[case..].join("\n"), error.why);
    }
}
