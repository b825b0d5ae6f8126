//! The regressions, as one program: what they link is linked once, and their tests share the processors.

mod beside;
mod c_segments;
mod c_stages;
mod circles;
mod colours;
mod contract;
mod exhaustive;
mod exported;
mod fast;
mod frames;
mod golden;
mod hard_cases;
mod laboratory;
mod levels;
mod licences;
mod lock_step;
mod packages;
mod parts;
mod perspective;
mod small;
mod splat;
mod splat_eye;
mod tolerance;
mod vectors;

/// Cargo takes this file alone; one beside it that is no module here would never run.
#[test]
fn every_file_is_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let entries = std::fs::read_dir(&folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut files: Vec<String> = names.map(|name| name.trim_end_matches(".rs").to_owned()).collect();
    files.retain(|name| name != "main");
    files.sort();
    // A module's own folder stands beside its file.
    files.dedup();
    let lines = include_str!("main.rs").lines();
    let modules: Vec<&str> = lines
        .filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'))
        .collect();
    assert_eq!(files, modules);
}
