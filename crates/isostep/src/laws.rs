//! The laws that a program's moves follow, as `sim` and `emulate` take them.

use anyhow::{Result, anyhow};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use isostep_console::Settings;
use isostep_profile::{IntervalLaw, SpeedLaw};

/// Setting `$900`.
const INTERVAL_LAW: u16 = 900;
/// Setting `$940`.
const SPEED_LAW: u16 = 940;
/// Settings `$910`-`$912`.
const START_SPEEDS: [u16; 3] = [910, 911, 912];
/// A start speed for the laws that need one, mm/min: 100 steps/s of the default machine.
const START_SPEED_MM_MIN: f32 = 120.0;

/// The interval law and the speed law of a move.
#[derive(clap::Args, Debug)]
pub struct Laws {
    /// Split of a move's time into its intervals: fastest or thirds, $900 [default: fastest]
    #[arg(long, value_name = "NAME", value_parser = interval_law)]
    law: Option<IntervalLaw>,
    /// Change of speed on a ramp: $940; those over displacement (linear, quadratic, sinusoidal, logarithmic) set a
    /// start speed of 120 mm/min too, $910-$912 [default: trapezoid]
    #[arg(long, value_name = "NAME", value_parser = speed_laws())]
    speed_law: Option<SpeedLaw>,
}

/// An interval law by its name. The name of a speed law belongs to another option.
fn interval_law(name: &str) -> Result<IntervalLaw, String> {
    match name {
        "fastest" => Ok(IntervalLaw::Fastest),
        "thirds" => Ok(IntervalLaw::Thirds),
        _ if SpeedLaw::ALL.iter().any(|law| law.name() == name) => {
            Err(format!("that is a speed law, how speed changes on a ramp: give --speed-law {name}"))
        }
        _ => Err("fastest or thirds".to_owned()),
    }
}

/// A speed law by its name.
pub fn speed_laws() -> impl TypedValueParser<Value = SpeedLaw> {
    let named = |name: String| SpeedLaw::ALL.into_iter().find(|law| law.name() == name);
    let values = SpeedLaw::ALL.map(|law| PossibleValue::new(law.name()).help(about(law)));
    PossibleValuesParser::new(values).map(move |name| named(name).unwrap_or_default())
}

fn about(law: SpeedLaw) -> &'static str {
    match law {
        SpeedLaw::Trapezoid => "Constant acceleration",
        SpeedLaw::SCurve => "Limited jerk",
        SpeedLaw::Sine => "Half a wave of a cosine over time",
        SpeedLaw::Linear => "Fonseca-Campos 2023, eq 5",
        SpeedLaw::Quadratic => "Fonseca-Campos 2023, eq 6",
        SpeedLaw::Sinusoidal => "Fonseca-Campos 2023, eq 7",
        SpeedLaw::Logarithmic => "Fonseca-Campos 2023, eq 8",
        _ => law.name(),
    }
}

impl Laws {
    /// The requested settings by number, in an order that the default machine accepts.
    pub fn settings(&self) -> Vec<(u16, f32)> {
        let mut settings = Vec::new();
        if let Some(law) = &self.law {
            settings.push((INTERVAL_LAW, f32::from(u8::from(*law == IntervalLaw::Thirds))));
        }
        if self.speed_law.is_some_and(SpeedLaw::is_over_displacement) {
            settings.extend(START_SPEEDS.map(|number| (number, START_SPEED_MM_MIN)));
        }
        let number = SpeedLaw::ALL.into_iter().position(|law| Some(law) == self.speed_law);
        settings.extend(number.map(|number| (SPEED_LAW, number as f32)));
        settings
    }

    /// The default machine with these laws.
    pub fn machine(&self) -> Settings {
        self.over(Settings::DEFAULT).expect("the default machine takes every law")
    }

    /// The given machine with these laws. A start speed that the machine already has is kept.
    ///
    /// # Errors
    /// When the law needs a start speed that the machine does not allow.
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
        laws: Laws,
    }

    fn laws(words: &[&str]) -> Laws {
        Cli::try_parse_from([&["sim"], words].concat()).unwrap_or_else(|error| panic!("{error}")).laws
    }

    #[test]
    fn every_law_has_its_settings_and_the_machine_takes_them() {
        assert_eq!(laws(&[]).settings(), []);
        assert_eq!(laws(&["--law", "thirds", "--speed-law", "sine"]).settings(), [(900, 1.0), (940, 2.0)]);
        let starts = [(910, 120.0), (911, 120.0), (912, 120.0)];
        assert_eq!(laws(&["--speed-law", "linear"]).settings(), [&starts[..], &[(940, 3.0)]].concat());
        for (number, law) in SpeedLaw::ALL.into_iter().enumerate() {
            let machine = laws(&["--speed-law", law.name()]).machine();
            assert_eq!(isostep_controller::config(&machine).speed_law, law);
            assert_eq!(usize::from(machine.speed_law), number);
        }
    }

    #[test]
    fn laws_that_were_named_win_over_a_machines_own() {
        let thirds =
            Settings { interval_thirds: true, speed_law: 1, start_rate_mm_min: [60.0; 3], ..Settings::DEFAULT };
        assert_eq!(laws(&[]).over(thirds).unwrap(), thirds);
        let fastest = laws(&["--law", "fastest", "--speed-law", "linear"]).over(thirds).unwrap();
        assert_eq!((fastest.interval_thirds, fastest.speed_law, fastest.start_rate_mm_min), (false, 3, [60.0; 3]));
        let slow = Settings { max_rate_mm_min: [100.0; 3], ..Settings::DEFAULT };
        assert!(laws(&["--speed-law", "linear"]).over(slow).unwrap_err().to_string().contains("$910=120 is above"));
    }

    #[test]
    fn an_unknown_law_is_refused_with_those_there_are() {
        let refused = Cli::try_parse_from(["sim", "--speed-law", "cubic"]).err().unwrap().to_string();
        assert!(refused.contains("s-curve") && refused.contains("logarithmic"), "{refused}");
        let refused = |name| Cli::try_parse_from(["sim", "--law", name]).err().unwrap().to_string();
        assert!(
            refused("s-curve").contains("that is a speed law, how speed changes on a ramp: give --speed-law s-curve")
        );
        assert!(refused("halves").contains("fastest or thirds"));
    }
}
