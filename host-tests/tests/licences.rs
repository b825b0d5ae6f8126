//! Licences and sources of everything that is linked, as Cargo states them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package, PackageId};
use spdx::{Expression, ParseMode};

/// Licences that a package which slicecast links may be under: they ask for their text beside the program and no more.
const LINKED: [&str; 7] = [
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-3-Clause",
    "MIT",
    "Unicode-3.0",
    "Zlib",
    "bzip2-1.0.6",
];

/// Packages that only tests use, whose licence is another, and that.
const OF_TESTS: [(&str, &str); 1] = [("cbindgen", "MPL-2.0")];

/// The packages that a build for this machine takes.
fn metadata() -> Metadata {
    let host = Command::new("rustc").args(["--print", "host-tuple"]).output().unwrap();
    let host = String::from_utf8(host.stdout).unwrap();
    let options = ["--locked", "--all-features", "--filter-platform", host.trim()];
    MetadataCommand::new()
        .manifest_path(Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.toml"))
        .other_options(options.map(String::from).to_vec())
        .exec()
        .unwrap()
}

/// What the packages that can be published depend on when they are built, near and far.
fn linked(metadata: &Metadata) -> BTreeSet<PackageId> {
    let nodes = &metadata.resolve.as_ref().unwrap().nodes;
    let nodes: BTreeMap<&PackageId, _> = nodes.iter().map(|node| (&node.id, node)).collect();
    let published = metadata.workspace_packages().into_iter();
    // `publish = false` is an empty list of registries.
    let published = published.filter(|package| package.publish.is_none());
    let mut open: Vec<PackageId> = published.map(|package| package.id.clone()).collect();
    assert_eq!(open.len(), 16);
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        let built = nodes[&id].deps.iter().filter(|dependency| {
            let mut kinds = dependency.dep_kinds.iter();
            kinds.any(|kind| kind.kind != DependencyKind::Development)
        });
        open.extend(
            built
                .map(|dependency| dependency.pkg.clone())
                .filter(|id| !found.contains(id)),
        );
        found.insert(id);
    }
    found
}

/// Whether a package can be used under these licences alone; which of them it names goes to `used`.
fn fits(package: &Package, allowed: &[&str], used: &mut BTreeSet<String>) -> bool {
    let Some(licence) = &package.license else {
        return false;
    };
    // Older packages write MIT/Apache-2.0.
    let mode = ParseMode {
        allow_slash_as_or_operator: true,
        ..ParseMode::STRICT
    };
    let expression = Expression::parse_mode(licence, mode).unwrap_or_else(|error| panic!("{}: {error}", package.name));
    expression.evaluate(|requirement| {
        let name = requirement.to_string();
        used.insert(name.clone());
        allowed.contains(&name.as_str())
    })
}

#[test]
fn what_is_linked_is_under_permissive_licences() {
    let metadata = metadata();
    let linked = linked(&metadata);
    let packages = metadata.packages.iter().filter(|package| linked.contains(&package.id));
    let mut used = BTreeSet::new();
    let refused: Vec<_> = packages
        .filter(|package| !fits(package, &LINKED, &mut used))
        .map(|package| (&package.name, &package.license))
        .collect();
    assert!(refused.is_empty(), "{refused:?}");
    let unused: Vec<_> = LINKED.iter().filter(|licence| !used.contains(**licence)).collect();
    assert!(
        unused.is_empty(),
        "no package is under {unused:?}: strike it from the list"
    );
}

#[test]
fn what_tests_use_is_listed_where_it_is_not() {
    let mut others = Vec::new();
    for package in &metadata().packages {
        if !fits(package, &LINKED, &mut BTreeSet::new()) {
            others.push((package.name.to_string(), package.license.clone().unwrap_or_default()));
        }
    }
    assert_eq!(others, OF_TESTS.map(|(name, licence)| (name.into(), licence.into())));
}

/// What is published may not depend on a branch of a repository.
#[test]
fn packages_come_from_the_registry() {
    for package in &metadata().packages {
        match &package.source {
            None => assert!(package.name.starts_with("slicecast"), "{}", package.name),
            Some(source) => assert!(source.is_crates_io(), "{}: {source}", package.name),
        }
    }
}
