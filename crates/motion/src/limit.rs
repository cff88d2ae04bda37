//! Limit switches, the alarms of drives and the emergency stop: they are debounced, and yet stop the machine at once.

use core::convert::Infallible;

use embassy_futures::select::select;
use embassy_time::{Duration, with_timeout};
use embedded_hal::digital::InputPin;
use embedded_hal_async::digital::Wait;

use crate::machine::Machine;
use crate::motor::LimitInput;

/// Watches a limit switch for ever. It is wired to ground with a pull-up, so low is pressed (unless the configuration
/// inverts that). The first edge of a press stops a running machine at once, and ends the seek of homing. The status, and homing at
/// rest, see the debounced level. `which` says whose switch `input` is.
///
/// Where the input is a driver's that says when its motor stalls, high is pressed, from the first edge on: a driver does not
/// bounce, and each step that is made meanwhile is lost. The alarm of a drive is as a switch, but stops a machine at rest and in homing
/// too, and need not have begun meanwhile: one that is there at first locks it.
///
/// # Cancellation
/// Dropping it leaves the last debounced level of the switch in place and its axis unwatched; nothing moves.
pub async fn watch<I>(machine: &Machine, which: LimitInput, mut input: I) -> !
where
    I: InputPin<Error = Infallible> + Wait,
{
    let switch = machine.switch(which);
    loop {
        let (pressed_is_low, is_stall, debounce) = meaning(machine, which);
        // A drive that is in alarm already stops the machine as one that begins to be.
        let mut pressed = !matches!(which, LimitInput::Alarm(_)) && is_low(&mut input) == pressed_is_low;
        machine.publish_switch(which, pressed);
        // Until a level of the input may mean something else.
        while select(wait_level(&mut input, pressed != pressed_is_low), switch.wait_reread()).await.is_first() {
            // At rest this edge stops nothing. But a motion that is asked for before the switch is debounced must not go
            // further onto it.
            switch.touch();
            machine.limit_edge(which, pressed != pressed_is_low);
            pressed = !pressed && is_stall || debounced_low(&mut input, debounce).await == pressed_is_low;
            machine.publish_switch(which, pressed);
        }
    }
}

/// The meaning of low (pressed or not) and of pressed (a stall or not), and the time that a level must be steady.
fn meaning(machine: &Machine, which: LimitInput) -> (bool, bool, Duration) {
    let config = machine.config();
    (config.press(which).1, config.is_stall(which), config.homing.debounce)
}

/// Watches the emergency stop for ever. It is wired to ground with a pull-up, so low is pressed, or high if the
/// machine's contact is normally closed. Its first edge stops the machine and locks it. The motors stay energised, so
/// that nothing falls.
///
/// # Cancellation
/// Dropping it leaves the emergency stop unwatched; nothing moves.
pub async fn watch_emergency_stop<I>(machine: &Machine, mut input: I) -> !
where
    I: InputPin<Error = Infallible> + Wait,
{
    let pressed_low = machine.emergency_contact().pressed_is_low();
    loop {
        // The board may have reported a press that was too short for the input to be seen here.
        select(wait_level(&mut input, pressed_low), machine.wait_emergency()).await;
        machine.set_emergency(true);
        while debounced_low(&mut input, machine.config().homing.debounce).await == pressed_low {
            wait_level(&mut input, !pressed_low).await;
        }
        machine.set_emergency(false);
    }
}

fn is_low(input: &mut impl InputPin<Error = Infallible>) -> bool {
    let Ok(low) = input.is_low();
    low
}

pub(crate) async fn wait_level<I: InputPin<Error = Infallible> + Wait>(input: &mut I, low: bool) {
    let Ok(()) = if low { input.wait_for_low().await } else { input.wait_for_high().await };
}

/// The level once it has been steady for `debounce`.
pub(crate) async fn debounced_low<I: InputPin<Error = Infallible> + Wait>(input: &mut I, debounce: Duration) -> bool {
    while with_timeout(debounce, input.wait_for_any_edge()).await.is_ok() {}
    is_low(input)
}
