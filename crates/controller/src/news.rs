//! The messages to consoles that nobody asked for, besides alarms: how the drivers are.

use embedded_storage_async::nor_flash::NorFlash;

use crate::controller::Controller;
#[cfg(feature = "trinamic")]
use crate::drivers::{Listener, News};

/// Without UART drivers there are none.
#[cfg(not(feature = "trinamic"))]
type News = core::convert::Infallible;

/// The news of one console.
pub(crate) struct DriverNews<'a> {
    #[cfg(feature = "trinamic")]
    drivers: Option<Listener<'a>>,
    #[cfg(not(feature = "trinamic"))]
    drivers: Option<&'a News>,
}

impl<F: NorFlash> Controller<'_, F> {
    /// The news from now on.
    pub(crate) fn news(&self) -> DriverNews<'_> {
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
