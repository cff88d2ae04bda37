//! The laws that a program's moves follow, as `sim` and `emulate` take them.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use isostep_console::Settings;
use isostep_profile::SpeedLaw;

/// Setting `$900`.
const INTERVAL_LAW: u16 = 900;
/// Setting `$940`.
const SPEED_LAW: u16 = 940;
/// Settings `$910`-`$912`.
const START_SPEEDS: [u16; 3] = [910, 911, 912];
/// A start speed for the laws that need one, mm/min: 100 steps/s of the default machine.
const START_SPEED_MM_MIN: f32 = 120.0;

/// How a move's time is split, and how its speed changes.
#[derive(clap::Args, Debug)]
pub struct Laws {
    /// How a move's time is split into its intervals: $900
    #[arg(long, value_parser = ["fastest", "thirds"], default_value = "fastest")]
    law: String,
    /// How speed changes on a ramp: $940; those over displacement (linear, quadratic, sinusoidal, logarithmic) set a start
    /// speed of 120 mm/min too, $910-$912
    #[arg(long, value_name = "NAME", value_parser = speed_laws(), default_value = SpeedLaw::Trapezoid.name())]
    speed_law: SpeedLaw,
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
        SpeedLaw::Linear => "Paper 000, eq 5",
        SpeedLaw::Quadratic => "Paper 000, eq 6",
        SpeedLaw::Sinusoidal => "Paper 000, eq 7",
        SpeedLaw::Logarithmic => "Paper 000, eq 8",
    }
}

impl Laws {
    /// The settings that differ from the default machine's, by number, in an order that the controller accepts.
    pub fn settings(&self) -> Vec<(u16, f32)> {
        let mut settings = Vec::new();
        if self.law == "thirds" {
            settings.push((INTERVAL_LAW, 1.0));
        }
        if self.speed_law.is_over_displacement() {
            settings.extend(START_SPEEDS.map(|number| (number, START_SPEED_MM_MIN)));
        }
        if let Some(number @ 1..) = SpeedLaw::ALL.into_iter().position(|law| law == self.speed_law) {
            settings.push((SPEED_LAW, number as f32));
        }
        settings
    }

    /// The default machine under these laws.
    pub fn machine(&self) -> Settings {
        self.settings().into_iter().fold(Settings::DEFAULT, |settings, (number, value)| {
            settings.with(number, value, &|_| f32::INFINITY).expect("the default machine takes every law")
        })
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
    fn an_unknown_law_is_refused_with_those_there_are() {
        let refused = Cli::try_parse_from(["sim", "--speed-law", "cubic"]).err().unwrap().to_string();
        assert!(refused.contains("s-curve") && refused.contains("logarithmic"), "{refused}");
    }
}
