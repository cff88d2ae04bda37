//! What comes to consoles without being asked for: alarms, how the drivers are, and the end of a change of the tool.

use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::select::{Either, select};
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::report::{self, messages};
use isostep_motion::{Alarm, State, cold_path};

use crate::controller::Controller;
#[cfg(feature = "trinamic")]
use crate::drivers::{Listener, News};
use crate::output::Message;
use crate::serve::Console;
use crate::status;
use crate::tool_change::Awaited;

/// Without UART drivers there are none.
#[cfg(not(feature = "trinamic"))]
type News = Infallible;

/// The news of one console.
pub(crate) struct DriverNews<'a> {
    #[cfg(feature = "trinamic")]
    drivers: Option<Listener<'a>>,
    #[cfg(not(feature = "trinamic"))]
    drivers: Option<&'a News>,
}

impl<F: NorFlash> Controller<'_, F> {
    /// Reports alarms, and what changes of the drivers' health. Goes on with the line that waits until a tool has been changed.
    pub(crate) async fn notify(&self, console: &Console) -> Infallible {
        // The machine has room for a limited number of watching consoles. A console beyond them still shows alarms in
        // every status report.
        let Some(mut states) = self.machine.watch_state() else { core::future::pending().await };
        let mut news = self.news();
        loop {
            let happened = select(states.changed(), news.next()).await;
            let is_news = matches!(happened, Either::Second(_) | Either::First(State::Alarm(_)));
            if is_news || console.input.waits_behind_line() {
                cold_path(pin!(self.tell_news(console, happened))).await;
            }
        }
    }

    /// Says what has happened, and goes on with the line that was put back, if its tool has been changed.
    async fn tell_news(&self, console: &Console, happened: Either<State, News>) {
        console.output.send_written(|text| self.say_news(text, happened)).await;
        if !console.input.waits_behind_line() {
            return;
        }
        match self.awaited() {
            Awaited::Nothing => {}
            Awaited::Warning => console.output.send_written(|text| text.say(messages::MEASURE_FIRST)).await,
            Awaited::Line => {
                // As in grblHAL: a sender that counts no `ok` until a report says Run hears one before the next `ok`.
                if self.changes_tool() {
                    self.offer_report(console);
                }
                console.input.open();
            }
        }
    }

    fn say_news(&self, text: &mut Message, happened: Either<State, News>) {
        match happened {
            Either::First(State::Alarm(alarm)) => {
                let (code, mut what) = status::alarm_code(alarm);
                if matches!(alarm, Alarm::DriverFailed { .. }) && self.drive_alarm_inputs == 1 {
                    what = "an axis";
                }
                text.print(|text| report::alarm(text, code));
                text.say(code.about(what));
            }
            Either::First(_) => {}
            Either::Second(news) => text.say(news),
        }
    }

    /// The news from now on.
    fn news(&self) -> DriverNews<'_> {
        #[cfg(feature = "trinamic")]
        let drivers = self.drivers.as_ref().and_then(|drivers| drivers.news.receiver());
        #[cfg(not(feature = "trinamic"))]
        let drivers = None;
        DriverNews { drivers }
    }
}

impl DriverNews<'_> {
    /// Waits for the next.
    pub async fn next(&mut self) -> News {
        match &mut self.drivers {
            #[cfg(feature = "trinamic")]
            Some(drivers) => drivers.changed().await,
            #[cfg(not(feature = "trinamic"))]
            Some(news) => **news,
            None => core::future::pending().await,
        }
    }
}
