//! The name under which the user runs this tool. Inside the repository it is `cargo xtask`, which offers the same
//! verbs.

use std::borrow::Cow;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::{Command, CommandFactory, FromArgMatches, Subcommand};

use crate::{Verb, screen};

/// The name of the installed binary. Texts in the sources use it.
pub const BINARY: &str = "isostep";

static CALLED: OnceLock<&str> = OnceLock::new();

/// Parses the command line of a tool called `name` with these verbs. Afterwards [`as_called`] writes that name into
/// every text.
///
/// # Errors
/// The exit code of a command line that is answered already: with help, with the version, or with what is wrong in it.
pub fn parse<P: CommandFactory + FromArgMatches>(name: &'static str) -> Result<P, ExitCode> {
    CALLED.get_or_init(|| name);
    let parsed = named(P::command()).try_get_matches().and_then(|matches| P::from_arg_matches(&matches));
    parsed.map_err(|answer| {
        let printed = answer.print();
        if answer.use_stderr() {
            return ExitCode::from(answer.exit_code() as u8);
        }
        screen::note(printed);
        crate::exit(Ok(()))
    })
}

/// `text` with the binary's name replaced by the name under which the user runs this tool.
pub fn as_called(text: &str) -> Cow<'_, str> {
    CALLED.get().filter(|name| **name != BINARY).map_or(text.into(), |name| renamed(text, name).into())
}

fn renamed(text: &str, name: &str) -> String {
    let verbs = Verb::augment_subcommands(Command::new(BINARY));
    verbs.get_subcommands().fold(text.to_owned(), |text, verb| {
        text.replace(&format!("{BINARY} {}", verb.get_name()), &format!("{name} {}", verb.get_name()))
    })
}

/// The command and all its verbs, with the user's name for the tool in their help.
fn named(command: Command) -> Command {
    let after = command.get_after_help().map(|help| as_called(&help.to_string()).into_owned());
    let command = command.after_help(after.unwrap_or_default());
    command.mut_subcommands(named).mut_args(|arg| {
        let help = arg.get_help().map(|help| as_called(&help.to_string()).into_owned());
        arg.help(help.unwrap_or_default())
    })
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn only_verbs_are_renamed() {
        let text = "isostep sim --pty --link /tmp/isostep   for `isostep console /tmp/isostep`";
        let expected = text.replace("isostep sim", "cargo xtask sim").replace("isostep console", "cargo xtask console");
        assert_eq!(renamed(text, "cargo xtask"), expected);
    }
}
