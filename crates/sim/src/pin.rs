//! The controller's pins: `embedded-hal` at one end, the [`World`](crate::world::World) at the other.

use std::convert::Infallible;
use std::future::poll_fn;
use std::task::Poll;

use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::digital::Wait;

use crate::world::{Shared, Wire};

/// A pin that the controller drives.
pub struct Output {
    world: Shared,
    wire: Wire,
}

impl Output {
    /// Drives `wire`.
    pub fn new(world: &Shared, wire: Wire) -> Self {
        Self { world: world.clone(), wire }
    }
}

impl ErrorType for Output {
    type Error = Infallible;
}

impl OutputPin for Output {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.world.borrow_mut().drive(self.wire, false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.world.borrow_mut().drive(self.wire, true);
        Ok(())
    }
}

/// A pin that the controller reads, with a pull-up.
pub struct Input {
    world: Shared,
    wire: Wire,
}

impl Input {
    /// Reads `wire`.
    pub fn new(world: &Shared, wire: Wire) -> Self {
        Self { world: world.clone(), wire }
    }

    async fn until(&self, holds: impl Fn(&Self) -> bool) {
        poll_fn(|context| {
            if holds(self) {
                return Poll::Ready(());
            }
            self.world.borrow_mut().wake_on_change(self.wire, context.waker());
            Poll::Pending
        })
        .await;
    }

    fn high(&self) -> bool {
        self.world.borrow().is_high(self.wire)
    }

    fn flanks(&self) -> (u32, u32) {
        self.world.borrow().flanks(self.wire)
    }
}

impl ErrorType for Input {
    type Error = Infallible;
}

impl InputPin for Input {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.high())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.high())
    }
}

/// Edges count from the call on, so one that comes before the task is polled again is not missed.
impl Wait for Input {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        let (rises, _) = self.flanks();
        self.until(|pin| pin.high() || pin.flanks().0 != rises).await;
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        let (_, falls) = self.flanks();
        self.until(|pin| !pin.high() || pin.flanks().1 != falls).await;
        Ok(())
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        let (rises, _) = self.flanks();
        self.until(|pin| pin.flanks().0 != rises).await;
        Ok(())
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        let (_, falls) = self.flanks();
        self.until(|pin| pin.flanks().1 != falls).await;
        Ok(())
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        let flanks = self.flanks();
        self.until(|pin| pin.flanks() != flanks).await;
        Ok(())
    }
}
