//! Every package that can be published stands by itself: licences, a page of its own, and dependencies with versions.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The folders of the workspace's packages that can be published.
fn published() -> Vec<PathBuf> {
    let manifest = read(&root().join("Cargo.toml"));
    let members = manifest.split("members = [").nth(1).unwrap().split(']').next().unwrap();
    let folders = members.split('"').skip(1).step_by(2).map(|member| root().join(member));
    folders
        .filter(|folder| !read(&folder.join("Cargo.toml")).contains("publish = false"))
        .collect()
}

#[test]
fn packages_stand_by_themselves() {
    let published = published();
    assert_eq!(published.len(), 16, "{published:?}");
    for folder in published {
        let manifest = read(&folder.join("Cargo.toml"));
        let name = manifest.split("name = \"").nth(1).unwrap().split('"').next().unwrap();
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            assert_eq!(read(&folder.join(licence)), read(&root().join(licence)), "{name}");
        }
        let page = read(&folder.join("README.md"));
        assert_eq!(page.lines().next(), Some(format!("# {name}").as_str()));
        for line in [
            format!("documentation = \"https://docs.rs/{name}\""),
            "homepage.workspace = true".into(),
            "repository.workspace = true".into(),
            "readme = \"README.md\"".into(),
            "[package.metadata.docs.rs]".into(),
        ] {
            assert!(manifest.lines().any(|own| own == line), "{name}: no line `{line}`");
        }
    }
}

/// What a published package depends on by a path is found by its version once it is published.
#[test]
fn paths_have_versions() {
    let manifest = read(&root().join("Cargo.toml"));
    let version = manifest
        .split("version = \"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap();
    let paths = manifest
        .lines()
        .filter(|line| line.contains("path = \"") && !line.contains("host-tests"));
    let paths: Vec<&str> = paths.collect();
    assert_eq!(paths.len(), 14, "{paths:?}");
    for line in paths {
        assert!(line.contains(&format!("version = \"{version}\"")), "{line}");
    }
}
