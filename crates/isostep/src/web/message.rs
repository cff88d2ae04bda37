//! What a page and the server say to each other in texts, as JSON. What is binary is the board's.

use axum::extract::ws::Message;
use serde::{Deserialize, Serialize};

use super::job::Now;

/// What a page asks for.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "lowercase")]
pub enum Asked {
    /// Its script runs.
    Alive,
    /// This program is to be sent to the machine. `before` is the page's own: how the machine was then, for pages that come later.
    Start {
        name: String,
        program: String,
        #[serde(default)]
        before: Vec<String>,
    },
    /// The program of the job is to be told.
    Program,
}

/// What the server tells a page.
#[derive(Serialize)]
#[serde(tag = "is", rename_all = "lowercase")]
pub enum Told<'a> {
    /// A question, to be answered by the page's script.
    #[serde(rename = "alive?")]
    IsAlive,
    /// How the job is.
    Job(Now<'a>),
    /// The program of the job.
    Program { name: &'a str, text: &'a str, before: &'a [String] },
    /// A job was not begun, and why.
    Refused { why: &'a str },
    /// The page has the board no more, and why.
    Ended { why: &'a str },
}

impl Told<'_> {
    /// As it is sent.
    pub fn message(&self) -> Message {
        Message::text(serde_json::to_string(self).expect("texts and numbers"))
    }
}
