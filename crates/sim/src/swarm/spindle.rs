//! What must be true of a spindle that a VFD turns: by what the simulated VFD does, not by what the machine knows of it.

use isostep_motion::{AXES, Alarm, Spindle, SpindleFault, SpindleWanted, State};

use super::judge::Broken;
use super::runner::LOOK_US;
use crate::config::Config;
use crate::sim::Sim;
use crate::vfd::{VfdFault, VfdKind};

/// Of a spindle that turns it is known so long after a fault how it turns, or else it is stopped.
const KNOWN_NS: u64 = 300_000_000;
/// The same time for a VFD that is to stop and can be told so.
const STOPPED_NS: u64 = 100_000_000;
/// A VFD whose wire works again is told so long after that what it has to do. The round that fails ends first.
const TOLD_ANEW_NS: u64 = 500_000_000;
/// A spindle whose speed is not reached may be found out after all of `$394`.
const FOUND_OUT_NS: u64 = 1_000_000_000;
const LOOK_NS: u64 = LOOK_US * 1_000;
const REACHES_DEFAULT_S: f64 = 10.0;

/// What was seen of a VFD and its spindle, from look to look.
#[derive(Default)]
pub(super) struct SpindleWatch {
    last: Option<Seen>,
    /// Since when it has had the speed that is wanted, as far as was seen, ns.
    at_speed_ns: Option<u64>,
    /// It has been at that speed.
    is_reached: bool,
    /// It has been there so long that the machine knows it too.
    is_known: bool,
    /// Since when it has left that, ns.
    off_ns: Option<u64>,
    /// Nothing is wrong with the VFD after this, unless it has not been told anew.
    pub wrong_until_ns: u64,
    /// Times in which consoles and coordinator got no processor time, and with them who talks to the VFD, ns.
    starved_ns: Vec<(u64, u64)>,
    now_ns: u64,
}

#[derive(Clone, Copy)]
struct Seen {
    at_ns: u64,
    wanted: SpindleWanted,
    state: State,
    steps: [u64; AXES],
    /// Below 0 counter-clockwise.
    hz: f64,
    is_told_to_run: bool,
    fault: Option<VfdFault>,
    fault_ns: u64,
    is_enabled: bool,
    enabled_ns: u64,
}

impl SpindleWatch {
    /// Something is wrong with the VFD until then.
    pub fn is_wrong_to(&mut self, until_ns: u64) {
        self.wrong_until_ns = self.wrong_until_ns.max(until_ns);
    }

    /// From now to then nobody talks to the VFD.
    pub fn starves_to(&mut self, until_ns: u64) {
        self.starved_ns.push((self.now_ns, until_ns));
    }

    /// So much later than `limit_ns` after `since_ns`, or less, because somebody got no processor time, ns.
    fn is_over(&self, since_ns: u64, limit_ns: u64) -> bool {
        let starved = |&(from_ns, to_ns): &(u64, u64)| to_ns.saturating_sub(from_ns.max(since_ns));
        let starved_ns: u64 = self.starved_ns.iter().map(starved).sum();
        self.now_ns > since_ns + limit_ns + starved_ns + LOOK_NS
    }

    /// Looks at the VFD, if there is one.
    pub fn look(&mut self, sim: &Sim, config: &Config) -> Result<(), Broken> {
        let Some(kind) = config.vfd else { return Ok(()) };
        let seen = Seen::of(sim);
        self.now_ns = seen.at_ns;
        let last = self.last.replace(seen).filter(|last| seen.at_ns <= last.at_ns + 2 * LOOK_NS);
        self.follow(&seen, last, config);
        let found = self.wrong(&seen, last, kind, config);
        let fault = seen.fault.map_or("no fault".to_owned(), |fault| fault.to_string());
        found.map_or(Ok(()), |promise| {
            let Seen { wanted, state, hz, is_enabled, .. } = seen;
            let ms = |ns: u64| (seen.at_ns - ns) / 1_000_000;
            let (fault_ms, enabled_ms) = (ms(seen.fault_ns), ms(seen.enabled_ns));
            let found = format!(
                "at {:.3} s in {state}: {hz:.1} Hz, {wanted:?}, enabled {is_enabled} since {enabled_ms} ms, {fault} since {fault_ms} ms",
                seen.at_ns as f64 / 1e9
            );
            Err((promise, found))
        })
    }

    /// Notes whether the spindle has its speed.
    fn follow(&mut self, seen: &Seen, last: Option<Seen>, config: &Config) {
        if last.is_none_or(|last| last.wanted != seen.wanted || last.enabled_ns != seen.enabled_ns) {
            (self.at_speed_ns, self.is_known, self.off_ns) = (None, false, None);
        }
        // An override is not waited for.
        if last.is_none_or(|last| last.wanted.turns != seen.wanted.turns) {
            self.is_reached = last.is_none();
        }
        let [off_hz, within_hz, word_hz] = seen.off_hz(config);
        if off_hz <= within_hz {
            let since_ns = *self.at_speed_ns.get_or_insert(seen.at_ns);
            self.is_reached = true;
            self.is_known |= self.is_over(since_ns, KNOWN_NS) && seen.fault.is_none();
        } else {
            self.at_speed_ns = None;
        }
        if off_hz > within_hz + 2.0 * word_hz {
            self.off_ns.get_or_insert(seen.at_ns);
        } else {
            self.off_ns = None;
        }
    }

    /// The promise that is broken, if one is.
    fn wrong(&self, seen: &Seen, last: Option<Seen>, kind: VfdKind, config: &Config) -> Option<&'static str> {
        if config.settings.laser_mode {
            return seen.is_told_to_run.then_some("a VFD beside a laser stands");
        }
        let alarm = match seen.state {
            State::Alarm(alarm) => Some(alarm),
            _ => None,
        };
        let turns = seen.is_enabled && seen.wanted.spindle != Spindle::Off;
        let fails = seen.fault.is_some_and(|fault| has_to_stop(fault, kind));
        if turns && fails && self.is_over(seen.fault_ns.max(seen.enabled_ns), KNOWN_NS) {
            return Some("a VFD that fails stops the machine");
        }
        if turns && self.is_known && self.off_ns.is_some_and(|off_ns| self.is_over(off_ns, KNOWN_NS)) {
            return Some("a spindle that leaves its speed stops the machine");
        }
        let can_be_told_ns = if seen.fault_ns == 0 { 0 } else { seen.fault_ns + TOLD_ANEW_NS };
        let stops_ns = (seen.enabled_ns + STOPPED_NS).max(can_be_told_ns);
        if !seen.is_enabled && seen.is_told_to_run && seen.fault.is_none() && self.is_over(stops_ns, 0) {
            return Some("a VFD is told to stop when the spindle is to stand");
        }
        let has_moved = |last: Seen| last.steps != seen.steps && last.wanted == seen.wanted;
        let was_well = self.is_over(seen.fault_ns, KNOWN_NS) || seen.fault_ns == 0;
        if turns && was_well && !self.is_reached && last.is_some_and(has_moved) {
            return Some("nothing moves before the VFD has its speed");
        }
        let is_new = last.is_some_and(|last| last.state != seen.state);
        let reaches_s = match config.settings.spin_up_s {
            0.0 => REACHES_DEFAULT_S,
            s => f64::from(s),
        };
        let cause_ns = match alarm {
            Some(Alarm::SpindleFailed { fault: SpindleFault::Drive }) => KNOWN_NS,
            Some(Alarm::SpindleFailed { fault: SpindleFault::Speed }) => (reaches_s * 1e9) as u64 + FOUND_OUT_NS,
            _ => return None,
        };
        let is_caused = self.wrong_until_ns > 0 && !self.is_over(self.wrong_until_ns, cause_ns);
        (is_new && !is_caused).then_some("no VFD is said to fail that does not")
    }
}

impl Seen {
    fn of(sim: &Sim) -> Self {
        let (machine, steps) = (sim.machine(), sim.steps());
        let (wanted, state, at_ns) = (machine.spindle_wanted(), machine.state(), sim.now_ns());
        sim.vfd(|vfd| {
            let ((fault, fault_ns), (is_enabled, enabled_ns)) = (vfd.fault(), vfd.enabled());
            let (hz, is_told_to_run) = (vfd.output_hz(), vfd.is_told_to_run());
            Self { at_ns, wanted, state, steps, hz, is_told_to_run, fault, fault_ns, is_enabled, enabled_ns }
        })
    }

    /// How far the spindle is from the speed that is wanted, how far it may be, and the least that a VFD's word tells of, Hz.
    fn off_hz(&self, config: &Config) -> [f64; 3] {
        let settings = &config.settings;
        let rpm = f64::from(self.wanted.level.ratio()) * f64::from(settings.spindle_max_rpm);
        let hz = rpm / f64::from(settings.vfd_rpm_per_hz);
        let word_hz = match config.vfd {
            Some(VfdKind::Yl620 | VfdKind::H100) => 0.1,
            _ => 0.01,
        };
        let within_hz = (hz * f64::from(settings.at_speed_percent) / 100.0).max(word_hz) + word_hz;
        let wanted_hz = match self.wanted.spindle {
            Spindle::Off => 0.0,
            Spindle::Clockwise => hz,
            Spindle::CounterClockwise => -hz,
        };
        [(self.hz - wanted_hz).abs(), within_hz, word_hz]
    }
}

/// True if nothing is known of the spindle with this fault, or if the VFD says that it has failed. Of other faults its speed tells.
fn has_to_stop(fault: VfdFault, kind: VfdKind) -> bool {
    use VfdFault::{Cut, Garbled, Off, OtherAddress, Refuses, Tripped};
    let says_faults = matches!(kind, VfdKind::Gs20 | VfdKind::Nowforever);
    matches!(fault, Cut | Garbled | Off | OtherAddress | Refuses) || fault == Tripped && says_faults
}
