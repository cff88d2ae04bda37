//! The time that processors have spent on this process and on those that it started and that have ended.

/// That time, s; `None` where the system does not tell.
#[cfg(unix)]
pub fn spent_s() -> Option<f64> {
    use nix::sys::resource::{UsageWho, getrusage};

    let of = |who| {
        let usage = getrusage(who).ok()?;
        let times = [usage.user_time(), usage.system_time()];
        Some(times.map(|time| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6).iter().sum::<f64>())
    };
    Some(of(UsageWho::RUSAGE_SELF)? + of(UsageWho::RUSAGE_CHILDREN)?)
}

#[cfg(not(unix))]
pub fn spent_s() -> Option<f64> {
    None
}
