//! A figure, or the reason why there is none.

use serde::Serialize;

/// The result of a measurement. In JSON it is the figure itself, or an object with `why_not`.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Measured<T> {
    /// The figure.
    Figure(T),
    /// The board could not complete the case.
    Missing {
        /// The board's message.
        why_not: String,
    },
}

impl<T> Measured<T> {
    pub fn figure(&self) -> Option<&T> {
        self.result().ok()
    }

    pub fn result(&self) -> Result<&T, &str> {
        match self {
            Self::Figure(figure) => Ok(figure),
            Self::Missing { why_not } => Err(why_not),
        }
    }

    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Measured<U> {
        match self {
            Self::Figure(figure) => Measured::Figure(f(figure)),
            Self::Missing { why_not } => Measured::Missing { why_not },
        }
    }

    pub fn and_then<U>(self, f: impl FnOnce(T) -> Measured<U>) -> Measured<U> {
        match self {
            Self::Figure(figure) => f(figure),
            Self::Missing { why_not } => Measured::Missing { why_not },
        }
    }

    /// The figure in words, or the reason why there is none.
    pub fn words(&self, words: impl FnOnce(&T) -> String) -> String {
        self.result().map_or_else(|why_not| format!("not carried: {why_not}"), words)
    }
}

impl<T> From<Result<T, String>> for Measured<T> {
    fn from(result: Result<T, String>) -> Self {
        match result {
            Ok(figure) => Self::Figure(figure),
            Err(why_not) => Self::Missing { why_not },
        }
    }
}
