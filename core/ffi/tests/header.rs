//! The committed header is what cbindgen makes of the source.

use std::path::Path;

/// `SLICECAST_WRITE_HEADER=1 cargo test -p slicecast-ffi --test header` writes it anew.
#[test]
fn the_header_is_fresh() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = here.join("include/slicecast.h");
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::generate_with_config(here, config).unwrap();
    let mut made = Vec::new();
    bindings.write(&mut made);
    let made = String::from_utf8(made).unwrap();
    if std::env::var_os("SLICECAST_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap();
    let differs = committed.lines().zip(made.lines()).position(|(a, b)| a != b);
    assert!(
        committed == made,
        "include/slicecast.h is stale from line {:?}; write it with SLICECAST_WRITE_HEADER=1",
        differs.map(|line| line + 1)
    );
}
