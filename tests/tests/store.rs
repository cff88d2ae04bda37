//! Tests of the store in flash: with power cuts at any time, with arbitrary contents of flash, and on the simulated
//! machine.
//!
//! Every run is the same; a failure prints the command that runs its case alone.

use std::env;
use std::pin::pin;
use std::task::{Context, Waker};

use embassy_futures::block_on;
use embassy_time::Duration;
use isostep_console::parameters::WORK_SYSTEMS;
use isostep_console::{RADIUS_MAX_NM, ToolEntry};
use isostep_controller::store::{Item, Kept, Loss, Store};
use isostep_controller::{Parameters, Settings};
use isostep_motion::State;
use isostep_sim::flash::{FLASH_BYTES, SECTOR_BYTES, WordFlash};
use isostep_sim::{Config, Flash, Sim};
use isostep_trials::{cases, window};
use oorandom::Rand64;

const CUTS_PER_CASE: u64 = 100;
/// The fewest sectors of 4 KiB that a store takes.
const FEW_SECTORS: usize = 6;
/// The work offsets, and the positions of G28 and G30.
const PLACES: u64 = WORK_SYSTEMS as u64 + 2;

fn defaults() -> Kept {
    Kept { settings: Settings::DEFAULT, parameters: Parameters::default() }
}

fn opened<const WORD_BYTES: usize>(
    flash: &WordFlash<WORD_BYTES>,
    sectors: usize,
) -> (Store<WordFlash<WORD_BYTES>>, Result<(), Loss>) {
    let mut store = Store::new(flash.clone(), 0..(sectors * SECTOR_BYTES) as u32, Settings::DEFAULT);
    let loaded = block_on(store.load());
    (store, loaded)
}

fn save<const WORD_BYTES: usize>(store: &mut Store<WordFlash<WORD_BYTES>>, wanted: &Kept) -> bool {
    block_on(store.save(true, |item| wanted.value(item))).is_ok()
}

/// True if so many changes, one after the other, are all accepted.
fn saves_changes(store: &mut Store<Flash>, wanted: &mut Kept, random: &mut Rand64, changes: usize) -> bool {
    (0..changes).all(|_| {
        change(wanted, random);
        save(store, wanted)
    })
}

/// Bits that are chosen at random, in the first sectors.
fn flip_bits(flash: &Flash, random: &mut Rand64, bits: u64) {
    flash.change(|bytes| {
        for _ in 0..bits {
            bytes[random.rand_range(0..(FEW_SECTORS * SECTOR_BYTES) as u64) as usize] ^= 1 << random.rand_range(0..8);
        }
    });
}

/// Changes one item; in some cases resets all of them.
fn change(kept: &mut Kept, random: &mut Rand64) {
    let numbers: Vec<u16> = isostep_console::SETTING_TABLE.iter().flat_map(|row| row.numbers()).collect();
    match random.rand_range(0..20) {
        0 => *kept = defaults(),
        1 => {
            let line = "G1X9F".repeat(random.rand_range(0..16) as usize);
            let line = line.as_str().try_into().unwrap();
            match random.rand_range(0..3) {
                2 => kept.parameters.build_text = line,
                index => kept.parameters.startup[index as usize] = line,
            }
        }
        2..=5 => {
            let place = random.rand_range(0..PLACES) as usize;
            *kept.parameters.coordinates.iter_mut().nth(place).unwrap() =
                std::array::from_fn(|_| random.rand_range(0..1_000_000_000_000) as i64);
        }
        6..=8 => {
            let number = random.rand_range(1..40) as u32;
            let length_pm = random.rand_range(0..1_000_000_000_000) as i64 - 500_000_000_000;
            let radius_nm = random.rand_range(0..2) as u32 * RADIUS_MAX_NM;
            // A tool for which there is no room stays away.
            let _ = kept.parameters.tools.put(ToolEntry { number, length_pm, radius_nm });
        }
        _ => {
            let number = numbers[random.rand_range(0..numbers.len() as u64) as usize];
            kept.settings.set(number, random.rand_range(0..60_000) as f32);
        }
    }
}

/// The fewest sectors that have room for all items, by the length of a word.
fn fewest_sectors<const WORD_BYTES: usize>() -> usize {
    match WORD_BYTES {
        32 => 13,
        16 => 8,
        _ => FEW_SECTORS,
    }
}

fn refuses_fewer_sectors<const WORD_BYTES: usize>() {
    let fewest = fewest_sectors::<WORD_BYTES>();
    let fewer = std::panic::catch_unwind(|| opened(&WordFlash::<WORD_BYTES>::blank(), fewest - 1).1.is_ok());
    assert!(opened(&WordFlash::<WORD_BYTES>::blank(), fewest).1.is_ok() && fewer.is_err(), "{WORD_BYTES}");
}

#[test]
fn a_flash_without_room_for_all_items_is_refused() {
    refuses_fewer_sectors::<1>();
    refuses_fewer_sectors::<16>();
    refuses_fewer_sectors::<32>();
}

/// One flash through many power cuts, each during some operation on it. No word of it is ever programmed twice.
fn survive_power_cuts<const WORD_BYTES: usize>(case: u64) {
    let mut random = Rand64::new(case.into());
    let sectors = if case.is_multiple_of(2) { fewest_sectors::<WORD_BYTES>() } else { 16 };
    let flash = WordFlash::<WORD_BYTES>::blank();
    let (mut store, mut used) = (opened(&flash, sectors).0, false);
    let mut cuts = 0;
    while cuts < CUTS_PER_CASE {
        // A copy of all items takes two operations per item. Sometimes the power lasts that long.
        flash.cut_power_after(random.rand_range(0..4 * Item::all().count() as u64), random.rand_u64());
        let (mut old, mut wanted) = (store.kept().clone(), store.kept().clone());
        loop {
            change(&mut wanted, &mut random);
            if !save(&mut store, &wanted) {
                break;
            }
            (old, used) = (wanted.clone(), true);
        }
        cuts += 1;
        flash.mend();
        // Loading may have to repair something. The power goes during loading too.
        flash.cut_power_after(random.rand_range(0..2), random.rand_u64());
        let _ = opened(&flash, sectors);
        flash.mend();
        let loaded;
        (store, loaded) = opened(&flash, sectors);
        assert!(loaded.is_ok() || !used, "cut {cuts}: {loaded:?}");
        for item in Item::all() {
            let value = store.kept().value(item);
            assert!(
                value == old.value(item) || value == wanted.value(item),
                "cut {cuts}: {item:?} is {value:?}, was {:?}, to be {:?}",
                old.value(item),
                wanted.value(item)
            );
        }
    }
}

#[test]
fn power_cuts_leave_every_item_old_or_new() {
    let only = env::var("STORE_CASE").ok().map(|case| case.parse().expect("STORE_CASE is a number"));
    for case in only.map_or(window(cases(10, 30)), |case| case..case + 1) {
        let replay = format!("again: STORE_CASE={case} cargo test -p isostep-tests store::power_cuts");
        // Each length of a word, with few sectors and with many.
        let survive = match case / 2 % 5 {
            0 => survive_power_cuts::<1>,
            1 => survive_power_cuts::<4>,
            2 => survive_power_cuts::<8>,
            3 => survive_power_cuts::<16>,
            _ => survive_power_cuts::<32>,
        };
        if std::panic::catch_unwind(|| survive(case)).is_err() {
            panic!("{replay}");
        }
    }
}

/// The power cuts a header short, and what is left of it claims to be a longer one than any that was written, with a checksum that fits:
/// once in some ten thousand cuts, of which this is one.
#[test]
fn a_header_that_is_cut_short_may_claim_to_be_longer() {
    survive_power_cuts::<1>(130);
}

/// The power fails while the log goes on to another sector. A mark of which only a few bits are programmed is no longer
/// blank, although the log would take it for that.
#[test]
fn a_faint_mark_is_not_programmed_again() {
    let (blank, mut wanted) = (Flash::blank(), defaults());
    let mut store = opened(&blank, FEW_SECTORS).0;
    let mut value = 0.0;
    let before = loop {
        let (bytes, operations) = (blank.bytes(), blank.operations());
        value += 1.0;
        wanted.settings.set(110, value);
        assert!(save(&mut store, &wanted));
        // More than the header of an item and its value.
        if operations > 100 && blank.operations() - operations > 2 {
            break bytes;
        }
    };
    for (operations, seed) in (0..6).flat_map(|operation| window(cases(100, 1000)).map(move |seed| (operation, seed))) {
        let flash = Flash::with(before.clone());
        let mut store = opened(&flash, FEW_SECTORS).0;
        flash.cut_power_after(operations, seed);
        assert!(!save(&mut store, &wanted), "the power fails after {operations} operations");
        flash.mend();
        let mut store = opened(&flash, FEW_SECTORS).0;
        assert!(save(&mut store, &wanted));
        assert_eq!(opened(&flash, FEW_SECTORS).0.kept(), &wanted, "{operations} operations, seed {seed}");
    }
}

/// No sector is erased more than necessary: the changes take 16 bytes each and fill the flash 2.4 times, and each half
/// of the flash contains one copy of everything.
#[test]
fn changes_wear_all_sectors_alike() {
    let flash = Flash::blank();
    let (mut store, _) = opened(&flash, 16);
    let mut wanted = defaults();
    for value in 0..10_000 {
        wanted.settings.set(110, value as f32);
        assert!(save(&mut store, &wanted));
    }
    let erases = flash.erases();
    assert!(erases.iter().all(|erases| (2..=3).contains(erases)), "{erases:?}");
    assert_eq!(opened(&flash, 16).0.kept(), &wanted);
}

#[test]
fn a_change_of_one_item_writes_one_item() {
    let flash = Flash::blank();
    let (mut store, _) = opened(&flash, 16);
    let mut wanted = defaults();
    wanted.settings.set(110, 1234.0);
    assert!(save(&mut store, &wanted));
    let before = flash.operations();
    wanted.settings.set(130, 300.0);
    assert!(save(&mut store, &wanted));
    // The item's header and its value.
    assert_eq!(flash.operations() - before, 2);
    assert!(save(&mut store, &wanted));
    assert_eq!(flash.operations() - before, 2, "nothing has changed");
}

/// A change may be dropped or refused at any point. Reverting it must then be stored like a change.
#[test]
fn a_change_that_was_dropped_and_taken_back_is_taken_back_in_flash_too() {
    let old = defaults();
    let mut new = defaults();
    new.settings.set(110, 1234.0);
    for polls in 1..8 {
        let flash = Flash::blank();
        let (mut store, _) = opened(&flash, FEW_SECTORS);
        let mut other = defaults();
        other.settings.set(111, 999.0);
        assert!(save(&mut store, &other));
        {
            let mut dropped = pin!(store.save(true, |item| new.value(item)));
            let mut context = Context::from_waker(Waker::noop());
            (0..polls).any(|_| dropped.as_mut().poll(&mut context).is_ready());
        }
        assert!(save(&mut store, &old));
        assert_eq!(opened(&flash, FEW_SECTORS).0.kept(), &old, "after {polls} polls");
    }
    for (operations, seed) in (0..4).flat_map(|operations| (0..200).map(move |seed| (operations, seed))) {
        let flash = Flash::blank();
        let (mut store, _) = opened(&flash, FEW_SECTORS);
        assert!(save(&mut store, &old));
        // In some cases the change was stored completely before the power went.
        flash.cut_power_after(operations, seed);
        let _ = save(&mut store, &new);
        flash.mend();
        assert!(save(&mut store, &old));
        assert_eq!(opened(&flash, FEW_SECTORS).0.kept(), &old, "refused after {operations} operations, {seed}");
    }
}

/// The checksum of an item in the log: CRC-32C with start value 0xEEEEEEEE, whose first byte is never 0x00 or 0xFF.
fn sum(data: &[u8]) -> u32 {
    let step = |sum: u32| if sum & 1 == 1 { sum >> 1 ^ 0x82F6_3B78 } else { sum >> 1 };
    let sum = !data.iter().fold(0xEEEE_EEEE, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), |sum, _| step(sum)));
    if matches!(sum.to_le_bytes()[0], 0x00 | 0xFF) { sum ^ 1 } else { sum }
}

/// A flash in which these settings are stored.
fn stored(settings: &[(u16, f32)]) -> Flash {
    let flash = Flash::blank();
    let (mut store, _) = opened(&flash, 16);
    let mut wanted = defaults();
    assert!(settings.iter().all(|&(number, value)| wanted.settings.set(number, value)));
    assert!(save(&mut store, &wanted));
    flash
}

/// Puts other bytes at the beginning of an item, and makes its checksum fit.
fn rewrite(flash: &Flash, item: &[u8], beginning: &[u8]) {
    flash.change(|bytes| {
        let place = bytes.windows(item.len()).position(|window| window == item).expect("the item");
        bytes[place..place + beginning.len()].copy_from_slice(beginning);
        let sum = sum(&bytes[place..place + item.len()]);
        bytes[place - 8..place - 4].copy_from_slice(&sum.to_le_bytes());
    });
}

/// A setting as it stands in the flash.
fn item((number, value): (u16, f32)) -> Vec<u8> {
    [&number.to_le_bytes()[..], &value.to_le_bytes()].concat()
}

/// A flash in which $110 is 1234, as another version of the firmware would have left it.
fn of_another_version() -> Flash {
    let flash = stored(&[(110, 1234.0)]);
    rewrite(&flash, &[0xFF, 0xFF, 1, 0, 0, 0], &[0xFF, 0xFF, 2]);
    flash
}

#[test]
fn another_version_is_not_read() {
    let flash = of_another_version();
    let (mut store, loaded) = opened(&flash, 16);
    assert_eq!((loaded, store.kept()), (Err(Loss::OtherVersion), &defaults()));
    let mut wanted = defaults();
    wanted.settings.set(111, 999.0);
    assert!(save(&mut store, &wanted));
    let (store, loaded) = opened(&flash, 16);
    assert_eq!((loaded, store.kept()), (Ok(()), &wanted));
}

fn garbage(seed: u64) -> Flash {
    let mut random = Rand64::new(seed.into());
    Flash::with((0..FLASH_BYTES).map(|_| random.rand_range(0..256) as u8).collect())
}

#[test]
fn garbage_is_not_read() {
    for seed in window(cases(10, 50)) {
        let flash = garbage(seed);
        let (mut store, loaded) = opened(&flash, 16);
        assert_eq!((loaded, store.kept()), (Err(Loss::Unreadable), &defaults()), "seed {seed}");
        let mut wanted = defaults();
        wanted.settings.set(111, 999.0);
        assert!(save(&mut store, &wanted));
        let (store, loaded) = opened(&flash, 16);
        assert_eq!((loaded, store.kept()), (Ok(()), &wanted), "seed {seed}");
    }
}

#[test]
fn flipped_bits_never_panic_and_never_stop_a_change() {
    for seed in window(cases(5, 200)) {
        let mut random = Rand64::new(seed.into());
        let (flash, mut wanted) = (Flash::blank(), defaults());
        let (mut store, _) = opened(&flash, FEW_SECTORS);
        assert!(saves_changes(&mut store, &mut wanted, &mut random, 100), "seed {seed}");
        let bits = random.rand_range(1..2000);
        flip_bits(&flash, &mut random, bits);
        let (mut store, _) = opened(&flash, FEW_SECTORS);
        assert!(saves_changes(&mut store, &mut wanted, &mut random, 2000), "seed {seed}");
        assert_eq!(opened(&flash, FEW_SECTORS).0.kept(), &wanted, "seed {seed}");
    }
}

/// The lines that the machine sends after power-up and in answer to `lines`.
fn said(flash: &Flash, lines: &str) -> Vec<String> {
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    sim.send(lines.as_bytes());
    sim.run_until_idle().unwrap();
    sim.replies()
}

#[test]
fn all_that_grbl_stores_outlives_a_power_cycle() {
    let flash = Flash::blank();
    said(
        &flash,
        "$6=1\n$30=24000\n$31=100.5\n$32=1\n$110=1234\n$130=300\nG10 L2 P1 X5\nG10 L20 P3 Y7\nG0 X2\nG28.1\nG30.1\n$N1=G21\n",
    );
    let next = said(&flash, "$$\n$#\n$N\n");
    for line in [
        "$6=1",
        "$30=24000.000",
        "$31=100.500",
        "$32=1",
        "$110=1234.000",
        "$130=300.000",
        "[G54:5.000,0.000,0.000]",
        "[G56:0.000,-7.000,0.000]",
        "[G28:7.000,0.000,0.000]",
        "[G30:7.000,0.000,0.000]",
        "$N1=G21",
        ">G21:ok",
    ] {
        assert!(next.contains(&line.to_owned()), "{line} is not in {next:?}");
    }
    assert!(!next.iter().any(|line| line.starts_with("[MSG:")), "{next:?}");
}

#[test]
fn the_defaults_put_back_outlive_a_power_cycle() {
    let flash = Flash::blank();
    said(&flash, "$110=1234\nG10 L2 P1 X5\n$RST=$\n");
    let next = said(&flash, "$$\n$#\n");
    assert!(next.contains(&"$110=2880.000".to_owned()) && next.contains(&"[G54:5.000,0.000,0.000]".to_owned()));
    said(&flash, "$RST=*\n");
    assert!(said(&flash, "$#\n").contains(&"[G54:0.000,0.000,0.000]".to_owned()));
}

#[test]
fn what_is_not_as_stored_is_reported_after_the_welcome_until_it_is_stored_anew() {
    for (flash, words) in [
        (garbage(1), "[MSG:what flash holds cannot be read"),
        (of_another_version(), "[MSG:what flash holds is another version's"),
        (refused(), "[MSG:stored settings refused, $27=200 is above the most, 100 mm: lower it"),
    ] {
        let heard = said(&flash, "$$\n");
        assert!(heard[0].starts_with("Grbl") && heard[1].starts_with(words), "{heard:?}");
        assert!(heard[1].contains("the defaults are in force: set yours again, or keep these by $RST=*"), "{heard:?}");
        assert!(heard.contains(&"$110=2880.000".to_owned()), "{heard:?}");
        let heard = said(&flash, "$RST=*\n");
        assert_eq!(heard[2..], ["[MSG:Restoring defaults]", "ok", "Grbl 1.1h ['$' for help]"], "{heard:?}");
        assert_eq!(said(&flash, ""), ["Grbl 1.1h ['$' for help]"]);
    }
}

/// A pull-off that cannot be.
fn refused() -> Flash {
    stored(&[(27, 200.0), (100, 60.0)])
}

#[test]
fn refused_settings_stay_stored_until_others_are_set() {
    let flash = refused();
    said(&flash, "G10 L2 P2 X1\n");
    let (store, _) = opened(&flash, 16);
    assert_eq!(store.kept().settings.get(100), Some(60.0));
    assert_eq!(store.kept().parameters.coordinates.work_offsets_pm[1], [1_000_000_000, 0, 0]);
}

/// The message after the welcome comes with every reset, until what it is about has been stored anew.
#[test]
fn a_loss_is_reported_until_it_is_made_good() {
    let said_after = |flash: &Flash, line: &str| {
        let mut sim = Sim::with_flash(&Config::default(), flash.clone());
        sim.send(format!("{line}\n").as_bytes());
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies().last().map(String::as_str), Some("ok"));
        sim.send(b"\x18");
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        assert!(heard[0].starts_with("Grbl"), "{heard:?}");
        heard[1..].to_vec()
    };
    // Settings that are refused are lost until settings are stored; other items do not matter.
    let flash = refused();
    assert!(said_after(&flash, "G10 L2 P2 X1")[0].starts_with("[MSG:stored settings refused"));
    assert_eq!(said_after(&flash, "$110=1234"), [""; 0]);
    // What cannot be read is all lost, so whatever is stored begins anew.
    assert_eq!(said_after(&garbage(1), "G10 L2 P2 X1"), [""; 0]);
}

/// An item whose value is not of its kind: nothing that was stored with it can be relied on.
#[test]
fn a_value_of_another_kind_is_not_read() {
    let setting = (110, 1234.0);
    let flash = stored(&[setting]);
    // The same bytes as the origin of G54, which takes twelve.
    rewrite(&flash, &item(setting), &0x4000_u16.to_le_bytes());
    let (store, loaded) = opened(&flash, 16);
    assert_eq!((loaded, store.kept()), (Err(Loss::Unreadable), &defaults()));
}

/// Firmware without shapers has stored no setting of theirs: here each of these items has a key that means nothing.
#[test]
fn what_was_stored_before_there_were_shapers_is_read() {
    let mut before = defaults();
    before.settings.set(940, 1.0);
    let of_shapers = [(950, 2.0), (961, 35.0), (972, 0.1)];
    let flash = stored(&[&[(940, 1.0)], &of_shapers[..]].concat());
    of_shapers.into_iter().for_each(|setting| rewrite(&flash, &item(setting), &999_u16.to_le_bytes()));
    let (store, loaded) = opened(&flash, 16);
    assert_eq!((loaded, store.kept()), (Ok(()), &before));
    // A shaper would have refused the curved speed profile.
    assert_eq!(said(&flash, "").len(), 1);
}

/// Places were stored as 32-bit floats in mm once. Such an item is made of a text, which is as long.
#[test]
fn a_place_that_was_stored_in_floats_is_still_read() {
    let flash = Flash::blank();
    let (mut store, _) = opened(&flash, 16);
    let mut wanted = defaults();
    let floats_mm = [2.0_f32, -12.015_686, 0.5];
    let mut text: Vec<u8> = floats_mm.iter().flat_map(|mm| mm.abs().to_le_bytes()).collect();
    wanted.parameters.build_text =
        std::str::from_utf8(&text).expect("none of the bytes is above 127").try_into().unwrap();
    assert!(save(&mut store, &wanted));
    flash.change(|bytes| {
        let place = bytes.windows(12).position(|window| window == text).expect("the item") - 2;
        // The sign of Y, which no text has.
        text[7] |= 0x80;
        bytes[place..place + 2].copy_from_slice(&0x4000_u16.to_le_bytes());
        bytes[place + 2..place + 14].copy_from_slice(&text);
        let sum = sum(&bytes[place..place + 14]);
        bytes[place - 8..place - 4].copy_from_slice(&sum.to_le_bytes());
    });
    let (store, loaded) = opened(&flash, 16);
    let place_pm = &store.kept().parameters.coordinates.work_offsets_pm[0];
    assert_eq!((loaded, place_pm), (Ok(()), &[2_000_000_000, -12_015_686_035, 500_000_000]));
}

/// An offset that no float holds is the same after a power cycle.
#[test]
fn an_offset_is_kept_exactly() {
    let flash = Flash::blank();
    said(&flash, "G20 G10 L2 P1 X9.00001 Y-0.3\nG21 G91 G0 X0.0375\nG28.1\n");
    let (store, _) = opened(&flash, 16);
    assert_eq!(store.kept().parameters.coordinates.work_offsets_pm[0], [228_600_254_000, -7_620_000_000, 0]);
    assert_eq!(store.kept().parameters.coordinates.places_pm[0], [37_500_000, 0, 0]);
}

/// The bits change while the machine is on. A change that finds the log damaged writes all of it anew.
#[test]
fn bits_that_flip_under_a_running_machine_never_stop_a_change() {
    for seed in window(cases(20, 100)) {
        let mut random = Rand64::new(seed.into());
        let (flash, mut wanted) = (Flash::blank(), defaults());
        let (mut store, _) = opened(&flash, FEW_SECTORS);
        assert!(saves_changes(&mut store, &mut wanted, &mut random, 20), "seed {seed}");
        flip_bits(&flash, &mut random, 2000);
        assert!(saves_changes(&mut store, &mut wanted, &mut random, 20), "seed {seed}");
    }
}

/// The last word of a sector, which is programmed when the sector is full.
const LAST_WORD_BYTES: usize = 8;

/// A flash whose log goes on in the only sector that is not full, its store, and what is kept there.
fn nearly_full() -> (Flash, Store<Flash>, Kept) {
    let (flash, mut wanted) = (Flash::blank(), defaults());
    let mut store = opened(&flash, FEW_SECTORS).0;
    let mut value = 0.0;
    while open_ends(&flash).len() != 1 {
        value += 1.0;
        wanted.settings.set(110, value);
        assert!(save(&mut store, &wanted));
    }
    (flash, store, wanted)
}

/// The place of the last word of each sector that is not full.
fn open_ends(flash: &Flash) -> Vec<usize> {
    let bytes = flash.bytes();
    let ends = (1..=FEW_SECTORS).map(|sector| sector * SECTOR_BYTES - LAST_WORD_BYTES);
    ends.filter(|&end| bytes[end..end + LAST_WORD_BYTES] == [0xFF; LAST_WORD_BYTES]).collect()
}

/// A bit flips, and the sector that the log goes on in seems full as all others. Whatever is stored next, everything that is in
/// force is stored again: the settings too, of which none has changed, and also if the flash refuses on the way.
#[test]
fn a_log_that_cannot_be_continued_is_written_again() {
    // Erasing takes six operations, and the new log's first sector four.
    for refused_after in [None, Some(0), Some(2), Some(5), Some(7), Some(9), Some(11), Some(13)] {
        let (flash, mut store, mut wanted) = nearly_full();
        let end = open_ends(&flash)[0];
        flash.change(|bytes| bytes[end] ^= 1);
        wanted.parameters.coordinates.work_offsets_pm[2][0] = 7_000_000_000;
        let save_places = |store: &mut Store<Flash>| block_on(store.save(false, |item| wanted.value(item)));
        if let Some(operations) = refused_after {
            flash.cut_power_after(operations, 1);
            assert!(save_places(&mut store).is_err(), "refused after {operations} operations");
            flash.mend();
        }
        assert_eq!(save_places(&mut store), Ok(()));
        let (store, loaded) = opened(&flash, FEW_SECTORS);
        assert_eq!((loaded, store.kept()), (Ok(()), &wanted), "refused after {refused_after:?} operations");
    }
}

#[test]
fn nothing_is_stored_while_anything_moves() {
    let flash = Flash::blank();
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    sim.send(b"G0 X20\nG10 L2 P2 X5\nG0 X0\nG28.1\n");
    let mut seen = 0;
    for _ in 0..4_000 {
        sim.run_for(Duration::from_millis(1)).unwrap();
        let steps = sim.counted_steps();
        let stored = flash.operations();
        if sim.machine().state() == State::Run && steps != [0; 3] && steps != [1000, 0, 0] {
            assert_eq!(stored, seen, "at {steps:?}");
        }
        seen = stored;
    }
    let (store, _) = opened(&flash, 16);
    assert_eq!(store.kept().parameters.coordinates.work_offsets_pm[1], [5_000_000_000, 0, 0]);
}

#[test]
fn what_a_reset_cut_short_is_stored_after_it() {
    let flash = Flash::blank();
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    sim.send(b"G0 X20\nG10 L2 P2 X5\n");
    sim.run_for(Duration::from_millis(300)).unwrap();
    assert_eq!(flash.operations(), 0);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(opened(&flash, 16).0.kept().parameters.coordinates.work_offsets_pm[1], [5_000_000_000, 0, 0]);
}
