//! A deterministic executor in virtual time.
//!
//! Tasks are spawned once, by name. Of the tasks that are ready, the one spawned first runs first, as
//! a higher interrupt priority would on the chip; when none is ready time jumps to the next deadline. Nothing
//! here reads a wall clock, a thread's schedule or an address, so a run is a function of its tasks.

use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

use embassy_time::{Duration, Instant};

use crate::time::{self, Clock};

/// Polls without time moving on that no honest set of tasks needs: beyond, they wake each other for ever.
const POLLS_PER_INSTANT_MAX: u32 = 1_000_000;

/// Why [`Executor::run_until`] gave up.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RunError {
    /// Nothing is ready and nothing waits for an instant: only the outside could move this on.
    #[error("deadlock at {}: nothing is due, and these tasks wait: {}", Seconds(*.at), .waiting.join(", "))]
    Deadlock {
        /// When the last task went to sleep.
        at: Instant,
        /// The tasks that have not ended, in the order they were spawned.
        waiting: Vec<&'static str>,
    },
    /// The virtual time allowed is used up.
    #[error("not done at {}, the limit of virtual time: is there a dwell or a move that long?", Seconds(*.limit))]
    TimeLimit {
        /// The instant that was not to be passed.
        limit: Instant,
        /// The tasks that have not ended, in the order they were spawned.
        waiting: Vec<&'static str>,
    },
    /// Tasks keep waking each other without letting time pass.
    #[error("livelock at {}: {POLLS_PER_INSTANT_MAX} polls and no time passed, the last of task {task}", Seconds(*.at))]
    Livelock {
        /// Where time stands still.
        at: Instant,
        /// The task polled last.
        task: &'static str,
    },
}

/// How a run came to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Nothing is ready and no deadline is pending.
    Quiescent,
    /// The horizon was reached first.
    Horizon,
}

struct Task {
    name: &'static str,
    ready: Arc<Ready>,
    waker: Waker,
    future: Option<Pin<Box<dyn Future<Output = ()>>>>,
    /// When it is through with the blocking delays of its last poll, since power-up.
    free_ns: u64,
}

struct Ready(AtomicBool);

impl Wake for Ready {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Named tasks and the clock they live by.
#[derive(Default)]
pub struct Executor {
    clock: Clock,
    tasks: Vec<Task>,
}

impl Executor {
    /// An executor without tasks, at power-up.
    pub fn new() -> Self {
        Self::default()
    }

    /// The clock its tasks live by.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Adds a task; those spawned earlier go first when several are ready.
    pub fn spawn(&mut self, name: &'static str, future: impl Future<Output = ()> + 'static) {
        let ready = Arc::new(Ready(AtomicBool::new(true)));
        let waker = Waker::from(ready.clone());
        self.tasks.push(Task { name, ready, waker, future: Some(Box::pin(future)), free_ns: 0 });
    }

    /// Runs until `done` holds (looked at whenever no task is ready), not beyond `limit`.
    ///
    /// # Errors
    /// [`RunError`]: deadlock, time limit or livelock, whichever comes before `done`.
    pub fn run_until(&mut self, limit: Instant, done: impl FnMut() -> bool) -> Result<(), RunError> {
        self.run_until_ns(time::ns(limit), done)
    }

    fn run_until_ns(&mut self, limit_ns: u64, mut done: impl FnMut() -> bool) -> Result<(), RunError> {
        let _current = self.clock.clone().enter();
        loop {
            self.run_ready()?;
            if done() {
                return Ok(());
            }
            match self.next_ns() {
                None => return Err(RunError::Deadlock { at: self.clock.now(), waiting: self.waiting() }),
                Some(at_ns) if at_ns > limit_ns => {
                    let limit = Instant::from_nanos(limit_ns);
                    return Err(RunError::TimeLimit { limit, waiting: self.waiting() });
                }
                Some(at_ns) => self.clock.advance_to(at_ns),
            }
        }
    }

    /// Runs until nothing can happen any more without the outside, or until `horizon`.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_until_quiescent(&mut self, horizon: Instant) -> Result<Rest, RunError> {
        self.run_until_quiescent_ns(time::ns(horizon))
    }

    fn run_until_quiescent_ns(&mut self, horizon_ns: u64) -> Result<Rest, RunError> {
        match self.run_until_ns(horizon_ns, || false) {
            Err(RunError::Deadlock { .. }) => Ok(Rest::Quiescent),
            Err(RunError::TimeLimit { .. }) => Ok(Rest::Horizon),
            Err(livelock) => Err(livelock),
            Ok(()) => unreachable!("the condition never holds"),
        }
    }

    /// Runs for `duration`: the clock stands exactly that much later afterwards.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_for(&mut self, duration: Duration) -> Result<(), RunError> {
        self.run_to(self.clock.now_ns() + duration.as_nanos())
    }

    /// Runs to `at_ns` since power-up, where the clock then stands; not at all when that is past.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_to(&mut self, at_ns: u64) -> Result<(), RunError> {
        self.run_until_quiescent_ns(at_ns)?;
        self.clock.advance_to(at_ns);
        Ok(())
    }

    /// The names of the tasks that have not ended.
    pub fn waiting(&self) -> Vec<&'static str> {
        self.tasks.iter().filter(|task| task.future.is_some()).map(|task| task.name).collect()
    }

    fn run_ready(&mut self) -> Result<(), RunError> {
        for _ in 0..POLLS_PER_INSTANT_MAX {
            let now_ns = self.clock.now_ns();
            let Some(task) = self.tasks.iter_mut().find(|task| task.is_awake() && task.free_ns <= now_ns) else {
                return Ok(());
            };
            task.poll();
            task.free_ns = self.clock.end_poll();
        }
        let task = self.tasks.iter().find(|task| task.is_awake()).map_or("none", |task| task.name);
        Err(RunError::Livelock { at: self.clock.now(), task })
    }

    /// When something happens next, since power-up: a deadline, or a task that was woken while in a blocking delay is
    /// through with it.
    fn next_ns(&self) -> Option<u64> {
        let delayed = self.tasks.iter().filter(|task| task.is_awake()).map(|task| task.free_ns);
        self.clock.next_deadline_ns().into_iter().chain(delayed).min()
    }
}

impl Task {
    fn is_awake(&self) -> bool {
        self.future.is_some() && self.ready.0.load(Ordering::Relaxed)
    }

    fn poll(&mut self) {
        self.ready.0.store(false, Ordering::Relaxed);
        let Some(future) = &mut self.future else { return };
        if let Poll::Ready(()) = future.as_mut().poll(&mut Context::from_waker(&self.waker)) {
            self.future = None;
        }
    }
}

/// An instant as seconds since power-up, for people.
struct Seconds(Instant);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:06} s", self.0.as_micros() / 1_000_000, self.0.as_micros() % 1_000_000)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use embassy_futures::select::select;
    use embassy_futures::yield_now;
    use embassy_time::Timer;

    use super::*;

    type Log = Rc<RefCell<Vec<(u64, &'static str)>>>;

    const LATE: Instant = Instant::from_secs(3600);

    fn note(log: &Log, what: &'static str) {
        log.borrow_mut().push((Instant::now().as_micros(), what));
    }

    async fn ticker(log: Log, name: &'static str, every_us: u64, times: u32) {
        for _ in 0..times {
            Timer::after_micros(every_us).await;
            note(&log, name);
        }
    }

    #[test]
    fn time_stops_at_every_deadline_in_between() {
        let mut executor = Executor::new();
        let log = Log::default();
        executor.spawn("chain", ticker(log.clone(), "chain", 100, 3));
        executor.spawn("long", ticker(log.clone(), "long", 250, 1));
        executor.run_for(Duration::from_millis(1)).unwrap();
        assert_eq!(*log.borrow(), [(100, "chain"), (200, "chain"), (250, "long"), (300, "chain")]);
        assert_eq!(executor.clock().now(), Instant::from_millis(1));
        assert!(executor.waiting().is_empty());
    }

    #[test]
    fn tasks_due_together_run_in_the_order_they_were_spawned() {
        let mut executor = Executor::new();
        let log = Log::default();
        for name in ["first", "second", "third"] {
            executor.spawn(name, ticker(log.clone(), name, 10, 2));
        }
        executor.run_for(Duration::from_millis(1)).unwrap();
        let names: Vec<_> = log.borrow().iter().map(|(_, name)| *name).collect();
        assert_eq!(names, ["first", "second", "third", "first", "second", "third"]);
    }

    #[test]
    fn an_abandoned_timer_wakes_its_task_once_at_most() {
        let mut executor = Executor::new();
        let log = Log::default();
        let task_log = log.clone();
        executor.spawn("select", async move {
            select(Timer::after_micros(10), Timer::after_secs(10)).await;
            note(&task_log, "early");
            Timer::after_secs(20).await;
            note(&task_log, "late");
        });
        assert_eq!(executor.run_until_quiescent(LATE), Ok(Rest::Quiescent));
        assert_eq!(*log.borrow(), [(10, "early"), (20_000_010, "late")]);
    }

    #[test]
    fn a_deadlock_names_the_tasks_that_wait() {
        let mut executor = Executor::new();
        executor.spawn("waits", std::future::pending());
        executor.spawn("ends", async { Timer::after_millis(3).await });
        let error = executor.run_until(LATE, || false).unwrap_err();
        assert_eq!(error, RunError::Deadlock { at: Instant::from_millis(3), waiting: vec!["waits"] });
        assert_eq!(error.to_string(), "deadlock at 0.003000 s: nothing is due, and these tasks wait: waits");
    }

    #[test]
    fn the_time_limit_and_the_livelock_are_errors() {
        let mut executor = Executor::new();
        let log = Log::default();
        executor.spawn("ticks", ticker(log, "ticks", 1_000_000, u32::MAX));
        let limit = Instant::from_secs(5);
        let error = executor.run_until(limit, || false).unwrap_err();
        assert_eq!(error, RunError::TimeLimit { limit, waiting: vec!["ticks"] });
        executor.spawn("spins", async {
            loop {
                yield_now().await;
            }
        });
        let error = executor.run_until(LATE, || false).unwrap_err();
        assert_eq!(error, RunError::Livelock { at: limit, task: "spins" });
    }

    #[test]
    fn a_blocking_delay_holds_up_its_own_task_alone() {
        let mut executor = Executor::new();
        let log = Log::default();
        for name in ["one", "two"] {
            let (log, clock) = (log.clone(), executor.clock().clone());
            executor.spawn(name, async move {
                Timer::after_micros(10).await;
                clock.spend(2_000);
                note(&log, name);
                yield_now().await;
                note(&log, name);
            });
        }
        executor.run_until_quiescent(LATE).unwrap();
        assert_eq!(*log.borrow(), [(12, "one"), (12, "two"), (12, "one"), (12, "two")]);
    }

    #[test]
    fn time_is_finer_than_the_drivers_tick() {
        let mut executor = Executor::new();
        let instants = Rc::new(RefCell::new(Vec::new()));
        for at_ns in [2_700, 1_208, 1_200] {
            let (instants, clock) = (instants.clone(), executor.clock().clone());
            executor.spawn("waits", async move {
                clock.until(at_ns).await;
                instants.borrow_mut().push((clock.now_ns(), Instant::now().as_micros()));
            });
        }
        executor.run_until_quiescent(LATE).unwrap();
        assert_eq!(*instants.borrow(), [(1_200, 1), (1_208, 1), (2_700, 2)]);
        executor.run_for(Duration::from_micros(1)).unwrap();
        assert_eq!(executor.clock().now_ns(), 3_700);
    }

    #[test]
    fn two_executors_take_turns_on_one_thread() {
        let mut executors = [Executor::new(), Executor::new()];
        let log = Log::default();
        executors[0].spawn("a", ticker(log.clone(), "a", 10, 2));
        executors[1].spawn("b", ticker(log.clone(), "b", 5, 2));
        for _ in 0..2 {
            executors[0].run_for(Duration::from_micros(10)).unwrap();
            executors[1].run_for(Duration::from_micros(5)).unwrap();
        }
        assert_eq!(*log.borrow(), [(10, "a"), (5, "b"), (20, "a"), (10, "b")]);
    }
}
