//! What comes to consoles without being asked for: alarms, how drivers and VFD are, and the end of a change of the tool.

use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::watch::Watch;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::report::{self, messages};
use isostep_motion::{Alarm, State, cold_path};

use crate::controller::Controller;
#[cfg(feature = "trinamic")]
use crate::drivers::DriverNews;
use crate::output::Message;
use crate::serve::Console;
use crate::status;
use crate::tool_change::Awaited;

/// The number of consoles that are told at once how drivers and VFD are. One beyond them still shows alarms, M122 and `$VFD`.
const LISTENERS: usize = 4;

/// A change of which the consoles are told.
#[derive(Clone, Copy)]
pub(crate) enum News {
    /// Of a driver's health.
    #[cfg(feature = "trinamic")]
    Driver(DriverNews),
    /// Of the VFD's.
    Vfd,
}

/// Where they are published.
pub(crate) type NewsWatch = Watch<NoopRawMutex, News, LISTENERS>;

impl<F: NorFlash> Controller<'_, F> {
    /// Reports alarms, and what changes of the drivers' health. Goes on with the line that waits until a tool has been changed.
    pub(crate) async fn notify(&self, console: &Console) -> Infallible {
        // The machine has room for a limited number of watching consoles. A console beyond them still shows alarms in
        // every status report.
        let Some(mut states) = self.machine.watch_state() else { core::future::pending().await };
        let mut news = self.news.receiver();
        loop {
            let next = async {
                match &mut news {
                    Some(news) => news.changed().await,
                    None => core::future::pending().await,
                }
            };
            let happened = select(states.changed(), next).await;
            let is_news = matches!(happened, Either::Second(_) | Either::First(State::Alarm(_)));
            if is_news || console.input.waits_behind_line() {
                cold_path(pin!(self.tell_news(console, happened))).await;
            }
        }
    }

    /// Tells the consoles.
    #[cold]
    #[inline(never)]
    pub(crate) fn publish(&self, news: News) {
        self.news.sender().send(news);
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
                if matches!(alarm, Alarm::SpindleFailed { .. }) {
                    self.with(|program| self.vfd.say_failed(&program.settings, text));
                } else {
                    text.say(code.about(what));
                }
            }
            Either::First(_) => {}
            #[cfg(feature = "trinamic")]
            Either::Second(News::Driver(news)) => text.say(news),
            Either::Second(News::Vfd) => self.with(|program| self.vfd.say(&program.settings, text)),
        }
    }
}
