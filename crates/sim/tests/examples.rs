//! Tests that the examples do what they say.

#[path = "../examples/1_machine_with_a_fault.rs"]
mod machine_with_a_fault;
#[path = "../examples/2_own_step_port.rs"]
mod own_step_port;

#[test]
fn a_fault_stops_the_machine_and_the_count_stays_exact() {
    machine_with_a_fault::main().unwrap();
}

#[test]
fn a_port_of_your_own_makes_the_steps() {
    own_step_port::main().unwrap();
}
