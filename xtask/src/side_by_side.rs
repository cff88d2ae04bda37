//! Runs jobs side by side.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

use anyhow::Result;

/// Runs the jobs in order, `N` at a time. After one that fails no other begins.
///
/// # Errors
/// What failed.
pub fn run<const N: usize, T: Send>(jobs: Vec<T>, run: impl Fn(T) -> Result<()> + Sync) -> Result<()> {
    let waiting = Mutex::new(VecDeque::from(jobs));
    let work = || {
        while let Some(job) = next(&waiting) {
            let outcome = run(job);
            if outcome.is_err() {
                lock(&waiting).clear();
                return outcome;
            }
        }
        Ok(())
    };
    let outcomes = thread::scope(|scope| {
        let workers = [(); N].map(|()| scope.spawn(work));
        workers.map(|worker| worker.join().expect("a job does not panic"))
    });
    outcomes.into_iter().collect()
}

/// In a function of its own, so that the lock is not kept while the job runs.
fn next<T>(waiting: &Mutex<VecDeque<T>>) -> Option<T> {
    lock(waiting).pop_front()
}

/// What a thread that panicked has left is as good as before.
pub fn lock<T>(what: &Mutex<T>) -> MutexGuard<'_, T> {
    what.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
    use std::time::Duration;

    use anyhow::anyhow;

    use super::*;

    #[test]
    fn every_job_runs_once_and_two_at_a_time() {
        let both_here = Barrier::new(2);
        let done = Mutex::new(Vec::new());
        run::<2, _>((0..10).collect(), |job| {
            both_here.wait();
            lock(&done).push(job);
            Ok(())
        })
        .unwrap();
        let mut done = done.into_inner().unwrap();
        done.sort_unstable();
        assert_eq!(done, (0..10).collect::<Vec<_>>());
    }

    enum Job {
        Fails,
        /// It lasts until the third is given up.
        Waits(Receiver<()>),
        Never(Sender<()>),
    }

    #[test]
    fn after_a_job_that_fails_no_other_begins() {
        let (third, given_up) = channel();
        let jobs = vec![Job::Fails, Job::Waits(given_up), Job::Never(third)];
        let outcome = run::<2, _>(jobs, |job| match job {
            Job::Fails => Err(anyhow!("the first")),
            Job::Waits(given_up) => {
                assert_eq!(given_up.recv_timeout(Duration::from_secs(20)), Err(RecvTimeoutError::Disconnected));
                Ok(())
            }
            Job::Never(third) => Err(anyhow!("the third has begun: {third:?}")),
        });
        assert_eq!(outcome.unwrap_err().to_string(), "the first");
    }
}
