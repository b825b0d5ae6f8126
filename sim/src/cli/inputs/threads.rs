//! Threads and vectors on the command line.

use slicecast_engine::simd::Simd;

/// How many threads.
#[derive(clap::Args)]
pub struct ThreadArgs {
    /// Threads; without it, one a processor. The picture does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Vectors to compute with; without it, the widest that the processor has. The picture does not depend on them.
    #[arg(long, value_name = "WIDTH", value_parser = simd)]
    simd: Option<Simd>,
}

/// A vector width by its name, if this processor has it.
fn simd(name: &str) -> Result<Simd, String> {
    if !Simd::NAMES.contains(&name) {
        return Err(format!("accepted: {}", Simd::NAMES.join(", ")));
    }
    let found = Simd::available().find(|simd| simd.name() == name);
    found.ok_or_else(|| format!("this processor has no {name}"))
}

impl ThreadArgs {
    /// The number asked for.
    pub fn count(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    /// The vectors asked for.
    pub fn simd(&self) -> Simd {
        self.simd.unwrap_or_else(Simd::widest)
    }
}
