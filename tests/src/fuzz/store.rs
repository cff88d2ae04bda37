//! Tests the store with arbitrary contents of flash, with changes, and with power cuts at any time.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use arbitrary::{Result, Unstructured};
use embassy_futures::block_on;
use isostep_console::{SETTING_TABLE, Settings, ToolEntry};
use isostep_controller::Parameters;
use isostep_controller::store::{Item, Kept, Store};
use isostep_sim::Flash;
use isostep_sim::flash::SECTOR_BYTES;

/// The largest number of events per case.
const EVENTS: usize = 64;
const ERASED: u8 = 0xFF;

/// Runs the events that `bytes` describe on one flash.
///
/// # Panics
/// When an item has neither its old nor its new value, when unreadable flash does not give the same result as blank
/// flash, or when a change is refused.
pub fn run(bytes: &[u8]) {
    let mut bytes = Unstructured::new(bytes);
    // When the bytes run out, the case ends.
    let _ = live(&mut bytes);
}

fn live(bytes: &mut Unstructured<'_>) -> Result<()> {
    let sectors = bytes.int_in_range(6..=8)?;
    let flash = Flash::with(vec![ERASED; sectors * SECTOR_BYTES]);
    scribble(&flash, bytes)?;
    let mut life = Life::begin(flash);
    for _ in 0..EVENTS {
        if bytes.is_empty() {
            break;
        }
        life.happens(bytes)?;
    }
    life.keeps_a_change();
    Ok(())
}

/// Writes the same byte everywhere, or short patterns to random places.
fn scribble(flash: &Flash, bytes: &mut Unstructured<'_>) -> Result<()> {
    if bytes.ratio(1, 8)? {
        let all = bytes.arbitrary()?;
        flash.change(|cells| cells.fill(all));
    }
    for _ in 0..bytes.int_in_range(0..=8)? {
        let run: [u8; 8] = bytes.arbitrary()?;
        let times = bytes.int_in_range(1..=32)?;
        let sector = bytes.int_in_range(0..=5)?;
        // The important bytes are mostly at the beginning of a sector.
        let place =
            if bytes.ratio(1, 2)? { bytes.int_in_range(0..=64)? } else { bytes.int_in_range(0..=SECTOR_BYTES)? };
        flash.change(|cells| {
            let from = (sector * SECTOR_BYTES + place) % cells.len();
            cells[from..]
                .iter_mut()
                .zip(run.iter().cycle().take(times * run.len()))
                .for_each(|(cell, byte)| *cell = *byte);
        });
    }
    Ok(())
}

struct Life {
    flash: Flash,
    store: Store<Flash>,
    /// The values that items may have: those stored last, and those of all changes tried since.
    may_be: Vec<Kept>,
    /// Bytes were changed while the flash was in use. Then data at the end of the log may be lost, and the values are
    /// not checked.
    is_damaged: bool,
}

fn defaults() -> Kept {
    Kept { settings: Settings::DEFAULT, parameters: Parameters::default() }
}

impl Life {
    fn begin(flash: Flash) -> Self {
        let store = Self::opened(&flash);
        let may_be = vec![store.kept().clone()];
        Self { flash, store, may_be, is_damaged: false }
    }

    fn opened(flash: &Flash) -> Store<Flash> {
        let bytes = flash.bytes().len() as u32;
        let mut store = Store::new(flash.clone(), 0..bytes, Settings::DEFAULT);
        let loaded = block_on(store.load());
        if std::env::var("DBG").is_ok() {
            eprintln!("loaded {loaded:?}");
        }
        if loaded.is_err() {
            assert_eq!(store.kept(), &defaults(), "what cannot be read is as if blank");
        }
        store
    }

    fn happens(&mut self, bytes: &mut Unstructured<'_>) -> Result<()> {
        let what = bytes.int_in_range(0..=7)?;
        if std::env::var("DBG").is_ok() {
            eprintln!("event {what}");
        }
        match what {
            0..=2 => self.keeps_a_change_of(bytes)?,
            3 => self.opens(),
            4 => {
                self.flash.cut_power_after(bytes.int_in_range(0..=40)?, u64::from(bytes.arbitrary::<u16>()?));
                let _ = self.tries(bytes, usize::MAX)?;
                self.flash.mend();
                self.opens();
            }
            5 => {
                // The power goes during loading, which may have to repair something.
                self.flash.cut_power_after(bytes.int_in_range(0..=2)?, u64::from(bytes.arbitrary::<u16>()?));
                let _ = Self::opened(&self.flash);
                self.flash.mend();
                self.opens();
            }
            6 => {
                let polls = bytes.int_in_range(0..=8)?;
                let _ = self.tries(bytes, polls)?;
            }
            _ => {
                scribble(&self.flash, bytes)?;
                self.is_damaged = true;
                self.opens();
            }
        }
        Ok(())
    }

    /// Loads the store as after power-up, and checks its values.
    fn opens(&mut self) {
        self.store = Self::opened(&self.flash);
        let kept = self.store.kept();
        for item in Item::all().filter(|_| !self.is_damaged) {
            let value = kept.value(item);
            assert!(self.may_be.iter().any(|kept| kept.value(item) == value), "{item:?} is {value:?}");
        }
        self.may_be = vec![kept.clone()];
    }

    fn keeps_a_change_of(&mut self, bytes: &mut Unstructured<'_>) -> Result<()> {
        assert!(self.tries(bytes, usize::MAX)?, "a change is not kept");
        self.may_be.drain(..self.may_be.len() - 1);
        Ok(())
    }

    /// Changes something and stores it. The future is dropped after `polls` polls. Returns whether the change was
    /// stored.
    fn tries(&mut self, bytes: &mut Unstructured<'_>, polls: usize) -> Result<bool> {
        let mut wanted = self.may_be.last().cloned().unwrap_or_else(defaults);
        change(&mut wanted, bytes)?;
        self.may_be.push(wanted.clone());
        let mut save = pin!(self.store.save(true, |item| wanted.value(item)));
        let mut context = Context::from_waker(Waker::noop());
        for _ in 0..polls {
            if let Poll::Ready(saved) = save.as_mut().poll(&mut context) {
                return Ok(saved.is_ok());
            }
        }
        Ok(false)
    }

    /// Checks that a change stored now is present at the next power-up, whatever happened before.
    fn keeps_a_change(mut self) {
        let mut wanted = defaults();
        wanted.settings.set(111, 999.0);
        let saved = block_on(self.store.save(true, |item| wanted.value(item)));
        assert_eq!(saved, Ok(()));
        self.may_be = vec![wanted];
        self.opens();
    }
}

fn change(kept: &mut Kept, bytes: &mut Unstructured<'_>) -> Result<()> {
    match bytes.int_in_range(0..=7)? {
        0 => *kept = defaults(),
        1 => {
            let line = "G1X9F".repeat(bytes.int_in_range(0..=15)?);
            let line = line.as_str().try_into().expect("15 times 5 characters fit");
            match bytes.int_in_range(0..=2)? {
                2 => kept.parameters.build_text = line,
                index => kept.parameters.startup[index] = line,
            }
        }
        2 => {
            let index = bytes.int_in_range(0..=10)?;
            let place = kept.parameters.coordinates.iter_mut().nth(index).expect("eleven places");
            place.fill(i64::from(bytes.arbitrary::<i8>()?) * 1_000_000_000);
        }
        3 => {
            let (number, length_pm) =
                (bytes.int_in_range(1..=40)?, i64::from(bytes.arbitrary::<i8>()?) * 1_000_000_000);
            // A tool for which there is no room stays away.
            let _ = kept.parameters.tools.put(ToolEntry { number, length_pm, radius_nm: 0 });
        }
        // This changes many settings at once, so that a copy of everything is long.
        4 => {
            let value = f32::from(bytes.arbitrary::<u8>()?);
            let numbers = SETTING_TABLE.iter().flat_map(|row| row.numbers());
            for number in numbers {
                kept.settings.set(number, value);
            }
        }
        _ => {
            let row = bytes.choose(SETTING_TABLE)?;
            kept.settings.set(row.number, f32::from(bytes.arbitrary::<u16>()?));
        }
    }
    Ok(())
}
