//! The example does what it says.

#[path = "../examples/1_beside_the_closed_form.rs"]
mod beside_the_closed_form;

#[test]
fn a_generator_stands_beside_the_closed_form() {
    beside_the_closed_form::main().unwrap();
}
