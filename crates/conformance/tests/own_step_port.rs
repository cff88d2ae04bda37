//! Tests that the example's port keeps the promises of all ports.

#[path = "../examples/own_step_port.rs"]
mod own_step_port;

isostep_conformance::keeps_its_promises!(own_step_port::OwnPorts);

#[test]
fn two_axes_draw_a_line() {
    own_step_port::main();
}
