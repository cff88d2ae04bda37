//! The values that survive a power cycle, in flash: settings, work offsets, places, tools, start-up lines and a text of the
//! user's.
//!
//! # Design
//! The data is a log, the queue of `sequential-storage`: each change appends one item, and the last value of an item
//! counts. The log goes round through all sectors, and the newest items take the place of the oldest, so all sectors
//! wear alike. Each time half of the sectors have been filled, all kept items are appended once more, so nothing in the
//! oldest sectors is needed. Below the log are `Sectors`. They make sure that every item has its old value or its new
//! one, whenever the power fails.
//!
//! Programming and erasing may stop everything else for as long as they take, so the caller of [`Store::save`] has to
//! make sure that nothing moves. Between operations the other tasks run.

mod item;
mod sectors;

use core::fmt;
use core::ops::Range;

use embassy_futures::{block_on, yield_now};
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use isostep_console::parameters::STORED_LINE_CHARS;
use isostep_console::{Parameters, SettingError, Settings};
use sequential_storage::Error as LogError;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::queue::{QueueConfig, QueueStorage};

pub use item::{Item, Value};
use sectors::{Sectors, WORD_BYTES_MAX};

use crate::config::UNWORKABLE;

/// The version of the format. It is an item with a key of its own, which ends every copy of all kept items. A log of
/// another version is not read.
const VERSION: u32 = 1;
const NOTHING: u32 = 0;
const VERSION_ITEM: Item = Item(u16::MAX);
const KEY_BYTES: usize = 2;

/// The longest item with its key.
const ENTRY_BYTES: usize = KEY_BYTES + STORED_LINE_CHARS;
/// The same in whole words, as it is read.
const READ_BYTES: usize = ENTRY_BYTES.next_multiple_of(WORD_BYTES_MAX);
/// The most that a header may claim: a sector of most flashes.
const CLAIM_BYTES_MAX: usize = 4096;

type Log<F> = QueueStorage<Sectors<F>, Cache<Uncached, Uncached, Uncached>>;

/// Keeps items in a flash.
pub struct Store<F: NorFlash> {
    log: Log<F>,
    defaults: Settings,
    kept: Kept,
    /// The log has to be begun again: it holds nothing, or nothing that can be continued.
    anew: bool,
    /// Bytes appended to the log since the last copy of all kept items.
    since_copy: usize,
    /// An item that may be in the log with another value than the kept one, because appending it was refused or
    /// dropped.
    doubtful: Option<Item>,
    /// The log could not be continued, and not all that is in force has been written again yet.
    is_lost: bool,
}

/// The content of the flash; defaults where it holds nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// The settings, not yet checked.
    pub settings: Settings,
    /// Work offsets, places, tools, start-up lines, the user's text.
    pub parameters: Parameters,
}

/// Why what was stored is not in force. Prints as the text of a `[MSG:...]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Loss {
    /// The data is damaged, or is something else.
    Unreadable,
    /// The data has another format.
    OtherVersion,
    /// A setting has a value that cannot be.
    Refused(SettingError),
    /// The machine refuses the settings.
    Unworkable,
}

/// The flash has refused: what was to be changed has its old value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// An entry of the log claims to be longer than any that was written.
struct TooLong;

impl<F: NorFlash> Store<F> {
    /// Keeps items in `range` of `flash`. Settings that it does not hold are as in `defaults`; other items are zero or
    /// empty.
    ///
    /// The flash may be any that reads as 0xFF where it is erased and is read and written in units of 1, 2, 4, 8, 16 or
    /// 32 bytes; others are refused when the program is compiled.
    ///
    /// # Panics
    /// When `range` is not 4 to 32 whole sectors of the flash, or when half of them, less one, have no room for all items
    /// twice. Six sectors of 4096 bytes have it, and twelve if units are of 32 bytes.
    #[must_use]
    pub fn new(flash: F, range: Range<u32>, defaults: Settings) -> Self {
        let sectors = Sectors::new(flash, range);
        // From one copy of an item to the next there are at most half of the flash, a change of all items and a copy of
        // all. The log keeps all its sectors but the one that it goes on to.
        let items_bytes: usize = Item::all().map(|item| log_bytes::<F>(KEY_BYTES + item.bytes_max())).sum();
        assert!(2 * items_bytes <= sectors.bytes() as usize / 2 - Sectors::<F>::SIZE, "no room for all items twice");
        let config = QueueConfig::new(0..sectors.bytes());
        let log = Log::new(sectors, config, Cache::new_uncached());
        Self { log, defaults, kept: Kept::new(defaults), anew: true, since_copy: 0, doubtful: None, is_lost: false }
    }

    /// The content of the flash, after [`load`](Self::load).
    #[must_use]
    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// Reads all items. It changes nothing, except that it completes what a power cut has left half done.
    ///
    /// # Errors
    /// [`Loss::Unreadable`] or [`Loss::OtherVersion`]: then it holds the defaults, and the next [`save`](Self::save)
    /// begins a new log.
    pub async fn load(&mut self) -> Result<(), Loss> {
        let version = self.read().await;
        self.anew = version != Some(VERSION);
        if self.anew {
            self.kept = Kept::new(self.defaults);
        }
        match version {
            Some(NOTHING | VERSION) => Ok(()),
            Some(_) => Err(Loss::OtherVersion),
            None => Err(Loss::Unreadable),
        }
    }

    /// Reads the log. Returns its version; `None` if it makes no sense.
    async fn read(&mut self) -> Option<u32> {
        match self.read_by(&mut [0; READ_BYTES]).await {
            Ok(version) => version,
            Err(TooLong) => self.read_long(),
        }
    }

    /// The same, where the power has cut a header short and it claims to be a longer one, as happens once in some ten thousand times:
    /// its data are not what it claims, and the log goes on behind them. The buffer is on the stack, not in a future that would take its
    /// room for ever, so the flash is waited for here. It is at power-up, when nothing else has to be done.
    #[cold]
    #[inline(never)]
    fn read_long(&mut self) -> Option<u32> {
        block_on(self.read_by(&mut [0; CLAIM_BYTES_MAX])).ok().flatten()
    }

    async fn read_by(&mut self, buffer: &mut [u8]) -> Result<Option<u32>, TooLong> {
        (self.kept, self.since_copy, self.doubtful) = (Kept::new(self.defaults), 0, None);
        let Ok(mut understood) = self.log.flash().open().await else { return Ok(None) };
        let mut version = NOTHING;
        let Ok(mut entries) = self.log.iter().await else { return Ok(None) };
        loop {
            let entry = match entries.next(buffer).await {
                Ok(Some(entry)) => entry,
                Ok(None) => break,
                Err(LogError::BufferTooSmall(_)) => return Err(TooLong),
                Err(_) => return Ok(None),
            };
            let Some((&key, value)) = entry.split_first_chunk() else { return Ok(None) };
            self.since_copy += log_bytes::<F>(entry.len());
            match (Item(u16::from_le_bytes(key)), value.try_into()) {
                (VERSION_ITEM, Ok(value)) => (version, self.since_copy) = (u32::from_le_bytes(value), 0),
                (VERSION_ITEM, Err(_)) => return Ok(None),
                (item, _) => understood &= self.kept.set(item, value),
            }
        }
        // Every log begins with a version.
        understood &= version != NOTHING || self.since_copy == 0;
        // Another version may have other values.
        Ok((understood || !matches!(version, NOTHING | VERSION)).then_some(version))
    }

    /// Stores every item whose value is not stored yet; settings only with `settings`. `now` returns the present value
    /// of an item. Call it while nothing moves.
    ///
    /// # Errors
    /// [`NotStored`]; the items that could be stored are stored.
    ///
    /// # Cancellation
    /// As a power cut: each item has its old value or its new one. Call it again.
    pub async fn save(&mut self, settings: bool, now: impl Fn(Item) -> Value) -> Result<(), NotStored> {
        let mut again = true;
        loop {
            match self.write(settings || self.is_lost, &now).await {
                Err(LogError::Corrupted { .. }) if again => {
                    // The log cannot be continued. But everything that is in force is known, and is written again.
                    (self.anew, self.is_lost, again) = (true, true, false);
                }
                written => {
                    self.is_lost &= written.is_err();
                    return written.map_err(|_| NotStored);
                }
            }
        }
    }

    async fn write(&mut self, settings: bool, now: &impl Fn(Item) -> Value) -> Result<(), LogError<F::Error>> {
        if self.anew {
            self.log.erase_all().await?;
            (self.kept, self.doubtful) = (Kept::new(self.defaults), None);
        }
        if let Some(item) = self.doubtful {
            self.push(item, &self.kept.value(item)).await?;
        }
        if self.anew || self.since_copy > self.log.flash_range().len() / 2 {
            self.copy().await?;
        }
        let mut items = 0;
        while let Some(item) = Item::at(items) {
            items += 1;
            let value = now(item);
            if (settings || !item.is_setting()) && value != self.kept.value(item) {
                self.push(item, &value).await?;
            }
        }
        Ok(())
    }

    /// Appends all kept items to the log once more.
    async fn copy(&mut self) -> Result<(), LogError<F::Error>> {
        let mut items = 0;
        while let Some(item) = Item::at(items) {
            items += 1;
            let value = self.kept.value(item);
            if value != Kept::new(self.defaults).value(item) {
                self.push(item, &value).await?;
            }
        }
        self.push(VERSION_ITEM, &VERSION.to_le_bytes()).await?;
        (self.anew, self.since_copy) = (false, 0);
        Ok(())
    }

    /// Appends an item to the log, and keeps its value.
    async fn push(&mut self, item: Item, value: &[u8]) -> Result<(), LogError<F::Error>> {
        let mut entry = Vec::<_, ENTRY_BYTES>::new();
        // There is room for the longest.
        let _ = entry.extend_from_slice(&item.0.to_le_bytes());
        let _ = entry.extend_from_slice(value);
        self.since_copy += log_bytes::<F>(entry.len());
        self.doubtful = (item != VERSION_ITEM).then_some(item);
        self.log.push(&entry, true).await?;
        self.kept.set(item, value);
        self.doubtful = None;
        yield_now().await;
        Ok(())
    }
}

/// Bytes that an entry takes in the log, with its header, which is a word.
fn log_bytes<F: NorFlash>(entry_bytes: usize) -> usize {
    let word_bytes = Sectors::<F>::WORD_BYTES;
    word_bytes + entry_bytes.next_multiple_of(word_bytes)
}

impl Kept {
    fn new(settings: Settings) -> Self {
        Self { settings, parameters: Parameters::default() }
    }

    /// The value of an item.
    #[must_use]
    pub fn value(&self, item: Item) -> Value {
        let Parameters { coordinates, tools, startup, build_text } = &self.parameters;
        item.value((&self.settings, coordinates, tools, startup, build_text))
    }

    fn set(&mut self, item: Item, value: &[u8]) -> bool {
        item.set(value, &mut self.settings, &mut self.parameters)
    }
}

impl Loss {
    /// True if only the settings are lost.
    pub(crate) fn is_of_settings(&self) -> bool {
        matches!(self, Self::Refused(_) | Self::Unworkable)
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable => f.write_str("what flash holds cannot be read")?,
            Self::OtherVersion => f.write_str("what flash holds is another version's")?,
            Self::Refused(why) => write!(f, "stored settings refused, {why}")?,
            Self::Unworkable => write!(f, "stored settings refused, {}", UNWORKABLE)?,
        }
        f.write_str(" - the defaults are in force: set yours again, or keep these by $RST=*")
    }
}
