//! The vector table in RAM: an interrupt whose vector has to come from flash waits for its cache.
#![expect(unsafe_code, reason = "the table is copied by address, and the core is told where it is")]

use core::cell::UnsafeCell;
use core::ptr;

/// Stack pointer, reset, 14 exceptions, and 32 interrupts.
const VECTORS: usize = 48;

unsafe extern "C" {
    /// Where the linker has put the table: the beginning of flash, behind the second stage of the boot loader.
    static __vector_table: [u32; VECTORS];
}

/// The core takes multiples of 256 for a table's address.
#[repr(C, align(256))]
struct Table(UnsafeCell<[u32; VECTORS]>);

// SAFETY: it is written once, before the core looks at it, and by nobody else.
unsafe impl Sync for Table {}

static TABLE: Table = Table(UnsafeCell::new([0; VECTORS]));

/// From now on vectors are read from RAM. To be called once, before anything is interrupted.
pub fn move_to_ram() {
    // SAFETY: both tables are of this size, nobody else has a reference to the one that is written, and the core is told of it
    // when it is complete.
    unsafe {
        ptr::copy_nonoverlapping(&raw const __vector_table, TABLE.0.get(), 1);
        cortex_m::asm::dsb();
        (*cortex_m::peripheral::SCB::PTR).vtor.write(TABLE.0.get() as u32);
    }
}
