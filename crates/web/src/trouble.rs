//! The faults for a page: a sentence, and the line it is about.

use std::fmt;

use isostep_sim::program::ProgramError;
use isostep_sim::settings::Refused;
use isostep_sim::{RunError, SimError, StartOutside};
use serde::Serialize;

/// Why there is no machine, or no result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Trouble {
    /// The text that it is about.
    pub about: About,
    /// The line of it, from 1.
    pub line: Option<usize>,
    /// The value, the limit and the remedy.
    pub words: String,
}

/// One of the two texts from which a run is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum About {
    /// The program.
    #[default]
    Program,
    /// The lines of `$n=v`.
    Settings,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl std::error::Error for Trouble {}

impl Trouble {
    pub(crate) fn without_line(words: impl ToString) -> Self {
        Self { about: About::Program, line: None, words: words.to_string() }
    }
}

impl From<ProgramError> for Trouble {
    fn from(error: ProgramError) -> Self {
        let line = match &error {
            ProgramError::Empty => None,
            ProgramError::Binary { line, .. } | ProgramError::RealTime { line, .. } => Some(*line),
            ProgramError::Line(error) => Some(error.line),
        };
        Self { about: About::Program, line, words: error.to_string() }
    }
}

impl From<Refused> for Trouble {
    fn from(refused: Refused) -> Self {
        let line = refused.line.as_ref().map(|(line, _)| *line);
        Self { about: About::Settings, line, words: refused.to_string() }
    }
}

/// The carriages stand where they always do, so it is the travel that is too short.
impl From<StartOutside> for Trouble {
    fn from(error: StartOutside) -> Self {
        Self { about: About::Settings, ..Self::without_line(error) }
    }
}

impl From<RunError> for Trouble {
    fn from(error: RunError) -> Self {
        Self::without_line(error)
    }
}

impl From<SimError> for Trouble {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Program(error) => error.into(),
            SimError::Start(error) => error.into(),
            SimError::Run(error) => error.into(),
            SimError::Unanswered { line, .. }
            | SimError::Silenced { line, .. }
            | SimError::ToolNotMeasured { line, .. } => Self { line: Some(line), ..Self::without_line(error) },
        }
    }
}
