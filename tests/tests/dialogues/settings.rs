//! From settings to the machine's configuration: what reaches it, and that nothing is refused twice.

use isostep_console::Settings;
use isostep_motion::{AXES, Capabilities, DriverTiming, Wiring};
use isostep_profile::SpeedLaw;
use isostep_profile::shaper::ShaperKind;
use isostep_sim::Config;
use oorandom::Rand32;

use crate::talk::{powered_up, say};

/// The ports of these tests, which carry the driver's 250,000 steps/s.
const PORT: Capabilities = Capabilities::new(125_000_000, DriverTiming::DRV8825);

fn carries_steps_s(pulse_us: u16) -> f32 {
    PORT.rate_max_steps_s(Wiring { pulse_ns: u32::from(pulse_us) * 1_000, ..Wiring::default() }) as f32
}

#[test]
fn each_setting_reaches_the_configuration() {
    let settings = |set: &[(u16, f32)]| {
        let mut settings = Settings::DEFAULT;
        assert!(set.iter().all(|&(number, value)| settings.set(number, value)));
        isostep_controller::config(&settings)
    };
    assert_eq!(settings(&[(0, 10.0)]).wiring.map(|wiring| wiring.pulse_ns), [10_000; AXES]);
    assert_eq!(settings(&[(3, 5.0)]).wiring.map(|wiring| wiring.direction_inverted), [true, false, true]);
    let probe = |mask| {
        let config = settings(&[(6, mask)]);
        (config.probe_inverted, config.probe_pulled_up)
    };
    assert_eq!([0.0, 1.0, 2.0, 3.0].map(probe), [(false, true), (true, true), (false, false), (true, false)]);
    for (number, law) in SpeedLaw::ALL.into_iter().enumerate() {
        assert_eq!(settings(&[(940, number as f32)]).speed_law, law);
    }
    for (number, kind) in ShaperKind::ALL.into_iter().enumerate() {
        assert_eq!(
            settings(&[(951, number as f32)]).shapers.map(|shaper| shaper.kind)[..3],
            [ShaperKind::None, kind, ShaperKind::None]
        );
    }
    let shapers = settings(&[(950, 1.0), (960, 35.0), (972, 0.25)]).shapers;
    assert_eq!(shapers.map(|shaper| shaper.natural_hz as f32)[..3], [35.0, 40.0, 40.0]);
    assert_eq!(shapers.map(|shaper| shaper.damping_ratio as f32)[..3], [0.05, 0.05, 0.25]);
    // What another version has stored is out of range until it has been checked.
    assert_eq!(settings(&[(940, 200.0)]).speed_law, SpeedLaw::ALL[SpeedLaw::ALL.len() - 1]);
    assert_eq!(settings(&[(951, 200.0)]).shapers[1].kind, ShaperKind::ALL[ShaperKind::ALL.len() - 1]);
}

/// Settings that the console accepts, with one top speed at the limit of the ports.
fn accepted(random: &mut Rand32) -> Option<Settings> {
    let mut settings = Settings::DEFAULT;
    for setting in isostep_console::SETTING_TABLE {
        for number in setting.numbers() {
            let value = match random.rand_range(0..4) {
                0 => setting.min,
                1 => setting.max,
                _ => continue,
            };
            settings.set(number, value);
        }
    }
    let steps_per_mm = 0.1 + 1e3 * random.rand_float();
    let rate_mm_min = carries_steps_s(settings.pulse_us) / steps_per_mm * 60.0;
    settings.set(100, steps_per_mm);
    settings.set(110, f32::from_bits(rate_mm_min.to_bits() + 3 - random.rand_range(0..7)));
    (settings.check_ranges().is_ok() && settings.check(&carries_steps_s).is_ok()).then_some(settings)
}

/// The console's rules between settings are to be those of the machine. Otherwise the machine would refuse what the
/// console has accepted, in words that cannot name a value.
#[test]
fn the_machine_refuses_nothing_that_the_console_accepts() {
    let (mut random, mut count) = (Rand32::new(1), 0);
    while count < 2_000 {
        let Some(settings) = accepted(&mut random) else { continue };
        let checked = isostep_controller::config(&settings).check([Some(PORT); AXES]);
        assert_eq!(checked, Ok(()), "{settings:?}");
        count += 1;
    }
}

/// Wide pulses leave less room for steps.
#[test]
fn the_width_of_the_pulses_limits_the_rate() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$110=60000\n$110=2880\n$0=20\n$110=50000"), ["ok"; 4]);
    let heard = say(&mut sim, "$110=60000");
    assert!(heard[0].starts_with("[MSG:$110=60000 is above the"), "{heard:?}");
    assert_eq!(heard.last().unwrap(), "error:12");
}
