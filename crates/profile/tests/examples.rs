//! The examples do what they say.

#[path = "../examples/3_look_ahead.rs"]
mod look_ahead;
#[path = "../examples/1_one_axis.rs"]
mod one_axis;
#[path = "../examples/2_synchronised_axes.rs"]
mod synchronised_axes;

#[test]
fn one_axis_makes_its_steps() {
    one_axis::main().unwrap();
}

#[test]
fn axes_are_synchronised() {
    synchronised_axes::main().unwrap();
}

#[test]
fn a_chain_is_held_and_resumed() {
    look_ahead::main().unwrap();
}
