//! The inputs of the controller: limit switches, whose contacts bounce, the emergency stop, the probe, the buttons, the alarms of drives.

use std::future::poll_fn;
use std::task::{Poll, Waker};

use embassy_futures::select::select;
use isostep_motion::{AXES, Axis, Contact, GangedMotor, Motor as Moving};

use super::{SECOND, Shared};
use crate::record::Wire;

/// An input of the controller.
pub(super) struct Input {
    pub(super) wire: Wire,
    pub(super) high: bool,
    pub(super) rises: u32,
    pub(super) falls: u32,
    pub(super) wakers: Vec<Waker>,
}

/// The emergency stop, wired from the input to ground.
pub(super) struct EmergencyStop {
    pub(super) contact: Contact,
    pub(super) is_pressed: bool,
    /// The wire is broken.
    pub(super) is_cut: bool,
}

impl EmergencyStop {
    pub(super) fn is_high(&self) -> bool {
        self.is_cut || self.is_pressed != self.contact.pressed_is_low()
    }
}

/// The limit switches: those of the axes, then the second motor's.
const LIMITS: usize = AXES + 1;
/// The inputs that do not belong to an axis.
const HAND_INPUTS: [Wire; 4] = [Wire::EmergencyStop, Wire::Probe, Wire::Hold, Wire::Start];

/// The alarms of the axes' drives.
const DRIVE_ALARMS: usize = LIMITS + HAND_INPUTS.len();

pub(super) const INPUTS: usize = DRIVE_ALARMS + AXES;

/// All inputs, high, on a machine with a second motor on this axis.
pub(super) fn all(second: Option<Axis>) -> [Input; INPUTS] {
    std::array::from_fn(|index| match Axis::ALL.get(index) {
        Some(&axis) => Input::new(Wire::Limit(axis.into())),
        None if index == SECOND => Input::new(Wire::Limit(Moving::second(second.unwrap_or(Axis::X)))),
        None if index < DRIVE_ALARMS => Input::new(HAND_INPUTS[index - LIMITS]),
        None => Input::new(Wire::DriveAlarm(Axis::ALL[index - DRIVE_ALARMS])),
    })
}

impl Input {
    fn new(wire: Wire) -> Self {
        Self { wire, high: true, rises: 0, falls: 0, wakers: Vec::new() }
    }
}

/// The place of a wire among the inputs.
pub(super) fn index(wire: Wire) -> usize {
    match wire {
        Wire::Limit(motor) => {
            if motor.ganged == GangedMotor::First {
                motor.axis as usize
            } else {
                SECOND
            }
        }
        Wire::EmergencyStop => LIMITS,
        Wire::Probe => LIMITS + 1,
        Wire::Hold => LIMITS + 2,
        Wire::Start => LIMITS + 3,
        Wire::DriveAlarm(axis) => DRIVE_ALARMS + axis as usize,
        Wire::Step(_) | Wire::Dir(_) | Wire::Enable => unreachable!("an output of the controller"),
    }
}

/// The task that makes switches bounce. Never ends.
///
/// # Cancellation
/// Dropping it freezes the contacts in their present state; no axis is affected.
pub async fn bounce(world: Shared) {
    let clock = world.borrow().clock.clone();
    loop {
        let next_flip_ns = world.borrow().next_flip_ns();
        let Some(at_ns) = next_flip_ns else {
            bounce_begins(&world).await;
            continue;
        };
        // A new bounce may come earlier than the awaited one.
        select(clock.until(at_ns), bounce_begins(&world)).await;
        world.borrow_mut().flip();
    }
}

async fn bounce_begins(world: &Shared) {
    let mut asked = false;
    poll_fn(|context| {
        if std::mem::replace(&mut asked, true) && world.borrow().bouncer.is_none() {
            return Poll::Ready(());
        }
        world.borrow_mut().bouncer = Some(context.waker().clone());
        Poll::Pending
    })
    .await;
}
