//! Interprets G38.2 to G38.5.

use super::Interpreter;
use crate::{
    Error,
    command::Probe,
    words::block::{AxisCommand, BlockWords},
};

impl Interpreter {
    /// The probe of a block whose motion mode is one, if its axis words are for that mode; checked in Grbl's order. The
    /// program's position afterwards is the probe's target.
    // Writes to `probe` in place: a returned value would be copied on every line.
    #[cold]
    pub(super) fn probe(&mut self, words: &BlockWords, probe: &mut Option<Probe>) -> Result<(), Error> {
        if words.axis_command != Some(AxisCommand::Motion) {
            return Ok(());
        }
        self.check_feed()?;
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing);
        }
        let target_pm = self.target_pm(words)?;
        if target_pm == self.position_pm {
            return Err(Error::InvalidTarget);
        }
        let (mode, mm_min) = (self.modal.motion, self.feed_mm_min(target_pm, None, words));
        *probe = Some(Probe { target_pm, mm_min, away: mode.probes_away(), must: mode.must_touch() });
        self.position_pm = target_pm;
        Ok(())
    }
}
