//! The default machine set to every speed law.

use isostep_console::Settings;
use isostep_profile::SpeedLaw;
use isostep_sim::AXES;

/// A start speed for the laws that need one: 100 steps/s of the default machine.
const START_MM_MIN: f32 = 120.0;

/// The default machine under each speed law.
pub fn machines() -> impl Iterator<Item = Settings> {
    (0..).zip(SpeedLaw::ALL).map(|(speed_law, law)| {
        let start_mm_min = if law.is_over_displacement() { START_MM_MIN } else { 0.0 };
        Settings { speed_law, start_rate_mm_min: [start_mm_min; AXES], ..Settings::DEFAULT }
    })
}
