//! Doubles by the RP2040's boot ROM, called without a detour.
//!
//! # Design
//! For each operation on an `f64` the compiler calls a function of ARM's run-time ABI. The HAL's functions check for
//! infinities and NaN before they go to the ROM, some 50 cycles each. Ours jump there at once, in 9. Comparisons compare
//! the bits as whole numbers, in some 10 cycles instead of 60.
//!
//! The price: where IEEE 754 gives NaN, the ROM gives an infinity, and a NaN compares by its bits. So nothing may make a
//! NaN: values are checked where they enter (settings, the words of a line), and the emulated ROM takes an operation
//! whose result would be NaN for a fault. A denormal number is 0, with the HAL's functions too.
//!
//! The ROM of the first chips (B0) has no doubles.
#![cfg_attr(target_os = "none", no_std)]
#![cfg(target_os = "none")]
#![expect(
    unsafe_code,
    reason = "the functions of the run-time ABI are assembly, and where they jump to is set by address"
)]

use core::arch::global_asm;
use core::ptr;

use embassy_rp::rom_data;

/// The functions that are jumped to, in the order of the words of `rp2040_floats_jumps`: their places in the ROM's table
/// of doubles, in words (RP2040 datasheet, section 2.8.3.1.4).
const DOUBLES: [usize; JUMPS - 1] = [
    0,  // add
    1,  // subtract
    2,  // multiply
    3,  // divide
    13, // from u32
    23, // from i64
    25, // from u64
    27, // to i64
    31, // to f32
];
/// The last word: from f32, in the ROM's table of singles.
const TO_DOUBLE: usize = 31;
const JUMPS: usize = 10;

unsafe extern "C" {
    static mut rp2040_floats_jumps: [u32; JUMPS];
}

/// Looks up where this chip's ROM has its functions. To be called once, before the first operation on an `f64`.
pub fn link() {
    let (doubles, singles) = (rom_data::soft_double_table(), rom_data::soft_float_table());
    // SAFETY: the words are read by the assembly below only, which nobody has called yet; the ROM's tables have these
    // entries.
    unsafe {
        let jumps = (&raw mut rp2040_floats_jumps).cast::<u32>();
        for (index, word) in DOUBLES.into_iter().enumerate() {
            ptr::write_volatile(jumps.add(index), *doubles.add(word) as u32);
        }
        ptr::write_volatile(jumps.add(JUMPS - 1), *singles.add(TO_DOUBLE) as u32);
    }
}

// The words to jump to stand among the code, where an instruction reaches them. So the code must be in RAM.
//
// A double is in two registers: the first argument in r0 and r1, the second in r2 and r3, the result in r0 and r1.
global_asm!(
    ".section .text.rp2040_floats, \"ax\", %progbits",
    ".syntax unified",
    ".thumb",
    ".balign 4",
    ".macro function name",
    ".global \\name",
    ".type \\name, %function",
    ".thumb_func",
    "\\name:",
    ".endm",
    // Both arguments are in use: r4 is the way to r12.
    ".macro go_on word",
    "push {{r4}}",
    "ldr r4, .Lrp2040_floats_jump_\\word",
    "mov r12, r4",
    "pop {{r4}}",
    "bx r12",
    ".endm",
    ".macro convert name, word",
    "function \\name",
    "ldr r3, .Lrp2040_floats_jump_\\word",
    "bx r3",
    ".endm",
    "function __aeabi_dadd",
    "go_on 0",
    // b - a
    "function __aeabi_drsub",
    "mov r12, r0",
    "movs r0, r2",
    "mov r2, r12",
    "mov r12, r1",
    "movs r1, r3",
    "mov r3, r12",
    "function __aeabi_dsub",
    "go_on 1",
    "function __aeabi_dmul",
    "go_on 2",
    "convert __aeabi_ui2d, 4",
    "function __aeabi_i2d",
    "asrs r1, r0, #31",
    "convert __aeabi_l2d, 5",
    "convert __aeabi_ul2d, 6",
    "convert __aeabi_d2lz, 7",
    "convert __aeabi_d2f, 8",
    "convert __aeabi_f2d, 9",
    // The ROM divides by the chip's divider. If this has interrupted code that was dividing, the result of that must
    // still be there afterwards: whoever makes the divider busy again saves its state, and restores it, the quotient
    // last.
    "function __aeabi_ddiv",
    "push {{r4, lr}}",
    "ldr r4, 3f",
    "ldr r4, [r4, #0x78]", // DIV_CSR
    "lsrs r4, r4, #2",     // DIRTY
    "bcs 1f",
    "ldr r4, .Lrp2040_floats_jump_3",
    "blx r4",
    "pop {{r4, pc}}",
    "1:",
    "push {{r5, r6, r7}}",
    "ldr r4, 3f",
    "ldr r5, [r4, #0x60]", // DIV_UDIVIDEND
    "ldr r6, [r4, #0x64]", // DIV_UDIVISOR
    "ldr r7, [r4, #0x74]", // DIV_REMAINDER
    "ldr r4, [r4, #0x70]", // DIV_QUOTIENT
    "push {{r4}}",
    "ldr r4, .Lrp2040_floats_jump_3",
    "blx r4",
    "pop {{r3}}",
    "ldr r4, 3f",
    "str r5, [r4, #0x60]",
    "str r6, [r4, #0x64]",
    "str r7, [r4, #0x74]",
    "str r3, [r4, #0x70]",
    "pop {{r5, r6, r7}}",
    "pop {{r4, pc}}",
    ".balign 4",
    "3: .word 0xd0000000", // SIO
    ".global rp2040_floats_jumps",
    ".type rp2040_floats_jumps, %object",
    "rp2040_floats_jumps:",
    ".Lrp2040_floats_jump_0: .word 0",
    ".Lrp2040_floats_jump_1: .word 0",
    ".Lrp2040_floats_jump_2: .word 0",
    ".Lrp2040_floats_jump_3: .word 0",
    ".Lrp2040_floats_jump_4: .word 0",
    ".Lrp2040_floats_jump_5: .word 0",
    ".Lrp2040_floats_jump_6: .word 0",
    ".Lrp2040_floats_jump_7: .word 0",
    ".Lrp2040_floats_jump_8: .word 0",
    ".Lrp2040_floats_jump_9: .word 0",
    // Zeros are equal whatever their signs; other numbers if all their bits are.
    "function __aeabi_dcmpeq",
    "cmp r1, r3",
    "bne 1f",
    "cmp r0, r2",
    "bne 2f",
    "movs r0, #1",
    "bx lr",
    "1:",
    "orrs r1, r3",
    "lsls r1, r1, #1",
    "orrs r1, r0",
    "orrs r1, r2",
    "bne 2f",
    "movs r0, #1",
    "bx lr",
    "2:",
    "movs r0, #0",
    "bx lr",
    // Floats that are not negative are in the order of their bits. The borrow of a subtraction says which is less.
    // a < b
    "function __aeabi_dcmplt",
    "mov r12, r1",
    "orrs r1, r3",
    "bmi 1f",
    "mov r1, r12",
    "subs r0, r0, r2",
    "sbcs r1, r3",
    "sbcs r0, r0",
    "rsbs r0, r0, #0",
    "bx lr",
    "1:",
    "mov r1, r12",
    "b 5f",
    // a > b
    "function __aeabi_dcmpgt",
    "mov r12, r3",
    "orrs r3, r1",
    "bmi 1f",
    "mov r3, r12",
    "subs r2, r2, r0",
    "sbcs r3, r1",
    "sbcs r0, r0",
    "rsbs r0, r0, #0",
    "bx lr",
    "1:",
    "mov r3, r12",
    "b 4f",
    // a >= b
    "function __aeabi_dcmpge",
    "mov r12, r1",
    "orrs r1, r3",
    "bmi 1f",
    "mov r1, r12",
    "subs r0, r0, r2",
    "sbcs r1, r3",
    "sbcs r0, r0",
    "adds r0, r0, #1",
    "bx lr",
    "1:",
    "mov r1, r12",
    "push {{r4, lr}}",
    "bl 5f",
    "b 3f",
    // a <= b
    "function __aeabi_dcmple",
    "mov r12, r3",
    "orrs r3, r1",
    "bmi 1f",
    "mov r3, r12",
    "subs r2, r2, r0",
    "sbcs r3, r1",
    "sbcs r0, r0",
    "adds r0, r0, #1",
    "bx lr",
    "1:",
    "mov r3, r12",
    "push {{r4, lr}}",
    "bl 4f",
    "3:",
    "movs r1, #1",
    "eors r0, r1",
    "pop {{r4, pc}}",
    // a > b, one of them negative: b < a
    "4:",
    "mov r12, r0",
    "movs r0, r2",
    "mov r2, r12",
    "mov r12, r1",
    "movs r1, r3",
    "mov r3, r12",
    // a < b, one of them negative
    "5:",
    "mov r12, r4",
    "movs r4, r1",
    "orrs r4, r3",
    "lsls r4, r4, #1",
    "orrs r4, r0",
    "orrs r4, r2",
    "beq 6f", // zeros of any signs
    "movs r4, r1",
    "ands r4, r3",
    "mov r4, r12",
    "bmi 7f",
    // One of them is negative.
    "lsrs r0, r1, #31",
    "bx lr",
    "6:",
    "mov r4, r12",
    "movs r0, #0",
    "bx lr",
    // Both are: the other way round.
    "7:",
    "subs r2, r2, r0",
    "sbcs r3, r1",
    "sbcs r0, r0",
    "rsbs r0, r0, #0",
    "bx lr",
    ".purgem function",
    ".purgem go_on",
    ".purgem convert",
);
