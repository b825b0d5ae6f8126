//! The program as a command.

use std::process::Command;

/// Before anything is built or installed.
#[test]
fn a_machine_that_is_not_known_is_refused_by_name() {
    let output = Command::new(env!("CARGO_BIN_EXE_run-firmware"))
        .arg("z80")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("FAILED: no machine \"z80\"; known: "), "{said}");
    assert!(said.contains("mps2-an386"), "{said}");
}
