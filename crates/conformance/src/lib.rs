#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod plan;
pub mod promises;
pub mod rig;

pub use rig::{Bench, Ports, Rig};

/// Makes a test of each [promise](promises) for these [`Ports`].
#[macro_export]
macro_rules! keeps_its_promises {
    ($ports:expr) => {
        $crate::keeps_its_promises! { $ports =>
            every_step_leaves_at_its_instant_there_and_back,
            directions_can_be_inverted,
            a_motor_that_is_held_makes_no_step_and_the_other_makes_all,
            pulses_are_as_wide_as_the_driver_or_the_wiring_asks,
            the_highest_rate_it_claims_works_from_rest_and_the_next_is_refused,
            steps_may_be_an_hour_apart,
            all_axes_start_at_one_instant,
            a_port_starts_when_it_can_keep_its_first_step,
            an_armed_port_makes_no_step_before_it_is_let_go,
            a_run_dropped_before_its_start_makes_no_step,
            an_axis_may_rest_throughout_its_run,
            moves_there_and_back_in_one_run_are_exact,
            steps_to_and_fro_may_be_as_close_as_others,
            stopping_it_anywhere_leaves_the_exact_count_and_whole_pulses,
            stopping_it_between_reversals_leaves_the_exact_count,
            the_count_follows_through_reversals,
            running_dry_is_a_fault_and_nothing_rises_after_it,
            steps_that_are_too_close_for_the_pulses_end_in_a_fault_not_in_a_cut_pulse,
            steps_to_and_fro_that_are_too_close_are_refused,
        }
    };
    ($ports:expr => $($promise:ident,)*) => {
        $(
            #[test]
            fn $promise() {
                $crate::promises::$promise($ports);
            }
        )*
    };
}
