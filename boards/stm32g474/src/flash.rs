//! The flash for settings: the last sectors of the second bank. The program is in the first one, and goes on meanwhile.

use embassy_embedded_hal::adapter::BlockingAsync;
use embassy_stm32::flash::{Blocking, FLASH_SIZE, Flash, MAX_ERASE_SIZE};
use embassy_stm32::{Peri, peripherals};
use isostep_controller::{Settings, Store};

/// As the store wants it. The HAL's flash blocks, which it may: the controller writes at rest only.
pub type SettingsFlash = BlockingAsync<Flash<'static, Blocking>>;

/// 4 to 32 sectors, of which half hold all items twice.
const SECTORS: usize = 8;
const SETTINGS_BYTES: usize = SECTORS * MAX_ERASE_SIZE;

/// Opens the store.
#[must_use]
pub fn open(flash: Peri<'static, peripherals::FLASH>) -> Store<SettingsFlash> {
    let range = (FLASH_SIZE - SETTINGS_BYTES) as u32..FLASH_SIZE as u32;
    Store::new(BlockingAsync::new(Flash::new_blocking(flash)), range, Settings::DEFAULT)
}
