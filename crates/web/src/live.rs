//! A machine at power-up, to be operated.

use isostep_motion::{AXES, Axis};
use isostep_sim::{Sim, SwitchFault, plate::Plate, verify::Verdict};

use crate::motion::Motion;
use crate::trouble::Trouble;
use crate::watch::Watch;
use crate::{Kept, config};

/// Bytes per second of the console's link are Grbl's.
const BAUD: u32 = 115_200;

/// The machine. Its console is on a serial line, as that of a board.
pub struct Live {
    sim: Sim,
    watch: Watch,
}

impl Live {
    /// A machine with these settings, lines of `$n=v`.
    ///
    /// # Errors
    /// [`Trouble`] with the line of the settings that cannot be.
    pub fn new(settings: &str) -> Result<Self, Trouble> {
        let mut config = config(settings)?;
        config.baud = Some(BAUD);
        Ok(Self { sim: Sim::new(&config), watch: Watch::new(Kept::Nothing) })
    }

    /// Sends bytes to its console.
    pub fn send(&mut self, bytes: &[u8]) {
        self.sim.send(bytes);
    }

    /// The bytes from its console since this was asked last.
    pub fn take_output(&mut self) -> Vec<u8> {
        self.sim.received()
    }

    /// Runs to `until_us` since power-up, or not at all if that has passed.
    ///
    /// # Errors
    /// [`Trouble`] if tasks wake each other for ever.
    pub fn advance(&mut self, until_us: f64) -> Result<(), Trouble> {
        self.sim.run_to((until_us * 1e3) as u64)?;
        let piece = self.sim.take_piece();
        self.watch.add(&piece);
        Ok(())
    }

    /// Machine time, us since power-up.
    pub fn now_us(&self) -> f64 {
        self.sim.now_ns() as f64 * 1e-3
    }

    /// The motion of the axes since this was asked last, by moves that are over.
    pub fn take_motion(&mut self) -> Motion {
        self.watch.take_motion()
    }

    /// The places of the carriages now, by the count of edges, mm.
    pub fn position_mm(&self) -> [f64; AXES] {
        self.sim.machine().config().mm_at(self.sim.counted_steps())
    }

    /// Presses or releases the emergency stop.
    pub fn set_emergency_stop(&mut self, is_pressed: bool) {
        self.sim.set_emergency_stop(is_pressed);
    }

    /// Presses the limit switch of an axis, as if something stood against it, or lets it go.
    pub fn set_limit(&mut self, axis: usize, is_pressed: bool) {
        if let Some(&axis) = Axis::ALL.get(axis) {
            self.sim.set_switch(axis, if is_pressed { SwitchFault::StuckClosed } else { SwitchFault::None });
        }
    }

    /// Puts a plate under the tool for the probe to touch, this far above the limit switch of Z, or takes it away.
    pub fn set_plate(&mut self, place_mm: Option<f64>) {
        self.sim.set_plate(place_mm.map(|place_mm| Plate { axis: Axis::Z, place_mm, is_below: true }));
    }

    /// The verdicts on the promises that do not need an end, so far.
    pub fn verdicts(&self) -> Vec<Verdict> {
        self.watch.gathered.verdicts(&self.sim.outcome())
    }
}
