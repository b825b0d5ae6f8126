//! The regressions, as one program: what they link is linked once, and their tests share the processors.

mod c_stages;
mod contract;
mod exhaustive;
mod frames;
mod golden;
mod hard_cases;
mod laboratory;
mod lock_step;
mod packages;
mod small;
mod tolerance;
mod vectors;
