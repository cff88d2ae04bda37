//! Targets beyond the travel: they lock the machine.

use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::{Error, Fixed};
use isostep_motion::{Alarm, Axis};

use crate::controller::Controller;
use crate::output::Message;

/// A place of an axis that is outside its travel, steps.
#[derive(Clone, Copy)]
pub(crate) struct Beyond {
    pub(crate) axis: Axis,
    pub(crate) place_steps: i32,
}

impl<F: NorFlash> Controller<'_, F> {
    /// Locks the machine once the moves before have ended. These moves are good, and they must end first so that no
    /// step is lost.
    pub(crate) async fn refuse_target(&self, beyond: Beyond, is_of_arc: bool, text: &mut Message) -> Error {
        match self.settled().await {
            Ok(()) => self.lock_beyond(beyond, is_of_arc, text),
            Err(error) => error,
        }
    }

    #[cold]
    fn lock_beyond(&self, Beyond { axis, place_steps }: Beyond, is_of_arc: bool, text: &mut Message) -> Error {
        self.machine.raise(Alarm::SoftLimit { axis });
        self.follow_machine();
        let config = self.machine.config();
        let range = config.travel_steps(axis);
        let mm = |steps: i32| Fixed { value: config.mm(axis, steps) as f32, decimals: 3 };
        let (asked, min, max) = (mm(place_steps), mm(*range.start()), mm(*range.end()));
        let unit = self.with(|program| program.settings.unit(axis as usize));
        let whose = if is_of_arc { "the arc's " } else { "" };
        text.say(format_args!(
            "{whose}{axis}{asked} is outside the travel, {min} to {max} {unit}: correct the program, then $X"
        ));
        Error::Locked
    }
}
