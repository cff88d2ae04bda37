//! Tests that the examples do what they say.

#[path = "../examples/1_machine_with_a_fault.rs"]
mod machine_with_a_fault;
#[path = "../examples/2_motion_alone.rs"]
mod motion_alone;

#[test]
fn a_fault_stops_the_machine_and_the_count_stays_exact() {
    machine_with_a_fault::main().unwrap();
}

#[test]
fn a_program_without_a_console_draws_a_square() {
    motion_alone::main();
}
