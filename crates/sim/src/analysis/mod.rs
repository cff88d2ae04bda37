//! The effect of a profile on the machine: derivatives of sampled curves, and the oscillation of a carriage.
//!
//! | item | what | after |
//! |---|---|---|
//! | [`gradient`] | derivative of samples at unequal spacing | `numpy.gradient`, as Fonseca-Campos 2023, section VI.A used it |
//! | [`Oscillator`] | **model** of a carriage on a spring, driven by a profile's acceleration | Fonseca-Campos 2023, section VI.F |
//! | [`mean`], [`deviation`] | average and standard deviation | Fonseca-Campos 2023, Table 7 |

mod derivative;
mod oscillator;
mod statistics;

pub use derivative::{gradient, mean_derivative};
pub use oscillator::{Oscillator, OscillatorError, Ringing};
pub use statistics::{deviation, mean};
