//! Settings of UART drivers, and M122.

use isostep_console::{Error, ReportedState, SETTING_TABLE, SettingError, Settings};

use super::talk::{Talk, carries};

#[test]
fn the_steps_follow_the_microsteps() {
    let with = |settings: Settings, number, value| settings.with(number, value);
    let finer = with(Settings::DEFAULT, 151, 64.0).unwrap();
    assert_eq!((finer.microsteps, finer.steps_per_mm), ([16, 64, 16], [50.0, 200.0, 50.0]));
    assert_eq!(with(finer, 151, 16.0), Ok(Settings::DEFAULT));
    let refused = |settings, value| with(settings, 150, value).unwrap_err();
    let odd = refused(Settings::DEFAULT, 24.0);
    assert_eq!(odd.to_string(), "$150=24 is not a power of two: give 1, 2, 4, 8, 16, 32, 64, 128 or 256");
    assert_eq!(odd.error(), Error::BadNumber);
    let fine = Settings { steps_per_mm: [6_000.0; 3], max_rate_mm_min: [1.0; 3], ..Settings::DEFAULT };
    let finer = with(fine, 150, 32.0).unwrap();
    let beyond = finer.check(&carries).unwrap_err();
    assert_eq!(beyond.to_string(), "$100=12000 is above the most, 10000 steps/mm: lower it");
    assert_eq!(with(finer, 100, 6_000.0).unwrap().check(&carries), Ok(()), "a listing says it next");
    let stored = Settings { microsteps: [16, 3, 16], ..Settings::DEFAULT };
    assert_eq!(stored.check_ranges(), Err(SettingError::Microsteps { axis: 1, microsteps: 3 }));
}

#[test]
fn what_is_about_drivers_is_known_by_its_number() {
    let rows = SETTING_TABLE.iter().filter(|row| row.is_trinamic()).flat_map(|row| row.numbers());
    let expected = [150, 151, 152, 140, 141, 142, 200, 201, 202, 210, 211, 212, 338, 339, 908, 909, 980, 981, 982];
    assert_eq!(rows.collect::<Vec<_>>(), expected);
    let refused = SettingError::NoTrinamic { number: 980 };
    let words = "$980 is about UART drivers, which this board does not have: set them by their jumpers";
    assert_eq!((refused.to_string().as_str(), refused.error()), (words, Error::UnknownStatement));
    for state in ReportedState::ALL {
        assert_eq!(Talk::new(state).bytes(b"m122\n"), "(drivers) ok", "{state}");
        let measured = if state == ReportedState::Idle { "(measure a stall of 1) ok" } else { "error:8" };
        assert_eq!(Talk::new(state).bytes(b"$stall=Y\n"), measured, "{state}");
    }
    assert_eq!(Talk::new(ReportedState::Idle).bytes(b"$stall=B\n"), "error:3");
}
