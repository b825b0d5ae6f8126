//! A timer that interrupts four thousand times a second (of a processor that does 10^9 instructions per second, as
//! `qemu -icount shift=0` has it).

#[cfg(target_arch = "arm")]
mod arm {
    use cortex_m::peripheral::SYST;

    /// Starts the timer and lets it interrupt.
    pub fn start() {
        // SAFETY: SysTick belongs to this program, and its handler is ready when this is called.
        unsafe {
            let systick = &*SYST::PTR;
            systick.rvr.write(25_000_000 / 4000 - 1);
            systick.cvr.write(0);
            systick.csr.write(0b111);
            cortex_m::interrupt::enable();
        }
    }

    /// Waits for an interrupt.
    pub fn sleep() {
        cortex_m::asm::wfi();
    }
}

#[cfg(target_arch = "riscv32")]
mod riscv32 {
    const COMPARE: *mut u32 = 0x0200_4000 as *mut u32;
    const TIME: *const u32 = 0x0200_bff8 as *const u32;
    /// Of 10 MHz.
    const PERIOD: u32 = 10_000_000 / 4000;

    /// Starts the timer and lets it interrupt.
    pub fn start() {
        again();
        // SAFETY: the handler is ready when this is called.
        unsafe {
            riscv::register::mie::set_mtimer();
            riscv::interrupt::enable();
        }
    }

    /// Asks for the next interrupt.
    pub fn again() {
        // SAFETY: the registers of the `virt` board's timer; the high word of a time below 7 minutes is 0.
        unsafe {
            let now = TIME.read_volatile();
            COMPARE.add(1).write_volatile(0);
            COMPARE.write_volatile(now.wrapping_add(PERIOD));
        }
    }

    /// Waits for an interrupt.
    pub fn sleep() {
        riscv::asm::wfi();
    }
}

#[cfg(target_arch = "arm")]
pub use arm::{sleep, start};
#[cfg(target_arch = "riscv32")]
pub use riscv32::{again, sleep, start};
