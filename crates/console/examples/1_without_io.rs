//! Grbl's dialect without a machine: bytes become commands, and commands are answered.
//!
//! Run it with `cargo run -p isostep-console --example 1_without_io`.

use isostep_console::realtime::classify;
use isostep_console::{Command, Interpreter, LineAssembler, Realtime, ReportedState, Settings};

/// The bytes that a sender might send: lines, a real-time byte among them, and a mistake.
const BYTES: &[u8] = b"$H\nG21 G90\nG1 X10 Y5?F600\nG2 X20 R5\nG1 X1e9\n$$\n";

/// Prints what each line asks for.
pub fn main() {
    let (mut lines, mut interpreter) = (LineAssembler::new(), Interpreter::new());
    let settings = Settings::DEFAULT;
    for &byte in BYTES {
        // Real-time bytes act at once, wherever they come.
        if let Some(order) = classify(byte) {
            println!("real-time: {order:?}");
            assert_eq!(order, Realtime::Status);
            continue;
        }
        let Some(line) = lines.push(byte) else { continue };
        // A line that cannot be carried out changes nothing.
        let command = line.and_then(|line| interpreter.interpret(line, ReportedState::Idle, &settings));
        match command {
            Ok(Command::Block(block)) => println!("a block that moves: {:?}", block.motion),
            Ok(command) => println!("{command:?}"),
            Err(error) => println!("error:{} {error}", error.code()),
        }
    }
}
