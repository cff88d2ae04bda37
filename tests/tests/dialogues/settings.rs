//! From settings to the machine's configuration: what reaches it, and that nothing is refused twice.

use isostep_console::{SETTING_TABLE, Settings, report};
use isostep_motion::{AXES, Capabilities, DriverTiming, Wiring};
use isostep_profile::SpeedLaw;
use isostep_profile::shaper::ShaperKind;
use isostep_sim::{Config, Flash, Sim};
use isostep_trials::cases;
use oorandom::Rand32;

use crate::drivers::{self, skr_pico};
use crate::talk::{powered_up, say, state, switched_on};

/// The ports of these tests, which carry the driver's 250,000 steps/s.
const PORT: Capabilities = Capabilities::new(125_000_000, DriverTiming::DRV8825);

fn carries_steps_s(pulse_us: u16) -> f32 {
    carried_steps_s(&PORT, pulse_us)
}

fn carried_steps_s(port: &Capabilities, pulse_us: u16) -> f32 {
    port.rate_max_steps_s(Wiring { pulse_ns: u32::from(pulse_us) * 1_000, ..Wiring::default() }) as f32
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
    let heard = say(&mut sim, "$110=60000\nG0 X1");
    assert!(heard[0].starts_with("[MSG:$110=60000 is above the"), "{heard:?}");
    assert_eq!(heard.last().unwrap(), "error:9");
}

/// Settings that work together on a machine with these ports, some steps away from `settings`.
fn walked(settings: Settings, port: &Capabilities, has_drivers: bool, random: &mut Rand32) -> Settings {
    let rows: Vec<_> = SETTING_TABLE.iter().filter(|row| has_drivers || !row.is_trinamic()).collect();
    let mut settings = settings;
    for _ in 0..400 {
        let row = rows[random.rand_range(0..rows.len() as u32) as usize];
        let numbers: Vec<_> = row.numbers().collect();
        let number = numbers[random.rand_range(0..numbers.len() as u32) as usize];
        let (wide, value) = (row.max.min(1e6) - row.min, settings.get(number).unwrap());
        let value = match random.rand_range(0..5) {
            0 => row.min,
            1 => row.max,
            2 => value * [0.5, 2.0][random.rand_range(0..2) as usize],
            _ => row.min + wide * random.rand_float().powi(3),
        };
        // As `$$` prints it.
        let value = if row.is_integer() { value.round() } else { format!("{value:.3}").parse().unwrap() };
        match settings.with(number, value) {
            Ok(next) if next.check(&|pulse_us| carried_steps_s(port, pulse_us)).is_ok() => settings = next,
            _ => {}
        }
    }
    settings
}

/// The lines of `$$` for these settings.
fn listing(settings: &Settings, has_drivers: bool) -> Vec<String> {
    let mut text = String::new();
    for row in SETTING_TABLE.iter().filter(|row| has_drivers || !row.is_trinamic()) {
        report::setting(&mut text, row, settings).unwrap();
    }
    text.lines().map(str::to_owned).collect()
}

fn comes_back(config: &Config, has_drivers: bool, count: u32) {
    let mut sim = switched_on(config);
    sim.replies();
    let (mut random, mut settings) = (Rand32::new(12), Settings::DEFAULT);
    let port = sim.machine().capabilities()[0].unwrap();
    for _ in 0..count {
        settings = walked(settings, &port, has_drivers, &mut random);
        let saved = listing(&settings, has_drivers);
        for line in &saved {
            let heard = say(&mut sim, line);
            assert_eq!(heard.last_line(), "ok", "{line}: {heard:?} in {saved:?}");
        }
        let mut listed: Vec<_> = say(&mut sim, "$$").iter().cloned().collect();
        assert_eq!(listed.pop().as_deref(), Some("ok"));
        assert_eq!(listed, saved);
        let unlocked = say(&mut sim, "$X");
        assert_eq!(state(&mut sim), "Idle", "{unlocked:?} after {saved:?}");
    }
}

/// Each listing is sent, line by line, to a machine with another one.
#[test]
fn a_saved_listing_comes_back_whatever_was_set_before() {
    comes_back(&Config::default(), false, cases(200, 2_000));
}

#[test]
fn a_saved_listing_of_drivers_comes_back_whatever_was_set_before() {
    comes_back(&skr_pico(), true, cases(60, 600));
}

/// Microsteps lead the steps per millimetre, and with them the step rate, beyond what can be, until the next lines come.
#[test]
fn a_listing_with_other_microsteps_comes_back() {
    let mut sim = drivers::powered_up(&skr_pico());
    assert_eq!(say(&mut sim, "$100=400\n$110=30000"), ["ok", "ok"]);
    let saved: Vec<_> = say(&mut sim, "$$").iter().filter(|line| line.starts_with('$')).cloned().collect();
    let heard = say(&mut sim, "$150=256");
    assert_eq!(heard[0], "[MSG:$100=6400.000 now, as the microsteps ask for]");
    assert!(heard[1].starts_with("[MSG:$110=30000 is above the"), "{heard:?}");
    assert_eq!(heard.last_line(), "ok");
    for line in saved.iter() {
        assert_eq!(say(&mut sim, line).last_line(), "ok", "{line}");
    }
    let listed: Vec<_> = say(&mut sim, "$$").iter().filter(|line| line.starts_with('$')).cloned().collect();
    assert_eq!(listed, saved);
}

/// It is reported at once, before every motion and after every welcome, also of the next power-up; and setting it right is all
/// that it takes.
#[test]
fn nothing_moves_while_settings_do_not_work_together() {
    let flash = Flash::blank();
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    assert_eq!(say(&mut sim, "$H\nM3 S500\nM8\n$N0=G91").last_line(), "ok");
    let reported = "[MSG:$31=2000 is not below the S at full duty, $30=1000 rpm: lower $31 or raise $30; until then nothing moves]";
    assert_eq!(say(&mut sim, "$31=2000"), [reported, "ok"]);
    assert_eq!(sim.tool(), [0; 5]);
    let refused = |sim: &mut Sim| {
        assert_eq!(state(sim), "Alarm");
        for (line, error) in [
            ("G0 X5", "error:9"),
            ("M3 S100", "error:9"),
            ("$J=X5 F100", "error:8"),
            ("$BUZZ=X", "error:8"),
            ("$N1=G0 X5", "error:8"),
            ("$C", "error:8"),
            ("$H", "error:2"),
            ("$HX", "error:2"),
            ("$X", "error:2"),
        ] {
            assert_eq!(say(sim, line), [reported, error], "{line}");
        }
        assert_eq!(say(sim, "$33=4000"), [reported, "ok"], "others may be set");
        assert_eq!(say(sim, "\n%"), ["ok", "ok"]);
        assert_eq!(sim.tool(), [0; 5]);
    };
    refused(&mut sim);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", reported]);
    refused(&mut sim);
    let steps = sim.counted_steps();
    let mut next = Sim::with_flash(&Config::default(), flash);
    next.run_until_idle().unwrap();
    assert_eq!(next.replies(), ["Grbl 1.1h ['$' for help]", reported]);
    refused(&mut next);
    assert_eq!((sim.counted_steps(), next.counted_steps()), (steps, [0; AXES]));
    for sim in [&mut sim, &mut next] {
        assert_eq!(say(sim, "$30=3000"), ["ok"]);
        assert_eq!(state(sim), "Idle");
        assert_eq!(say(sim, "G91 G0 X5"), ["ok"]);
    }
    assert_eq!(next.counted_steps(), [250, 0, 0]);
}
