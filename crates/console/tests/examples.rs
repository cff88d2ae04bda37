//! The example does what it says.

#[path = "../examples/1_without_io.rs"]
mod without_io;

#[test]
fn lines_become_commands() {
    without_io::main();
}
