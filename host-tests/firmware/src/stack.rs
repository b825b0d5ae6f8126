//! The stack's high-water mark: free memory is painted when the program starts, and what is no longer painted at the
//! end has been used.

use core::ptr::{addr_of, read_volatile, write_volatile};

const PAINT: u32 = 0x5ec0_de5e;
/// Bytes below the painter's own frame that are left alone.
const MARGIN: usize = 512;

unsafe extern "C" {
    #[link_name = "__sheap"]
    static END_OF_STATICS: u32;
    #[link_name = "_stack_start"]
    static TOP: u32;
}

/// Paints the free memory. Call it first.
#[inline(never)]
pub fn paint() {
    let here = 0u32;
    let mut at = addr_of!(END_OF_STATICS) as usize;
    let end = (addr_of!(here) as usize).saturating_sub(MARGIN);
    while at < end {
        // SAFETY: the words between the statics and this function's frame are not in use yet (the linker script's
        // symbols bound them), and they are aligned.
        unsafe { write_volatile(at as *mut u32, PAINT) };
        at += 4;
    }
}

/// Bytes of stack that have been used since [`paint`] (at least the painter's own margin).
pub fn high_water() -> usize {
    let mut at = addr_of!(END_OF_STATICS) as usize;
    let top = addr_of!(TOP) as usize;
    // SAFETY: as in `paint`; reading memory of one's own stack and below it.
    while at < top && unsafe { read_volatile(at as *const u32) } == PAINT {
        at += 4;
    }
    top - at
}
