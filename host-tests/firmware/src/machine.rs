//! The machine: how instructions are counted, how a program ends, what a panic does.
//!
//! Under `qemu -icount shift=0` time stands for instructions: one nanosecond each. On Arm, SysTick then ticks once in a
//! whole number of instructions (40 at 25 MHz, 50 at 20 MHz), which is measured; on RISC-V `minstret` counts them singly.

use semihosting::process::{ExitCode, exit};

/// Instructions in a tick of the counter, which has been started: measured with a loop of known length.
#[cfg(target_arch = "arm")]
pub fn instructions_a_tick() -> u64 {
    const TURNS: u32 = 1 << 20;
    let before = ticks();
    // SAFETY: a loop of two instructions on a register of its own.
    unsafe {
        core::arch::asm!("2:", "subs {0}, {0}, #1", "bne 2b", inout(reg) TURNS => _, options(nomem, nostack));
    }
    let passed = u64::from(ticks_between(before, ticks())).max(1);
    (2 * u64::from(TURNS) + passed / 2) / passed
}

/// Instructions in a tick of the counter.
#[cfg(target_arch = "riscv32")]
pub fn instructions_a_tick() -> u64 {
    1
}

/// Starts the counter.
pub fn start_counter() {
    #[cfg(target_arch = "arm")]
    // SAFETY: this program is the only user of SysTick, and it runs on one core.
    unsafe {
        let systick = &*cortex_m::peripheral::SYST::PTR;
        systick.rvr.write(0x00ff_ffff);
        systick.cvr.write(0);
        systick.csr.write(0b101);
    }
}

/// Ticks from one reading to a later one. On Arm they must lie less than 2^24 ticks (671 million instructions) apart.
#[inline]
pub fn ticks_between(first: u32, second: u32) -> u32 {
    if cfg!(target_arch = "arm") {
        first.wrapping_sub(second) & 0x00ff_ffff
    } else {
        second.wrapping_sub(first)
    }
}

/// Reads the counter.
#[inline(always)]
pub fn ticks() -> u32 {
    #[cfg(target_arch = "arm")]
    {
        cortex_m::peripheral::SYST::get_current()
    }
    #[cfg(target_arch = "riscv32")]
    {
        riscv::register::minstret::read() as u32
    }
}

/// Ends the program with its verdict.
pub fn finish(passed: bool) -> ! {
    semihosting::println!("verdict {}", if passed { "pass" } else { "fail" });
    exit(if passed { 0 } else { 1 })
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    semihosting::println!("panic {info}");
    ExitCode::FAILURE.exit_process()
}
