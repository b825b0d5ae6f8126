//! Slices as they arrive: a timer interrupt plays the scanner and delivers slices through a queue, the main loop renders.
//!
//! Three buffers go round: the interrupt takes an empty one, fills it and passes it on; the main loop renders it and
//! gives it back. Where none is empty the scanner waits, where none is full the renderer sleeps; nothing is lost. The
//! scanner is faster than the renderer for the first half of the volume and slower for the second, so both are seen.
#![no_std]
#![no_main]

use core::cell::RefCell;

use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer, Queue};
use semihosting::println;
use slicecast::composite::Unorm16;
use slicecast::precision::Compact;
use slicecast::shade::Phong;
use slicecast::stream::Stream;
use slicecast_firmware::machine::finish;
use slicecast_firmware::memory::Reserved;
use slicecast_firmware::scenes::{DENSE, DENSE_COMPACT_LIT};
use slicecast_firmware::timer;
use slicecast_firmware_shared::image;
use slicecast_firmware_shared::scene::pipeline;
use slicecast_firmware_shared::sum::Sum;
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// A slice on its way.
type Buffer = &'static mut [u16; 64 * 64];
/// Turns of the timer that the slow half takes for a slice.
const SLOW: u32 = 12;

static MEMORY: ConstStaticCell<Reserved<Unorm16, { 4 * 64 * 64 }, 256, { 17 * 66 }, { 4 * 128 * 128 }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static BUFFERS: ConstStaticCell<[[u16; 64 * 64]; 3]> = ConstStaticCell::new([[0; 64 * 64]; 3]);
static EMPTY: ConstStaticCell<Queue<Buffer, 4>> = ConstStaticCell::new(Queue::new());
static FULL: ConstStaticCell<Queue<Buffer, 4>> = ConstStaticCell::new(Queue::new());
static SCANNER: Mutex<RefCell<Option<Scanner>>> = Mutex::new(RefCell::new(None));

/// The interrupt's side.
struct Scanner {
    empty: Consumer<'static, Buffer>,
    full: Producer<'static, Buffer>,
    slices: core::slice::ChunksExact<'static, u16>,
    turn: u32,
    waited: u32,
}

impl Scanner {
    /// One turn of the timer: perhaps one slice.
    fn turn(&mut self) {
        self.turn += 1;
        let second_half = self.slices.len() <= 32;
        if self.slices.len() == 0 || (second_half && !self.turn.is_multiple_of(SLOW)) {
            return;
        }
        let Some(buffer) = self.empty.dequeue() else {
            self.waited += 1;
            return;
        };
        if let Some(slice) = self.slices.next() {
            for (to, from) in buffer.iter_mut().zip(slice) {
                *to = *from;
            }
            // There are as many places as buffers.
            let _ = self.full.enqueue(buffer);
        }
    }
}

/// What the interrupt does.
fn interrupt() {
    critical_section::with(|token| {
        if let Some(scanner) = SCANNER.borrow_ref_mut(token).as_mut() {
            scanner.turn();
        }
    });
}

#[cfg(target_arch = "arm")]
#[cortex_m_rt::exception]
fn SysTick() {
    interrupt();
}

#[cfg(target_arch = "riscv32")]
#[riscv_rt::core_interrupt(riscv::interrupt::Interrupt::MachineTimer)]
fn machine_timer() {
    timer::again();
    interrupt();
}

#[entry]
fn main() -> ! {
    println!("case {} compact lit", DENSE.name);
    let (Ok(plan), Ok(pipeline)) = (DENSE.plan(), pipeline::<Compact, Phong<Compact>>(DENSE)) else {
        println!("error the scene is out of range");
        finish(false)
    };
    let memory = MEMORY.take();
    let Ok(mut stream) = Stream::new(plan, &pipeline, memory.lend()) else {
        println!("error too little memory");
        finish(false)
    };
    let (mut give, empty) = EMPTY.take().split();
    let (full, mut take) = FULL.take().split();
    for buffer in BUFFERS.take() {
        let _ = give.enqueue(buffer);
    }
    let scanner = Scanner {
        empty,
        full,
        slices: DENSE.voxels.chunks_exact(64 * 64),
        turn: 0,
        waited: 0,
    };
    critical_section::with(|token| SCANNER.borrow_ref_mut(token).replace(scanner));
    timer::start();

    let (mut slept, mut most) = (0, 0);
    while stream.wanted().is_some() {
        most = most.max(take.len());
        let Some(buffer) = take.dequeue() else {
            slept += 1;
            timer::sleep();
            continue;
        };
        if stream.push(buffer).is_err() {
            println!("error slice refused");
        }
        let _ = give.enqueue(buffer);
    }
    let waited = critical_section::with(|token| SCANNER.borrow_ref(token).as_ref().map_or(0, |s| s.waited));
    let mut sum = Sum::new();
    image::add_rows(&mut sum, stream.image());
    println!("queue {slept} sleeps of the renderer, {waited} waits of the scanner, {most} slices at most in the queue");
    println!("image {:08x}", sum.get());
    finish(sum.get() == DENSE_COMPACT_LIT && slept > 0 && waited > 0 && most == 2)
}
