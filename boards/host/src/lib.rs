//! The host as a board: critical sections, which a chip implements by masking interrupts.
//!
//! # Design
//! On a chip an interrupt may come between any two instructions, except in a critical section. Tasks and interrupts
//! reach what they share in critical sections only. So every effect that an interrupt can have on a task, it can also
//! have at the end of one of the task's critical sections. [`at_section_ends`] sets a function that is called there. A
//! simulator runs its interrupts in this function.

use std::cell::{Cell, RefCell};
use std::hint;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use critical_section::RawRestoreState;

/// True while a thread is in a critical section. They are so short, and simulated machines on several threads enter so many,
/// that a thread which has to wait does so here, and not in the system.
static MASKED: AtomicBool = AtomicBool::new(false);
/// So often a waiting thread looks before it lets others run: the one that it waits for may be among them.
const LOOKS: u32 = 100;

thread_local! {
    /// Nesting depth of this thread's critical sections.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    static AT_SECTION_ENDS: RefCell<Option<Interruption>> = const { RefCell::new(None) };
}

/// A function that is called at the end of critical sections.
pub type Interruption = Rc<dyn Fn()>;

/// From now on `interruption` is called when this thread leaves an outermost critical section, like an interrupt that
/// was masked until then. It may enter critical sections itself; it is called again at their ends. Returns the previous
/// function.
pub fn at_section_ends(interruption: Option<Interruption>) -> Option<Interruption> {
    AT_SECTION_ENDS.replace(interruption)
}

struct Host;

critical_section::set_impl!(Host);

#[expect(unsafe_code, reason = "a board must say how interrupts are masked")]
// SAFETY: one thread at a time holds `MASKED`, from its outermost `acquire` to the matching `release`. In between no
// `Interruption` is called, so no other code of that thread runs either.
unsafe impl critical_section::Impl for Host {
    unsafe fn acquire() -> RawRestoreState {
        let depth = DEPTH.get();
        if depth == 0 {
            while MASKED.swap(true, Ordering::Acquire) {
                wait();
            }
        }
        DEPTH.set(depth + 1);
    }

    unsafe fn release((): RawRestoreState) {
        let depth = DEPTH.get() - 1;
        DEPTH.set(depth);
        if depth == 0 {
            MASKED.store(false, Ordering::Release);
            // During a panic, sections end while values are dropped. No interrupt is simulated there.
            let interruption = if std::thread::panicking() { None } else { AT_SECTION_ENDS.with_borrow(Clone::clone) };
            interruption.into_iter().for_each(|interrupt| interrupt());
        }
    }
}

/// Returns when no thread may be in a section, or one should look again.
fn wait() {
    for _ in 0..LOOKS {
        if !MASKED.load(Ordering::Relaxed) {
            return;
        }
        hint::spin_loop();
    }
    thread::yield_now();
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;
    use std::thread;

    use embassy_sync::blocking_mutex::CriticalSectionMutex;

    use super::*;

    #[test]
    fn an_interruption_comes_at_the_end_of_outermost_sections_alone() {
        let calls = Rc::new(Cell::new(0));
        let counted = calls.clone();
        assert!(at_section_ends(Some(Rc::new(move || counted.set(counted.get() + 1)))).is_none());
        critical_section::with(|_| {
            critical_section::with(|_| assert_eq!(calls.get(), 0));
            assert_eq!(calls.get(), 0);
        });
        assert_eq!(calls.get(), 1);
        critical_section::with(|_| {});
        assert_eq!(calls.get(), 2);
        assert!(at_section_ends(None).is_some());
        critical_section::with(|_| {});
        assert_eq!(calls.get(), 2);
    }

    #[test]
    fn an_interruption_may_enter_sections_of_its_own() {
        let depths = Rc::new(RefCell::new(Vec::new()));
        let (seen, nested) = (depths.clone(), Cell::new(0));
        at_section_ends(Some(Rc::new(move || {
            seen.borrow_mut().push(nested.get());
            if nested.get() < 2 {
                nested.set(nested.get() + 1);
                critical_section::with(|_| {});
            }
        })));
        critical_section::with(|_| {});
        at_section_ends(None);
        assert_eq!(*depths.borrow(), [0, 1, 2]);
    }

    #[test]
    fn one_thread_at_a_time_is_in_a_section() {
        static SUM: CriticalSectionMutex<Cell<u64>> = CriticalSectionMutex::new(Cell::new(0));
        let add = || {
            for _ in 0..10_000 {
                SUM.lock(|sum| {
                    let was = sum.get();
                    thread::yield_now();
                    sum.set(was + 1);
                });
            }
        };
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(add);
            }
        });
        assert_eq!(SUM.lock(Cell::get), 40_000);
    }

    #[test]
    fn a_panic_in_a_section_ends_it() {
        assert!(catch_unwind(|| critical_section::with(|_| panic!("on purpose"))).is_err());
        critical_section::with(|_| {});
        assert_eq!(DEPTH.get(), 0);
    }
}
