//! Buttons and the safety door: debounced inputs that hold and resume.

use core::convert::Infallible;

use embedded_hal::digital::InputPin;
use embedded_hal_async::digital::Wait;

use crate::limit::{debounced_low, wait_level};
use crate::machine::Machine;

/// Watches the button of the feed hold for ever. It is wired to ground with a pull-up, so low is pressed. Its first
/// edge holds the machine. If the configuration says so, the input is the safety door's switch instead, low while the
/// door is open.
///
/// # Cancellation
/// Dropping it leaves the input unwatched; nothing moves.
pub async fn watch_hold<I: InputPin<Error = Infallible> + Wait>(machine: &Machine, mut input: I) -> ! {
    loop {
        wait_level(&mut input, true).await;
        // At once, not debounced: a false hold costs less than a late one.
        machine.set_hold_input(true);
        while debounced_low(&mut input, machine.config().homing.debounce).await {
            wait_level(&mut input, false).await;
        }
        machine.set_hold_input(false);
    }
}

/// Watches the button of the cycle start for ever. It is wired to ground with a pull-up, so low is pressed. Pressed for
/// the debounce time it resumes a held machine.
///
/// # Cancellation
/// Dropping it leaves the input unwatched; nothing moves.
pub async fn watch_start<I: InputPin<Error = Infallible> + Wait>(machine: &Machine, mut input: I) -> ! {
    loop {
        wait_level(&mut input, true).await;
        if !debounced_low(&mut input, machine.config().homing.debounce).await {
            continue;
        }
        machine.resume();
        machine.set_start_button(true);
        loop {
            wait_level(&mut input, false).await;
            if !debounced_low(&mut input, machine.config().homing.debounce).await {
                break;
            }
        }
        machine.set_start_button(false);
    }
}
