//! The profile options: how a program's moves change their speed, as `sim` and `emulate` take them.

use anyhow::{Result, anyhow};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use isostep_console::Settings;
use isostep_profile::{IntervalSplit, SpeedProfile};

/// Setting `$900`.
const INTERVAL_SPLIT: u16 = 900;
/// Setting `$940`.
const SPEED_PROFILE: u16 = 940;
/// Settings `$910`-`$912`.
const START_SPEEDS: [u16; 3] = [910, 911, 912];
/// A start speed for the speed profiles that need one, mm/min: 100 steps/s of the default machine.
const START_SPEED_MM_MIN: f32 = 120.0;

/// The interval split and the speed profile of a move.
#[derive(clap::Args, Debug)]
pub struct ProfileOptions {
    /// Split of a move's time into its intervals: fastest or thirds, $900 [default: fastest]
    #[arg(long, value_name = "NAME", value_parser = interval_split)]
    intervals: Option<IntervalSplit>,
    /// Change of speed on a ramp: $940; those over displacement (linear, quadratic, sinusoidal, logarithmic) set a
    /// start speed of 120 mm/min too, $910-$912 [default: trapezoid]
    #[arg(long, value_name = "NAME", value_parser = speed_profiles())]
    speed_profile: Option<SpeedProfile>,
}

/// An interval split by its name. The name of a speed profile belongs to another option.
fn interval_split(name: &str) -> Result<IntervalSplit, String> {
    match name {
        "fastest" => Ok(IntervalSplit::Fastest),
        "thirds" => Ok(IntervalSplit::Thirds),
        _ if SpeedProfile::ALL.iter().any(|speed_profile| speed_profile.name() == name) => {
            Err(format!("that is a speed profile, how speed changes on a ramp: give --speed-profile {name}"))
        }
        _ => Err("fastest or thirds".to_owned()),
    }
}

/// A speed profile by its name.
pub fn speed_profiles() -> impl TypedValueParser<Value = SpeedProfile> {
    let named = |name: String| SpeedProfile::ALL.into_iter().find(|speed_profile| speed_profile.name() == name);
    let values =
        SpeedProfile::ALL.map(|speed_profile| PossibleValue::new(speed_profile.name()).help(about(speed_profile)));
    PossibleValuesParser::new(values).map(move |name| named(name).unwrap_or_default())
}

fn about(speed_profile: SpeedProfile) -> &'static str {
    match speed_profile {
        SpeedProfile::Trapezoid => "Constant acceleration",
        SpeedProfile::SCurve => "Limited jerk",
        SpeedProfile::Sine => "Half a wave of a cosine over time",
        SpeedProfile::Linear => "Fonseca-Campos 2023, eq 5",
        SpeedProfile::Quadratic => "Fonseca-Campos 2023, eq 6",
        SpeedProfile::Sinusoidal => "Fonseca-Campos 2023, eq 7",
        SpeedProfile::Logarithmic => "Fonseca-Campos 2023, eq 8",
        _ => speed_profile.name(),
    }
}

impl ProfileOptions {
    /// The requested settings by number, in an order that the default machine accepts.
    pub fn settings(&self) -> Vec<(u16, f32)> {
        let mut settings = Vec::new();
        if let Some(split) = &self.intervals {
            settings.push((INTERVAL_SPLIT, f32::from(u8::from(*split == IntervalSplit::Thirds))));
        }
        if self.speed_profile.is_some_and(SpeedProfile::is_over_displacement) {
            settings.extend(START_SPEEDS.map(|number| (number, START_SPEED_MM_MIN)));
        }
        let number = SpeedProfile::ALL.into_iter().position(|speed_profile| Some(speed_profile) == self.speed_profile);
        settings.extend(number.map(|number| (SPEED_PROFILE, number as f32)));
        settings
    }

    /// The default machine with these speed profiles.
    pub fn machine(&self) -> Settings {
        self.over(Settings::DEFAULT).expect("the default machine takes every speed profile")
    }

    /// The given machine with these speed profiles. A start speed that the machine already has is kept.
    ///
    /// # Errors
    /// When the speed profile needs a start speed that the machine does not allow.
    pub fn over(&self, machine: Settings) -> Result<Settings> {
        let settings = self.settings().into_iter().try_fold(machine, |settings, (number, value)| {
            let keeps = START_SPEEDS.contains(&number) && settings.get(number) > Some(0.0);
            if keeps { Ok(settings) } else { settings.with(number, value) }
        })?;
        settings.check(&|_| f32::INFINITY).map_err(|conflict| anyhow!("{conflict}"))?;
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        options: ProfileOptions,
    }

    fn options(words: &[&str]) -> ProfileOptions {
        Cli::try_parse_from([&["sim"], words].concat()).unwrap_or_else(|error| panic!("{error}")).options
    }

    #[test]
    fn every_speed_profile_has_its_settings_and_the_machine_takes_them() {
        assert_eq!(options(&[]).settings(), []);
        assert_eq!(options(&["--intervals", "thirds", "--speed-profile", "sine"]).settings(), [(900, 1.0), (940, 2.0)]);
        let starts = [(910, 120.0), (911, 120.0), (912, 120.0)];
        assert_eq!(options(&["--speed-profile", "linear"]).settings(), [&starts[..], &[(940, 3.0)]].concat());
        for (number, speed_profile) in SpeedProfile::ALL.into_iter().enumerate() {
            let machine = options(&["--speed-profile", speed_profile.name()]).machine();
            assert_eq!(isostep_controller::config(&machine).speed_profile, speed_profile);
            assert_eq!(usize::from(machine.speed_profile), number);
        }
    }

    #[test]
    fn speed_profiles_that_were_named_win_over_a_machines_own() {
        let thirds =
            Settings { interval_thirds: true, speed_profile: 1, start_rate_mm_min: [60.0; 3], ..Settings::DEFAULT };
        assert_eq!(options(&[]).over(thirds).unwrap(), thirds);
        let fastest = options(&["--intervals", "fastest", "--speed-profile", "linear"]).over(thirds).unwrap();
        assert_eq!((fastest.interval_thirds, fastest.speed_profile, fastest.start_rate_mm_min), (false, 3, [60.0; 3]));
        let slow = Settings { max_rate_mm_min: [100.0; 3], ..Settings::DEFAULT };
        assert!(
            options(&["--speed-profile", "linear"]).over(slow).unwrap_err().to_string().contains("$910=120 is above")
        );
    }

    #[test]
    fn an_unknown_speed_profile_is_refused_with_those_there_are() {
        let refused = Cli::try_parse_from(["sim", "--speed-profile", "cubic"]).err().unwrap().to_string();
        assert!(refused.contains("s-curve") && refused.contains("logarithmic"), "{refused}");
        let refused = |name| Cli::try_parse_from(["sim", "--intervals", name]).err().unwrap().to_string();
        assert!(
            refused("s-curve")
                .contains("that is a speed profile, how speed changes on a ramp: give --speed-profile s-curve")
        );
        assert!(refused("halves").contains("fastest or thirds"));
    }
}
