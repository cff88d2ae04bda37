//! The default machine set to every speed profile.

use isostep_console::Settings;
use isostep_profile::SpeedProfile;
use isostep_sim::AXES;

/// A start speed for the speed profiles that need one: 100 steps/s of the default machine.
const START_MM_MIN: f32 = 120.0;

/// The default machine under each speed profile.
pub fn machines() -> impl Iterator<Item = Settings> {
    (0..).zip(SpeedProfile::ALL).map(|(number, speed_profile)| {
        let start_mm_min = if speed_profile.is_over_displacement() { START_MM_MIN } else { 0.0 };
        Settings { speed_profile: number, start_rate_mm_min: [start_mm_min; AXES], ..Settings::DEFAULT }
    })
}
