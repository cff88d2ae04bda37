//! Tests that the examples do what they say.

#[path = "../examples/1_machine_with_a_fault.rs"]
mod machine_with_a_fault;

#[test]
fn a_fault_stops_the_machine_and_the_count_stays_exact() {
    machine_with_a_fault::main().unwrap();
}
