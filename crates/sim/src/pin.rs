//! The controller's pins. They implement `embedded-hal`, and are connected to the [`World`](crate::world::World).

use std::convert::Infallible;
use std::future::poll_fn;
use std::task::Poll;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::digital::Wait;

use crate::record::Wire;
use crate::time::Clock;
use crate::world::Shared;

/// An output pin of the controller.
pub struct Output {
    world: Shared,
    wire: Wire,
}

impl Output {
    /// The output that drives `wire`.
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

/// A delay that blocks the task that owns it.
pub struct Delay {
    clock: Clock,
}

impl Delay {
    /// Delays on the time of `clock`.
    pub fn new(clock: &Clock) -> Self {
        Self { clock: clock.clone() }
    }
}

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        self.clock.spend(ns.into());
    }
}

/// An input pin of the controller, with a pull-up.
pub struct Input {
    world: Shared,
    wire: Wire,
}

impl Input {
    /// The input that reads `wire`.
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

/// Edges count from the moment of the call, so an edge that comes before the task is polled again is not missed.
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

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use embassy_time::{Instant, Timer};
    use isostep_motion::Axis;

    use super::*;
    use crate::config::Config;
    use crate::executor::Executor;
    use crate::world::World;

    /// The edges that a task that waits for them sees while another task moves X onto its switch, 3 steps away, and back off
    /// it.
    #[test]
    fn edges_reach_the_task_that_waits_for_them() {
        let mut executor = Executor::new();
        let config = Config { start_mm: [0.06, 1.0, 1.0], bounce_us: 0, ..Config::default() };
        let world = Rc::new(RefCell::new(World::new(executor.clock().clone(), &config)));
        let mut limit = Input::new(&world, Wire::Limit(Axis::X.into()));
        let seen = Rc::new(RefCell::new(Vec::new()));
        let noted = seen.clone();
        executor.spawn("watch", async move {
            let note = |what| noted.borrow_mut().push((Instant::now().as_millis(), what));
            limit.wait_for_high().await.unwrap();
            note("high");
            limit.wait_for_falling_edge().await.unwrap();
            note("fell");
            limit.wait_for_low().await.unwrap();
            note("low");
            limit.wait_for_any_edge().await.unwrap();
            note("changed");
            limit.wait_for_rising_edge().await.unwrap();
            note("never: it is high already");
        });
        executor.spawn("walk", walk(world.clone()));
        executor.run_until_quiescent(Instant::from_secs(1)).unwrap();
        assert_eq!(*seen.borrow(), [(0, "high"), (15, "fell"), (15, "low"), (31, "changed")]);
        assert_eq!(world.borrow().counted_steps(), [-1, 0, 0]);
        assert_eq!(world.borrow().record().violations, []);
    }

    async fn walk(world: Shared) {
        let mut dir = Output::new(&world, Wire::Dir(Axis::X.into()));
        let mut step = Output::new(&world, Wire::Step(Axis::X.into()));
        Output::new(&world, Wire::Enable).set_low().unwrap();
        for (wait_ms, away, steps) in [(10, false, 4), (10, true, 3)] {
            if away { dir.set_high() } else { dir.set_low() }.unwrap();
            Timer::after_millis(wait_ms).await;
            for _ in 0..steps {
                Timer::after_micros(1_998).await;
                step.set_high().unwrap();
                Timer::after_micros(2).await;
                step.set_low().unwrap();
            }
        }
    }
}
