//! The world at the pins in the emulator: carriages that steps move, and switches that they close. A board with a machine
//! has pins with interrupts here, as its HAL gives them.

use core::convert::Infallible;
use core::sync::atomic::{AtomicI32, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embedded_hal::digital::{ErrorType, InputPin};
use embedded_hal_async::digital::Wait;
use isostep_motion::AXES;

/// The distance of each carriage from its switch at power-up, steps. It closes from there on in the negative direction.
const FROM_SWITCH_STEPS: i32 = 300;

struct Carriage {
    place_steps: AtomicI32,
    changed: Signal<CriticalSectionRawMutex, ()>,
}

static CARRIAGES: [Carriage; AXES] =
    [const { Carriage { place_steps: AtomicI32::new(FROM_SWITCH_STEPS), changed: Signal::new() } }; AXES];

/// The carriage of an axis follows a step.
pub fn step(axis: usize, is_positive: bool) {
    let Carriage { place_steps, changed } = &CARRIAGES[axis];
    let (was, by) = (place_steps.load(Ordering::Relaxed), if is_positive { 1 } else { -1 });
    place_steps.store(was + by, Ordering::Relaxed);
    if is_closed(was) != is_closed(was + by) {
        changed.signal(());
    }
}

fn is_closed(place_steps: i32) -> bool {
    place_steps <= 0
}

/// The switch of an axis, to ground, with a pull-up: low is closed.
pub struct Switch(pub usize);

impl ErrorType for Switch {
    type Error = Infallible;
}

impl InputPin for Switch {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!is_closed(CARRIAGES[self.0].place_steps.load(Ordering::Relaxed)))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

impl Switch {
    async fn until(&mut self, high: bool) {
        while self.is_high() != Ok(high) {
            CARRIAGES[self.0].changed.wait().await;
        }
    }
}

impl Wait for Switch {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.until(true).await;
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.until(false).await;
        Ok(())
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        self.until(false).await;
        self.until(true).await;
        Ok(())
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        self.until(true).await;
        self.until(false).await;
        Ok(())
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        let is_high = self.is_high() == Ok(true);
        self.until(!is_high).await;
        Ok(())
    }
}
