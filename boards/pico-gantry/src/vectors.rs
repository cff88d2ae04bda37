//! The vector table in RAM. If it were in flash, an interrupt would wait for the flash cache.
#![expect(unsafe_code, reason = "the table is copied by address, and the core is told where it is")]

use core::cell::UnsafeCell;
use core::ptr;

use crate::chip;

/// Stack pointer, reset, 14 exceptions, and the interrupts.
const VECTORS: usize = 16 + chip::INTERRUPTS;

unsafe extern "C" {
    /// The place where the linker has put the table: at the beginning of flash, on an RP2040 after the second stage of the boot loader.
    static __vector_table: [u32; VECTORS];
}

#[repr(C)]
struct Table([chip::VectorAlignment; 0], UnsafeCell<[u32; VECTORS]>);

// SAFETY: the table is written once, before the core reads it, and by no one else.
unsafe impl Sync for Table {}

static TABLE: Table = Table([], UnsafeCell::new([0; VECTORS]));

/// Makes the core read its vectors from RAM. To be called once, before any interrupt.
pub fn move_to_ram() {
    // SAFETY: both tables have this size, no one else has a reference to the one that is written, and the core uses it
    // only when it is complete.
    unsafe {
        ptr::copy_nonoverlapping(&raw const __vector_table, TABLE.1.get(), 1);
        cortex_m::asm::dsb();
        (*cortex_m::peripheral::SCB::PTR).vtor.write(TABLE.1.get() as u32);
    }
}
