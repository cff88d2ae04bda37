//! A future that watches beside a task for ever. A run ends without waiting for it.

use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Wake, Waker};

use crate::time::Clock;

/// Polls `future` as part of the task that awaits it, in the background unless `counts`: somebody in the task waits for it.
pub(crate) async fn in_background<F: Future>(clock: &Clock, counts: impl Fn() -> bool, future: F) -> F::Output {
    let mut future = pin!(future);
    let watcher = Arc::new(Watcher(Mutex::new(None)));
    // A waker of its own, so that its deadlines are not those of the task.
    let waker = Waker::from(watcher.clone());
    poll_fn(|context| {
        watcher.set(context.waker());
        let polled = clock.in_background(|| future.as_mut().poll(&mut Context::from_waker(&waker)));
        clock.count_background(counts());
        polled
    })
    .await
}

/// Wakes the task that it is a part of.
struct Watcher(Mutex<Option<Waker>>);

impl Watcher {
    fn set(&self, task: &Waker) {
        *self.0.lock().expect("nothing panics here") = Some(task.clone());
    }
}

impl Wake for Watcher {
    fn wake(self: Arc<Self>) {
        if let Some(task) = &*self.0.lock().expect("nothing panics here") {
            task.wake_by_ref();
        }
    }
}
