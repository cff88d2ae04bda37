//! `$PROVE`: what a board that measures itself is asked for, and answers.

use core::fmt::Write;

use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::Error;

use crate::controller::Controller;
use crate::output::{Message, Output};

/// Answers `$PROVE`. It is given what follows that word, the number of the page, from 0, and where to write it: some
/// whole lines, 256 bytes in all. It returns whether there is another page. It is called in thread mode, with the
/// consoles' turn: no other line is carried out meanwhile.
pub type Prove = fn(words: &str, page: usize, text: &mut dyn Write) -> Result<bool, Error>;

impl<F: NorFlash> Controller<'_, F> {
    /// Says that the board measures itself. Without this `$PROVE` is refused as a command that there is not.
    #[must_use]
    pub fn with_prove(mut self, prove: Prove) -> Self {
        self.prove = Some(prove);
        self
    }

    /// Answers `$PROVE`, page by page. The last page is left in `text`.
    ///
    /// # Cancellation
    /// Safe: pages that have not been sent are not sent.
    pub(crate) async fn prove(&self, words: &str, text: &mut Message, out: &Output) -> Result<(), Error> {
        let prove = self.prove.ok_or(Error::UnknownStatement)?;
        let mut page = 0;
        loop {
            let mut answer = Ok(false);
            text.print(|text| {
                answer = prove(words, page, text);
                answer.map(|_| ())
            });
            if !answer? {
                return Ok(());
            }
            out.send(text).await;
            text.clear();
            page += 1;
        }
    }
}
