//! What a report was made on.

/// Processor, its number of threads, and the system, in words.
pub fn describe() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (arch, system) = (std::env::consts::ARCH, std::env::consts::OS);
    let model = processor().unwrap_or_else(|| "unknown processor".into());
    format!("{model}, {threads} threads, {arch}, {system}")
}

/// The processor's name, where the system tells it in a file.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
