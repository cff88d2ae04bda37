//! A deterministic executor in virtual time.
//!
//! Tasks are spawned once, by name. Of the tasks that are ready, the one spawned first runs first, as a higher
//! interrupt priority would on the chip. When none is ready, time jumps to the next deadline. Nothing here depends on a
//! wall clock, a thread's schedule or an address, so a run is a function of its tasks.
//!
//! # Preemption
//! A task is polled without interruption, unless [`section_max_ns`](crate::Config::section_max_ns) is set. Then
//! interruptions happen at the end of each of the task's critical sections (see [`isostep_host`]), where on a chip they
//! may come between any two instructions. An interruption is a stimulus that was asked for, or a task of a higher
//! [`Priority`] that is ready. Code of threads may also take time, in which other tasks become due.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fmt;
use std::future::{Future, ready};
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Wake, Waker};

use embassy_time::{Duration, Instant};
use isostep_host::{Interruption, at_section_ends};
use oorandom::Rand64;

use crate::time::{self, Clock};

/// Limit of polls without time moving on. No correct set of tasks needs as many: beyond it, tasks wake each other for
/// ever.
const POLLS_PER_INSTANT_MAX: u32 = 1_000_000;

/// The reason why [`Executor::run_until`] ended early.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Nothing is ready and no deadline is pending: only an event from outside could continue the run.
    #[error("deadlock at {}: nothing is due, and these tasks wait: {}", Seconds(*.at), .waiting.join(", "))]
    Deadlock {
        /// When the last task began to wait.
        at: Instant,
        /// The tasks that have not ended, in the order they were spawned.
        waiting: Vec<&'static str>,
    },
    /// The limit of virtual time has been reached.
    #[error("not done at {}, the limit of virtual time: is there a dwell or a move that long?", Seconds(*.limit))]
    TimeLimit {
        /// The limit.
        limit: Instant,
        /// The tasks that have not ended, in the order they were spawned.
        waiting: Vec<&'static str>,
    },
    /// Tasks keep waking each other and no time passes.
    #[error("livelock at {}: {POLLS_PER_INSTANT_MAX} polls and no time passed, the last of task {task}", Seconds(*.at))]
    Livelock {
        /// The instant at which time stands still.
        at: Instant,
        /// The task polled last.
        task: &'static str,
    },
}

/// The end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Nothing is ready and no deadline is pending.
    Quiescent,
    /// The horizon was reached first.
    Horizon,
}

/// Priority of a task on a processor that several tasks share. Of the ready tasks, the one with the highest priority
/// runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// The coordinator and the consoles, which all other tasks interrupt.
    #[default]
    Thread,
    /// The axes.
    P2,
    /// Switches, buttons, the tool.
    P1,
    /// Simulated surroundings, which are no task of the chip.
    World,
}

/// The way in which tasks are interrupted.
pub(crate) struct Preemption {
    /// True if an interruption is possible at the end of this critical section. It is not while the simulated world,
    /// which no chip has, is being changed.
    pub open: Box<dyn Fn() -> bool>,
    /// Longest time between two critical sections of a thread, ns; the time is random.
    pub section_max_ns: u32,
    /// Seed of these times.
    pub seed: u64,
}

struct Task {
    name: &'static str,
    priority: Priority,
    ready: Arc<Ready>,
    waker: Waker,
    future: RefCell<Pin<Box<dyn Future<Output = ()>>>>,
    has_ended: Cell<bool>,
    /// When the blocking delays of its last poll are over, ns since power-up.
    free_ns: Cell<u64>,
}

struct Ready(AtomicBool);

impl Wake for Ready {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Named tasks and their clock.
#[derive(Default)]
pub struct Executor {
    core: Rc<Core>,
    interruption: Option<Interruption>,
}

/// The part of the executor that an interruption needs.
#[derive(Default)]
struct Core {
    clock: Clock,
    tasks: RefCell<Vec<Rc<Task>>>,
    /// The priority of the task being polled.
    running: Cell<Option<Priority>>,
    /// Time does not pass beyond this, ns since power-up.
    horizon_ns: Cell<u64>,
    interrupts: RefCell<Option<Interrupts>>,
    /// Number of critical sections that have ended since preemption was turned on.
    sections: Cell<u64>,
}

struct Interrupts {
    preemption: Preemption,
    random: Rand64,
    /// Keys: the number of the section at whose end the stimulus comes, and a serial number.
    stimuli: BTreeMap<(u64, usize), Box<dyn FnOnce()>>,
}

impl Executor {
    /// An executor without tasks, at power-up.
    pub fn new() -> Self {
        Self::default()
    }

    /// The clock of its tasks.
    pub fn clock(&self) -> &Clock {
        &self.core.clock
    }

    /// Adds a task of the lowest priority, which all others interrupt. Of the ready tasks, the one spawned first runs
    /// first.
    pub fn spawn(&mut self, name: &'static str, future: impl Future<Output = ()> + 'static) {
        self.spawn_at(Priority::default(), name, future);
    }

    /// Adds a task of this priority. The priority matters only if preemption is turned on.
    pub fn spawn_at(&mut self, priority: Priority, name: &'static str, future: impl Future<Output = ()> + 'static) {
        let ready = Arc::new(Ready(AtomicBool::new(true)));
        let (waker, future) = (Waker::from(ready.clone()), RefCell::new(Box::pin(future) as Pin<Box<_>>));
        let (has_ended, free_ns) = (Cell::new(false), Cell::new(0));
        self.core.tasks.borrow_mut().push(Rc::new(Task { name, priority, ready, waker, future, has_ended, free_ns }));
    }

    /// Turns preemption on.
    pub(crate) fn preempt(&mut self, preemption: Preemption) {
        let (random, stimuli) = (Rand64::new(preemption.seed.into()), BTreeMap::new());
        self.core.interrupts.replace(Some(Interrupts { preemption, random, stimuli }));
        let core = Rc::downgrade(&self.core);
        self.interruption = Some(Rc::new(move || core.upgrade().into_iter().for_each(|core| core.section_ended())));
    }

    /// Number of critical sections at whose end an interruption was possible.
    pub fn sections(&self) -> u64 {
        self.core.sections.get()
    }

    /// Applies `stimulus` at the end of the critical section that is `sections` later.
    ///
    /// # Panics
    /// If preemption is not turned on.
    pub fn after_sections(&mut self, sections: u64, stimulus: impl FnOnce() + 'static) {
        let mut interrupts = self.core.interrupts.borrow_mut();
        let stimuli = &mut interrupts.as_mut().expect("tasks are interrupted").stimuli;
        stimuli.insert((self.core.sections.get() + sections, stimuli.len()), Box::new(stimulus));
    }

    /// Discards the stimuli that have not come yet.
    pub(crate) fn forget_stimuli(&mut self) {
        self.core.interrupts.borrow_mut().iter_mut().for_each(|interrupts| interrupts.stimuli.clear());
    }

    /// A function that keeps all tasks of threads from being polled until an instant, ns since power-up.
    pub(crate) fn starver(&self) -> Rc<dyn Fn(u64)> {
        let core = Rc::downgrade(&self.core);
        Rc::new(move |until_ns| {
            let Some(core) = core.upgrade() else { return };
            for task in core.tasks.borrow().iter().filter(|task| task.priority == Priority::Thread) {
                task.free_ns.set(until_ns);
            }
        })
    }

    /// Runs until `done` returns true, which is checked whenever no task is ready, but not beyond `limit`.
    ///
    /// # Errors
    /// [`RunError`] for a deadlock, the time limit or a livelock before `done`.
    pub fn run_until(&mut self, limit: Instant, done: impl FnMut() -> bool) -> Result<(), RunError> {
        self.run_until_ns(time::ns(limit), false, done)
    }

    /// `to_rest`: it is a deadlock, too, if only what runs in the background waits.
    fn run_until_ns(&mut self, limit_ns: u64, to_rest: bool, mut done: impl FnMut() -> bool) -> Result<(), RunError> {
        let _current = self.clock().clone().enter();
        let _interrupted = Interrupted::by(self.interruption.clone());
        self.core.horizon_ns.set(limit_ns);
        loop {
            self.core.run_ready()?;
            if done() {
                return Ok(());
            }
            match self.core.next_ns().filter(|_| !to_rest || self.core.is_due()) {
                None => return Err(RunError::Deadlock { at: self.clock().now(), waiting: self.waiting() }),
                Some(at_ns) if at_ns > limit_ns => {
                    let limit = Instant::from_nanos(limit_ns);
                    return Err(RunError::TimeLimit { limit, waiting: self.waiting() });
                }
                Some(at_ns) => self.clock().advance_to(at_ns),
            }
        }
    }

    /// Runs until nothing can happen without an event from outside, or until `horizon`. What runs in the background goes on
    /// for ever, and does not count.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_until_quiescent(&mut self, horizon: Instant) -> Result<Rest, RunError> {
        self.run_to_rest(time::ns(horizon), true)
    }

    fn run_to_rest(&mut self, horizon_ns: u64, without_background: bool) -> Result<Rest, RunError> {
        match self.run_until_ns(horizon_ns, without_background, || false) {
            Err(RunError::Deadlock { .. }) => Ok(Rest::Quiescent),
            Err(RunError::TimeLimit { .. }) => Ok(Rest::Horizon),
            Err(livelock) => Err(livelock),
            Ok(()) => unreachable!("the condition never holds"),
        }
    }

    /// Runs for `duration`; the clock advances by exactly that.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_for(&mut self, duration: Duration) -> Result<(), RunError> {
        self.run_to(self.clock().now_ns() + duration.as_nanos())
    }

    /// Runs to `at_ns` since power-up, and sets the clock to that. Does not run if that is in the past.
    ///
    /// # Errors
    /// [`RunError::Livelock`].
    pub fn run_to(&mut self, at_ns: u64) -> Result<(), RunError> {
        self.run_to_rest(at_ns, false)?;
        self.clock().advance_to(at_ns);
        Ok(())
    }

    /// The names of the tasks that have not ended.
    pub fn waiting(&self) -> Vec<&'static str> {
        self.core.tasks.borrow().iter().filter(|task| !task.has_ended.get()).map(|task| task.name).collect()
    }
}

impl Core {
    fn run_ready(&self) -> Result<(), RunError> {
        for _ in 0..POLLS_PER_INSTANT_MAX {
            let Some(task) = self.first_ready(|_| true) else { return Ok(()) };
            self.poll(&task);
        }
        let task = self.tasks.borrow().iter().find(|task| task.is_awake()).map_or("none", |task| task.name);
        Err(RunError::Livelock { at: self.clock.now(), task })
    }

    /// Of the tasks that can run and for which `wanted` is true, the one spawned first.
    fn first_ready(&self, wanted: impl Fn(&Task) -> bool) -> Option<Rc<Task>> {
        let now_ns = self.clock.now_ns();
        let tasks = self.tasks.borrow();
        tasks.iter().find(|task| task.is_awake() && task.free_ns.get() <= now_ns && wanted(task)).cloned()
    }

    fn poll(&self, task: &Task) {
        let interrupted = self.running.replace(Some(task.priority));
        let spent_ns = self.clock.set_spent_ns(0);
        task.poll();
        // The task may have been starved during the poll.
        task.free_ns.set(self.clock.end_poll().max(task.free_ns.get()));
        self.clock.set_spent_ns(spent_ns);
        self.running.set(interrupted);
    }

    /// The time of the next event, ns since power-up. This is a deadline, or the end of the blocking delay of a task
    /// that was woken during it.
    fn next_ns(&self) -> Option<u64> {
        let tasks = self.tasks.borrow();
        let now_ns = self.clock.now_ns();
        let delayed = tasks.iter().filter(|task| task.is_awake()).map(|task| task.free_ns.get());
        self.clock.next_deadline_ns().into_iter().chain(delayed.filter(|&free_ns| free_ns > now_ns)).min()
    }

    /// True if anything is to happen that does not run in the background.
    fn is_due(&self) -> bool {
        self.clock.has_deadlines() || self.tasks.borrow().iter().any(|task| task.is_awake())
    }

    /// Called when the task being polled has left a critical section: runs what interrupts it.
    fn section_ended(&self) {
        // Code outside all tasks is not interrupted.
        let Some(priority) = self.running.get() else { return };
        if !self.interrupts.borrow().as_ref().is_some_and(|interrupts| (interrupts.preemption.open)()) {
            return;
        }
        self.sections.set(self.sections.get() + 1);
        while let Some(stimulus) = self.due_stimulus() {
            let interrupted = self.running.take();
            stimulus();
            self.running.set(interrupted);
        }
        if priority == Priority::Thread {
            self.let_code_take_time();
        }
        self.poll_above(priority);
    }

    fn due_stimulus(&self) -> Option<Box<dyn FnOnce()>> {
        let mut interrupts = self.interrupts.borrow_mut();
        let stimuli = &mut interrupts.as_mut()?.stimuli;
        let first = stimuli.first_entry()?;
        (first.key().0 <= self.sections.get()).then(|| first.remove())
    }

    fn let_code_take_time(&self) {
        let took_ns = self.interrupts.borrow_mut().as_mut().map_or(0, |interrupts| {
            let most_ns = u64::from(interrupts.preemption.section_max_ns);
            if most_ns == 0 { 0 } else { interrupts.random.rand_range(0..most_ns) }
        });
        if took_ns == 0 {
            return;
        }
        let until_ns = self.horizon_ns.get().min(self.clock.now_ns() + took_ns);
        while let Some(at_ns) = self.next_ns().filter(|&at_ns| at_ns <= until_ns) {
            self.clock.advance_to(at_ns);
            self.poll_above(Priority::Thread);
        }
        self.clock.advance_to(until_ns);
    }

    /// Polls ready tasks of a higher priority, the highest first.
    fn poll_above(&self, priority: Priority) {
        for _ in 0..POLLS_PER_INSTANT_MAX {
            let highest = [Priority::World, Priority::P1, Priority::P2]
                .into_iter()
                .take_while(|&higher| higher > priority)
                .find_map(|higher| self.first_ready(|task| task.priority == higher));
            match highest {
                Some(task) => self.poll(&task),
                None => return,
            }
        }
    }
}

/// Preemption of this thread is on as long as this value lives.
struct Interrupted(Option<Interruption>);

impl Interrupted {
    fn by(interruption: Option<Interruption>) -> Self {
        Self(at_section_ends(interruption))
    }
}

impl Drop for Interrupted {
    fn drop(&mut self) {
        at_section_ends(self.0.take());
    }
}

impl Task {
    fn is_awake(&self) -> bool {
        !self.has_ended.get() && self.ready.0.load(Ordering::Relaxed)
    }

    fn poll(&self) {
        self.ready.0.store(false, Ordering::Relaxed);
        let mut future = self.future.borrow_mut();
        if future.as_mut().poll(&mut Context::from_waker(&self.waker)).is_ready() {
            self.has_ended.set(true);
            *future = Box::pin(ready(()));
        }
    }
}

/// Displays an instant as seconds since power-up.
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
