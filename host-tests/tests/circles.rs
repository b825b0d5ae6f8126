//! No circle of files: modules of one folder that import each other in a ring cannot be read, or changed, one at a time. A module
//! counts with the files of its own folder, which may name it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// Modules by their path from the crate's root, with the paths of the modules that they name.
type Imports = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

fn is_test(name: &str) -> bool {
    name == "tests" || name.starts_with("tests_") || name.ends_with("_tests")
}

/// The files of a folder and of those in it, but for tests, with their paths as modules.
fn files(folder: &Path, at: &[String], found: &mut Vec<(Vec<String>, PathBuf)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if is_test(&name) {
            continue;
        }
        let mut module = at.to_vec();
        if path.is_dir() {
            module.push(name);
            files(&path, &module, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            if !["lib", "main", "mod"].contains(&name.as_str()) {
                module.push(name);
            }
            found.push((module, path));
        }
    }
}

/// What a file names, from the crate's root.
struct Named<'m> {
    module: &'m [String],
    paths: Vec<Vec<String>>,
}

impl Named<'_> {
    /// A path as it stands in the file.
    fn add(&mut self, path: &[String]) {
        let mut from = match path.first().map(String::as_str) {
            Some("crate") => Vec::new(),
            Some("self") => self.module.to_vec(),
            Some("super") => self.module[..self.module.len().saturating_sub(1)].to_vec(),
            _ => return,
        };
        for name in &path[1..] {
            if name == "super" {
                from.pop();
            } else {
                from.push(name.clone());
            }
        }
        self.paths.push(from);
    }

    fn add_tree(&mut self, before: &[String], tree: &syn::UseTree) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.add_tree(&with(&path.ident), &path.tree),
            syn::UseTree::Name(name) => self.add(&with(&name.ident)),
            syn::UseTree::Rename(rename) => self.add(&with(&rename.ident)),
            syn::UseTree::Glob(_) => self.add(before),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_tree(before, tree)),
        }
    }
}

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    let cfg = attributes.iter().filter(|attribute| attribute.path().is_ident("cfg"));
    cfg.into_iter()
        .any(|attribute| attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test"))
}

impl<'ast> Visit<'ast> for Named<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_for_tests(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_for_tests(&item.attrs) {
            self.add_tree(&[], &item.tree);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.add(&names);
        visit::visit_path(self, path);
    }
}

/// The imports of a crate between its files.
fn imports(sources: &Path) -> Imports {
    let mut found = Vec::new();
    files(sources, &[], &mut found);
    let modules: BTreeSet<Vec<String>> = found.iter().map(|(module, _)| module.clone()).collect();
    let named = |(module, path): &(Vec<String>, PathBuf)| {
        let file = syn::parse_file(&fs::read_to_string(path).unwrap()).unwrap();
        let mut named = Named {
            module,
            paths: Vec::new(),
        };
        named.visit_file(&file);
        // The longest module that begins a path; the root is none, it names all of them.
        let owner = |path: &Vec<String>| {
            (1..=path.len())
                .rev()
                .map(|n| path[..n].to_vec())
                .find(|p| modules.contains(p))
        };
        (module.clone(), named.paths.iter().filter_map(owner).collect())
    };
    found
        .iter()
        .filter(|(module, _)| !module.is_empty())
        .map(named)
        .collect()
}

/// A ring of modules of one folder, if there is one.
fn ring(imports: &Imports, folder: &[String]) -> Option<Vec<String>> {
    let depth = folder.len();
    let inside =
        |module: &[String]| (module.len() > depth && module.starts_with(folder)).then(|| module[depth].clone());
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (from, to) in imports {
        let Some(from) = inside(from) else { continue };
        let to = to.iter().filter_map(|to| inside(to)).filter(|to| *to != from);
        edges.entry(from.clone()).or_default().extend(to);
    }
    // What names nothing that is left is taken away; what stays leads into a ring.
    while let Some(last) = edges.iter().find(|(_, to)| to.is_empty()).map(|(from, _)| from.clone()) {
        edges.remove(&last);
        edges.values_mut().for_each(|to| {
            to.remove(&last);
        });
    }
    let mut way = vec![edges.keys().next()?.clone()];
    loop {
        let next = edges[way.last()?].first()?.clone();
        if let Some(start) = way.iter().position(|module| *module == next) {
            way.drain(..start);
            way.push(next);
            return Some(way);
        }
        way.push(next);
    }
}

/// A ring of each folder that has one.
fn rings(imports: &Imports) -> Vec<String> {
    let folders: BTreeSet<&[String]> = imports.keys().map(|module| &module[..module.len() - 1]).collect();
    let rings = folders.iter().filter_map(|folder| {
        let ring = ring(imports, folder)?;
        Some(format!("{}: {}", folder.join("::"), ring.join(" -> ")))
    });
    rings.collect()
}

#[test]
fn no_files_import_each_other_in_a_ring() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for name in [
        "core",
        "sim/volume",
        "sim/scene",
        "sim/model",
        "sim/pyramid",
        "sim/engine",
        "sim/compare",
    ] {
        let imports = imports(&root.join(name).join("src"));
        assert!(imports.values().any(|to| !to.is_empty()), "{name}");
        assert_eq!(rings(&imports), [""; 0], "{name}");
    }
}

#[test]
fn rings_are_found() {
    let of = |text: &str| -> Imports {
        let path = |text: &str| -> Vec<String> { text.split("::").map(str::to_owned).collect() };
        let line = |line: &str| {
            let (from, to) = line.split_once(" > ").unwrap();
            (
                path(from),
                to.split(' ').filter(|to| !to.is_empty()).map(path).collect(),
            )
        };
        text.split('\n').map(line).collect()
    };
    assert_eq!(rings(&of("a > b c\nb > c\nc > ")), [""; 0]);
    assert_eq!(rings(&of("a > b\nb > c\nc > b\nd > a")), [": b -> c -> b"]);
    // A module with its own files is one, which may name each other's names; those files may form no ring.
    assert_eq!(rings(&of("a > a::x\na::x > a\nb > a")), [""; 0]);
    assert_eq!(rings(&of("a > a::x\na::x > b\nb > a")), [": a -> b -> a"]);
    assert_eq!(rings(&of("a > a::x\na::x > a::y\na::y > a::x")), ["a: x -> y -> x"]);
}

#[test]
fn what_a_file_names_is_found() {
    let text = "use crate::one::{Two, three::*};\nuse super::four;\nuse std::fmt;\n#[cfg(test)]\nuse crate::never;\n\
                fn f() -> self::five::Five { crate::six::g() }\n#[cfg(test)]\nmod tests { use crate::not; }";
    let module = ["a", "b"].map(str::to_owned);
    let mut named = Named {
        module: &module,
        paths: Vec::new(),
    };
    named.visit_file(&syn::parse_file(text).unwrap());
    let paths: Vec<String> = named.paths.iter().map(|path| path.join("::")).collect();
    assert_eq!(
        paths,
        ["one::Two", "one::three", "a::four", "a::b::five::Five", "six::g"]
    );
}
