//! The probe: whether it touches, and when it did.

use embassy_time::Instant;

use super::Machine;
use crate::axes::AXES;

/// What came of the last motion that probed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Probed {
    /// The contact changed on the way.
    pub touched: bool,
    /// Where it did, or where the way ended, steps.
    pub position_steps: [i32; AXES],
}

/// What is known of the probe.
#[derive(Clone, Copy)]
pub(super) struct Probe {
    /// The input is low.
    is_low: bool,
    /// Looked for: contact, or its end.
    sought: Option<bool>,
    /// When it came.
    found: Option<Instant>,
    last: Probed,
}

impl Probe {
    pub const fn new() -> Self {
        Self { is_low: false, sought: None, found: None, last: Probed { touched: false, position_steps: [0; AXES] } }
    }

    fn touches(&self, inverted: bool) -> bool {
        self.is_low != inverted
    }
}

impl Machine {
    /// The probe's input has changed, and is low or high. Any number of times, from any context, and once at power-up. The
    /// instant counts as that of the contact: a delay is as much of an error.
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
            self.ask();
        }
    }

    /// Whether the probe touches now.
    #[must_use]
    pub fn probe_touches(&self) -> bool {
        self.with(|inner| inner.probe.touches(inner.config.probe_inverted))
    }

    /// What came of the last motion that probed.
    #[must_use]
    pub fn probed(&self) -> Probed {
        self.with(|inner| inner.probe.last)
    }
}

/// For the coordinator.
impl Machine {
    /// Looks for contact (`true`) or for its end from now on; false if that is so already.
    pub(crate) fn seek_contact(&self, contact: bool) -> bool {
        self.with(|inner| {
            let is_there = inner.probe.touches(inner.config.probe_inverted) == contact;
            (inner.probe.sought, inner.probe.found) = ((!is_there).then_some(contact), None);
            !is_there
        })
    }

    /// When what is looked for came.
    pub(crate) fn contact_at(&self) -> Option<Instant> {
        self.with(|inner| inner.probe.found)
    }

    /// Looks for contact no more.
    pub(crate) fn set_probed(&self, probed: Probed) {
        self.with(|inner| (inner.probe.sought, inner.probe.last) = (None, probed));
    }
}
