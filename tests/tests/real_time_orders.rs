//! The real-time bytes that resume, hold, cancel a jog and reset, in every order, together and one after the other, in
//! every state. Afterwards the machine must be able to continue, no step may be lost, and every line and every reset
//! must be answered. The tests run in virtual time with bytes on the console; a failure prints the command that repeats
//! it.
//!
//! Every state is tested with all orders of up to three bytes. Orders of four bytes are tested in the states in which a
//! request may meet an earlier one: held, braking, and jogging.

use std::env;
use std::panic::catch_unwind;

use embassy_time::Duration;
use isostep_motion::{Alarm, Axis, State};
use isostep_sim::{Config, Sim};
use isostep_trials::cases;

const RESET: u8 = 0x18;
/// Resume, hold, jog cancel, reset.
const BYTES: [u8; 4] = [b'~', b'!', 0x85, RESET];
/// The times from one byte to the next. With 0 the bytes come in one packet.
const GAPS_US: [u64; 5] = [0, 100, 1, 10, 1_000];
/// Steps of X in a millimetre.
const MM: i32 = 50;
const PULL_OFF_STEPS: i32 = 20;

/// 0.5 s to 3 mm and 0.4 s back to 1 mm. It takes 0.2 s to reach 10 mm/s, and as long to stop.
const PROGRAM: &str = "G1 X3 F600\nG1 X1";
/// 0.3 s to 1 mm. Then the machine dwells for as long; the last line waits for the dwell.
const DWELL: &str = "G1 X1 F600\nG4 P0.3\nG1 X2";

/// A machine whose X is homed and next to its switch, with counts of what its console has sent and received.
struct Bench {
    sim: Sim,
    /// Number of lines sent, and of answers to them.
    lines: usize,
    answers: usize,
    /// Number of resets sent, and of welcomes received since the last reset.
    resets: usize,
    welcomes: usize,
}

/// The place where the program ends if no line is discarded, mm.
type End = Option<i32>;

impl Bench {
    fn new() -> Self {
        let mut config = Config { start_mm: [0.1, 40.0, 15.0], keep_record: false, ..Config::default() };
        config.time_limit = Duration::from_secs(20);
        config.settings.homing_pull_off_mm = PULL_OFF_STEPS as f32 / MM as f32;
        let mut bench = Self { sim: Sim::new(&config), lines: 0, answers: 0, resets: 0, welcomes: 0 };
        bench.say("$HX");
        assert_eq!(bench.sim.machine().status().homed, [true, false, false]);
        bench
    }

    /// Sends lines, and lets time pass.
    fn begin(&mut self, lines: &str, wait_ms: u64) -> &mut Self {
        self.lines += lines.lines().count();
        self.send(format!("{lines}\n").as_bytes(), wait_ms * 1_000)
    }

    /// Sends bytes, real-time bytes included, and lets time pass.
    fn send(&mut self, bytes: &[u8], wait_us: u64) -> &mut Self {
        self.hear();
        let resets = bytes.iter().filter(|byte| **byte == RESET).count();
        if resets > 0 {
            (self.resets, self.welcomes) = (self.resets + resets, 0);
        }
        self.sim.send(bytes);
        self.sim.run_for(Duration::from_micros(wait_us)).unwrap();
        self.hear();
        self
    }

    /// Lets time pass in slices until X stands there or beyond.
    fn comes_to(&mut self, steps: i32, slice_us: u64) -> &mut Self {
        while self.x() < steps {
            self.send(b"", slice_us);
        }
        self
    }

    /// Sends a line, which must be answered once with `ok`, and runs until nothing moves.
    fn say(&mut self, line: &str) {
        self.sim.send(format!("{line}\n").as_bytes());
        self.sim.run_until_idle().unwrap();
        let heard = self.sim.replies();
        let answers: Vec<_> = heard.iter().filter(|line| is_answer(line)).collect();
        assert_eq!(answers, ["ok"], "{line}: {heard:?}");
    }

    fn hear(&mut self) {
        for line in self.sim.replies() {
            self.answers += usize::from(is_answer(&line));
            self.welcomes += usize::from(line.starts_with("Grbl"));
        }
    }

    /// Runs until nothing can happen without another input.
    fn rest(&mut self) {
        self.sim.run_until_idle().unwrap();
        self.hear();
    }

    fn state(&self) -> State {
        self.sim.machine().state()
    }

    /// The name of the state in the reports.
    fn word(&mut self) -> String {
        self.hear();
        self.sim.send(b"?");
        self.sim.run_for(Duration::from_millis(1)).unwrap();
        let heard = self.sim.replies();
        let word = heard.last().and_then(|report| report.strip_prefix('<')).and_then(|report| report.split('|').next());
        word.unwrap_or_else(|| panic!("`?` was answered with {heard:?}, in {:?}", self.state())).to_owned()
    }

    /// The place of X, steps.
    fn x(&self) -> i32 {
        self.sim.machine().position_steps()[0]
    }

    /// Checks that the carriages are where the machine reports, and that no driver has missed an edge.
    fn check_counts(&self) {
        let outcome = self.sim.outcome();
        let missed = outcome.violations.first().map(ToString::to_string);
        let lost = outcome.losses.first().map(ToString::to_string);
        assert_eq!((missed, lost), (None, None), "the first of either");
        assert_eq!((outcome.counted_steps, outcome.drift_steps), (outcome.position_steps, [0; 3]));
    }

    /// Leads the machine from where it has come to rest to Idle.
    fn lead_on(&mut self) {
        match self.state() {
            State::Idle => {}
            State::Hold { still: true } => {
                self.send(b"~", 0);
                self.rest();
            }
            State::Alarm(_) => self.say("$X"),
            state => panic!("at rest in {state:?}"),
        }
        let word = self.word();
        if word == "Check" {
            self.say("$C");
        } else {
            assert_eq!(word, "Idle");
        }
    }
}

fn is_answer(line: &str) -> bool {
    line == "ok" || line.starts_with("error:")
}

/// Tries all orders of up to `longest` bytes in the state that `lead` brings about.
fn all_orders(test: &str, longest: u32, lead: fn(&mut Bench) -> End) {
    if let Ok(order) = env::var("ORDER") {
        let (bytes, gap_us) = order.split_once('@').expect("ORDER is BYTES@MICROSECONDS");
        let bytes = bytes.split(',').map(|byte| u8::from_str_radix(byte, 16).expect("bytes are hexadecimal"));
        carry_out(lead, &bytes.collect::<Vec<_>>(), gap_us.parse().expect("microseconds are a number"));
        return;
    }
    // Without all cases long orders are tried with few gaps.
    let gaps = |length| &GAPS_US[..if length > 2 { cases(1, 5) as usize } else { GAPS_US.len() }];
    for (length, &gap_us) in (1..=longest).flat_map(|length| gaps(length).iter().map(move |gap_us| (length, gap_us))) {
        for index in 0..BYTES.len().pow(length) {
            let bytes: Vec<_> = (0..length).map(|place| BYTES[index >> (2 * place) & 3]).collect();
            if catch_unwind(|| carry_out(lead, &bytes, gap_us)).is_err() {
                let bytes: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                let order = format!("ORDER={}@{gap_us}", bytes.join(","));
                panic!("again: {order} cargo test -p isostep-tests -- --exact real_time_orders::{test}");
            }
        }
    }
}

fn carry_out(lead: fn(&mut Bench) -> End, bytes: &[u8], gap_us: u64) {
    let mut bench = Bench::new();
    let end = lead(&mut bench);
    let (was, homed) = (bench.state(), bench.sim.machine().status().homed);
    if gap_us == 0 {
        bench.send(bytes, 0);
    } else {
        for &byte in bytes {
            bench.send(&[byte], gap_us);
        }
    }
    bench.rest();
    if bench.resets > 0 {
        assert!((1..=bench.resets).contains(&bench.welcomes), "{} welcomes", bench.welcomes);
    }
    // A second reset stops the machine at once while it brakes for the first; homing is stopped by the first.
    let is_locked = match was {
        State::Alarm(_) => true,
        State::Home => bench.resets > 0,
        _ => bench.resets > 1,
    };
    assert!(is_locked || !matches!(bench.state(), State::Alarm(_)), "{:?}", bench.state());
    if was != State::Home && !matches!(bench.state(), State::Alarm(_)) {
        assert_eq!(bench.sim.machine().status().homed, homed);
    }
    bench.lead_on();
    if bench.resets == 0 {
        assert_eq!(bench.answers, bench.lines, "answers to the lines sent");
        end.into_iter().for_each(|end| assert_eq!(bench.x(), end * MM, "where the program ends"));
    }
    assert!(bench.answers <= bench.lines, "{} answers to {} lines", bench.answers, bench.lines);
    bench.check_counts();
    let x = bench.x();
    bench.say("G91 G1 X1 F600");
    assert_eq!((bench.x(), bench.state()), (x + MM, State::Idle), "what follows counts from there");
    bench.check_counts();
}

const HELD: State = State::Hold { still: true };
const BRAKING: State = State::Hold { still: false };

/// A test for each state: its name, the longest orders that are tried in it, where the program ends, the state, and what
/// brings a fresh machine into it.
macro_rules! states {
    ($($(#[$about:meta])* $name:ident, $longest:literal, $end:expr, $state:expr, |$bench:ident| $lead:expr;)*) => {$(
        $(#[$about])*
        #[test]
        fn $name() {
            all_orders(stringify!($name), $longest, |$bench| {
                $lead;
                assert_eq!($bench.state(), $state, "the test's own beginning");
                $end
            });
        }
    )*};
}

states! {
    idle, 3, Some(0), State::Idle, |bench| bench.send(b"", 0);
    starting, 3, Some(1), State::Run, |bench| {
        bench.begin("G1 X1 F600", 0).send(b"", 200);
        assert_eq!(bench.x(), 0);
    };
    accelerating, 3, Some(1), State::Run, |bench| bench.begin(PROGRAM, 100);
    cruising, 3, Some(1), State::Run, |bench| bench.begin(PROGRAM, 250);
    decelerating, 3, Some(1), State::Run, |bench| bench.begin(PROGRAM, 450);
    between_moves, 3, Some(1), State::Run, |bench| bench.begin(PROGRAM, 450).comes_to(3 * MM, 10);
    /// While moving round one of three corners that are taken without a stop.
    flowing, 3, Some(1), State::Run, |bench| {
        bench.begin("G1 X1 F600\nX2\nX2 Y0.5\nX3\nX1 Y0", 200).comes_to(2 * MM, 100)
    };
    /// More moves follow than fit into the chain.
    flowing_from_a_full_queue, 2, Some(2), State::Run, |bench| {
        let lines: Vec<_> = (1..=90).map(|k| format!("G1 X{:.2} F600", 0.04 * f64::from(k))).collect();
        bench.begin(&lines.join("\n"), 250).begin("X2", 1)
    };
    ending, 3, Some(1), State::Run, |bench| bench.begin("G1 X1 F600", 0).comes_to(MM - 1, 100);
    dwelling, 3, Some(2), State::Run, |bench| {
        bench.begin(DWELL, 400);
        assert_eq!(bench.x(), MM, "it stands still");
    };
    holding, 3, Some(1), BRAKING, |bench| bench.begin(PROGRAM, 250).send(b"!", 10_000);
    braking, 4, Some(1), BRAKING, |bench| bench.begin(PROGRAM, 250).send(b"!", 100_000);
    held, 4, Some(1), HELD, |bench| bench.begin(PROGRAM, 250).send(b"!", 500_000);
    held_while_idle, 3, Some(0), HELD, |bench| bench.send(b"!", 1_000);
    held_before_a_move, 3, Some(1), HELD, |bench| bench.send(b"!", 1_000).begin(PROGRAM, 1);
    held_in_a_dwell, 3, Some(2), HELD, |bench| bench.begin(DWELL, 400).send(b"!", 1_000);
    /// Held for longer than the rest of the dwell, which still has to pass after the hold.
    held_in_a_dwell_for_long, 3, Some(2), HELD, |bench| bench.begin(DWELL, 400).send(b"!", 500_000);
    /// A dwell so long that only the test that resumes it waits for its end.
    held_in_a_long_dwell, 3, Some(2), HELD, |bench| {
        bench.begin("G1 X1 F600\nG4 P15\nG1 X2", 400).send(b"!", 1_000)
    };
    pausing, 3, Some(2), HELD, |bench| bench.begin("G1 X1 F600\nM0\nG1 X2", 1_000);
    resuming, 3, Some(1), State::Run, |bench| {
        bench.begin(PROGRAM, 250).send(b"!", 500_000);
        assert_eq!(bench.state(), HELD);
        bench.send(b"~", 200);
    };
    resetting, 3, None, BRAKING, |bench| bench.begin(PROGRAM, 250).send(&[RESET], 100_000);
    jogging, 4, None, State::Jog, |bench| bench.begin("$J=X3 F600\n$J=X1 F600", 250);
    jogging_along, 3, None, State::Jog, |bench| {
        bench.begin("$J=X1 F600\n$J=X1 Y0.5 F600\n$J=X2 F300\n$J=X1 F600", 100).comes_to(MM, 100)
    };
    cancelling, 3, None, State::Jog, |bench| bench.begin("$J=X3 F600\n$J=X1 F600", 250).send(&[0x85], 100_000);
    homing, 3, Some(0), State::Home, |bench| bench.begin("G1 X1 F600", 600).begin("$HX", 50);
    /// While it is backed off and waits until the switch has come to rest.
    homing_and_standing_still, 3, Some(0), State::Home, |bench| {
        bench.begin("$HX", 1);
        while !bench.sim.machine().status().pressed[0] {
            bench.send(b"", 1_000);
        }
        let backed_off = bench.x() + PULL_OFF_STEPS;
        while bench.x() != backed_off {
            bench.send(b"", 1_000);
        }
    };
    checking, 3, Some(0), State::Idle, |bench| {
        bench.begin("$C", 1);
        assert_eq!(bench.word(), "Check");
    };
    locked, 3, Some(0), State::Alarm(Alarm::SoftLimit { axis: Axis::X }), |bench| bench.begin("G1 X-1 F600", 1);
}
