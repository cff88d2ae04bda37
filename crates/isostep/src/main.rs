//! The binary. It only parses the arguments and runs a verb of the library.

use std::process::ExitCode;

use isostep::cli::{Cli, Verb};
use isostep::{exit, name, web};

fn main() -> ExitCode {
    name::parse::<Cli>(name::BINARY).map_or_else(
        |code| code,
        |cli| {
            exit(match cli.verb {
                Verb::Shared(verb) => verb.run(),
                Verb::Web(args) => web::run(args),
            })
        },
    )
}
