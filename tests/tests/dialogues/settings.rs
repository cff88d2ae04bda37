//! From settings to the machine's configuration: what reaches it, and that nothing is refused twice. What was answered `ok`
//! is there after a power cycle, however soon the power fails.

use embassy_time::Duration;
use isostep_console::{SETTING_TABLE, Setting, Settings, report};
use isostep_motion::{AXES, Capabilities, DriverTiming};
use isostep_profile::SpeedProfile;
use isostep_profile::shaper::ShaperKind;
use isostep_sim::{Config, Flash, Sim};
use isostep_trials::cases;
use oorandom::Rand32;

use crate::drivers::{self, skr_pico};
use crate::talk::{say, state, switched_on};

/// The ports of these tests, which carry the driver's 250,000 steps/s.
const PORT: Capabilities = Capabilities::new(125_000_000, DriverTiming::DRV8825);

fn carries_steps_s(pulse_us: u16) -> f32 {
    isostep_controller::carries_steps_s([Some(PORT); AXES], pulse_us)
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
    for (number, speed_profile) in SpeedProfile::ALL.into_iter().enumerate() {
        assert_eq!(settings(&[(940, number as f32)]).speed_profile, speed_profile);
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
    assert_eq!(settings(&[(940, 200.0)]).speed_profile, SpeedProfile::ALL[SpeedProfile::ALL.len() - 1]);
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

/// Settings that work together on a machine with these ports, some steps away from `settings`.
fn walked(settings: Settings, port: &Capabilities, has_drivers: bool, random: &mut Rand32) -> Settings {
    // No drive of the simulated machine closes a contact for its alarm, and an SKR Pico has no input for it.
    let is_here =
        |row: &&Setting| row.number != 745 && if has_drivers { row.number != 744 } else { !row.is_trinamic() };
    let rows: Vec<_> = SETTING_TABLE.iter().filter(is_here).collect();
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
            Ok(next)
                if next
                    .check(&|pulse_us| isostep_controller::carries_steps_s([Some(*port); AXES], pulse_us))
                    .is_ok() =>
            {
                settings = next
            }
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

/// The replies that list all that is stored.
const LISTINGS: [&str; 4] = ["$$", "$#", "$N", "$I"];

fn listed(sim: &mut Sim) -> Vec<Vec<String>> {
    LISTINGS.map(|line| say(sim, line).into_iter().collect()).into()
}

fn powered(flash: &Flash) -> Sim {
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    sim.run_until_idle().unwrap();
    sim.replies();
    sim
}

#[test]
fn what_was_answered_ok_is_there_after_a_power_cycle() {
    const BEFORE: [&str; 8] =
        ["$110=1234", "$13=0", "$I=MILL", "$N0=G55", "G10 L2 P1 X1 Y2 Z3", "G10 L2 P3 X4", "G0 X2 Y1", "G28.1"];
    for line in [
        "$130=250.5",
        "$22=0",
        "$110=2000",
        "$13=1",
        "$I=LATHE",
        "$I=",
        "$N0=",
        "$N1=G21",
        "$N0=G91",
        "G10 L2 P1 X7",
        "G10 L2 P0 Y7",
        "G10 L2 P6 Z-7",
        "G10 L20 P2 X5 Y5",
        "G10 L20 P0 Z5",
        "G28.1",
        "G30.1",
        "$RST=$",
        "$RST=#",
        "$RST=*",
    ] {
        let flash = Flash::blank();
        let mut sim = powered(&flash);
        for line in BEFORE {
            assert_eq!(say(&mut sim, line), ["ok"], "{line}");
        }
        let mut sim = powered(&flash);
        say(&mut sim, "G0 X5 Y6 Z7");
        say(&mut sim, line);
        // G54 to G59, G28 and G30 of `$#` are stored. The others are not.
        let stored = |mut listed: Vec<Vec<String>>| {
            listed[1].truncate(8);
            listed
        };
        let expected = stored(listed(&mut sim));
        let found = stored(listed(&mut powered(&flash)));
        assert_eq!(found, expected, "{line}");
    }
}

/// The power fails in the instant in which `ok` comes.
#[test]
fn what_is_answered_ok_is_stored_by_then() {
    for (line, listing, expected) in [
        ("$130=250.5", "$$", "$130=250.500"),
        ("$N1=G21", "$N", "$N1=G21"),
        ("$I=LATHE", "$I", "[VER:1.1h.20190830:LATHE]"),
        ("G10 L2 P2 X7", "$#", "[G55:7.000,0.000,0.000]"),
        ("G10 L20 P2 X7", "$#", "[G55:-7.000,0.000,0.000]"),
        ("G0 X1\nG28.1", "$#", "[G28:1.000,0.000,0.000]"),
        ("G0 X1\nG30.1", "$#", "[G30:1.000,0.000,0.000]"),
        ("G10 L2 P1 X9\n$RST=#", "$#", "[G54:0.000,0.000,0.000]"),
        ("$130=200\n$RST=$", "$$", "$130=350.000"),
        ("$130=200\n$RST=*", "$$", "$130=350.000"),
    ] {
        let flash = Flash::blank();
        let mut sim = powered(&flash);
        sim.send(format!("{line}\n").as_bytes());
        let mut left = line.lines().count();
        while left > 0 {
            sim.run_for(Duration::from_micros(20)).unwrap();
            left -= sim.replies().iter().filter(|heard| *heard == "ok").count();
        }
        let heard = say(&mut powered(&flash), listing);
        assert!(heard.iter().any(|heard| heard == expected), "{line}: {heard:?}, {expected} expected");
    }
}
