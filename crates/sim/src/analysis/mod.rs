//! The effect of a profile on the machine: derivatives of sampled curves, the oscillation of a carriage, and its
//! spectrum.
//!
//! | item | what | after |
//! |---|---|---|
//! | [`gradient`] | derivative of samples at unequal spacing | `numpy.gradient`, as Fonseca-Campos 2023, section VI.A used it |
//! | [`Oscillator`] | **model** of a carriage on a spring, driven by a profile's acceleration | Fonseca-Campos 2023, section VI.F |
//! | `welch` | power spectral density | `scipy.signal.welch` and its defaults, as Fonseca-Campos 2023, section VI.F used it |
//! | [`mean`], [`deviation`] | average and standard deviation | Fonseca-Campos 2023, Table 7 |

mod derivative;
mod oscillator;
mod statistics;
#[cfg(feature = "report")]
mod welch;

pub use derivative::{gradient, mean_derivative};
pub use oscillator::{Oscillator, OscillatorError, Ringing};
pub use statistics::{deviation, mean};
#[cfg(feature = "report")]
pub use welch::{SEGMENT_MAX, Spectrum, welch};
