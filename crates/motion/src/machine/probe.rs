//! The probe: whether it touches, and when it did.

use embassy_time::Instant;

use super::Machine;
use crate::axes::AXES;

/// The result of the last motion that probed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Probed {
    /// The contact changed during the motion.
    pub touched: bool,
    /// The place where it changed, or where the motion ended, steps.
    pub position_steps: [i32; AXES],
}

/// The state of the probe, as far as it is known.
#[derive(Clone, Copy)]
pub(super) struct ProbeInput {
    /// The input is low.
    is_low: bool,
    /// The change that is looked for: contact (`true`) or its end (`false`).
    sought: Option<bool>,
    /// The instant at which that was found.
    found: Option<Instant>,
    last: Probed,
}

impl ProbeInput {
    pub const fn new() -> Self {
        Self { is_low: false, sought: None, found: None, last: Probed { touched: false, position_steps: [0; AXES] } }
    }

    fn touches(&self, inverted: bool) -> bool {
        self.is_low != inverted
    }
}

impl Machine {
    /// The probe's input has changed, and is now low or high. It may be called any number of times, from any context,
    /// and has to be called once at power-up. The instant of the call counts as that of the contact, so a delay of the
    /// call is an error of the measured place.
    pub fn probe_edge(&self, is_low: bool) {
        let now = Instant::now();
        let is_found = self.with(|inner| {
            let inverted = inner.config.probe_inverted;
            inner.probe.is_low = is_low;
            let is_found = inner.probe.found.is_none() && inner.probe.sought == Some(inner.probe.touches(inverted));
            if is_found {
                inner.probe.found = Some(now);
            }
            is_found
        });
        if is_found {
            self.wake();
        }
    }

    /// True if the probe touches now.
    #[must_use]
    pub fn probe_touches(&self) -> bool {
        self.with(|inner| inner.probe.touches(inner.config.probe_inverted))
    }

    /// The result of the last motion that probed.
    #[must_use]
    pub fn probed(&self) -> Probed {
        self.with(|inner| inner.probe.last)
    }
}

/// For the coordinator.
impl Machine {
    /// Looks for contact (`true`) or for its end (`false`) from now on; returns false if the probe is in that state
    /// already.
    pub(crate) fn seek_contact(&self, contact: bool) -> bool {
        self.with(|inner| {
            let is_there = inner.probe.touches(inner.config.probe_inverted) == contact;
            (inner.probe.sought, inner.probe.found) = ((!is_there).then_some(contact), None);
            !is_there
        })
    }

    /// The instant at which what is looked for was found.
    pub(crate) fn contact_at(&self) -> Option<Instant> {
        self.with(|inner| inner.probe.found)
    }

    /// Ends the search for a contact, with this result.
    pub(crate) fn set_probed(&self, probed: Probed) {
        self.with(|inner| (inner.probe.sought, inner.probe.last) = (None, probed));
    }
}
