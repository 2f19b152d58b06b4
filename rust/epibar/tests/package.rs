//! What is published: licences, and the public names, which are few on purpose and may grow.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const CRATE: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn licences_are_those_of_the_repository() {
    let root = Path::new(CRATE).join("../..");
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        let own = std::fs::read_to_string(Path::new(CRATE).join(name)).unwrap();
        assert!(own.len() > 500, "{name}");
        // A published crate is alone.
        if let Ok(of_repository) = std::fs::read_to_string(root.join(name)) {
            assert_eq!(own, of_repository, "{name}");
        }
    }
}

/// Names that `pub use` gives a module.
fn re_exported(source: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for item in source.split(';').filter_map(|item| item.split_once("pub use ")) {
        let path = item.1.trim();
        let (from, list) = path.split_once('{').unwrap_or(("", path));
        assert!(!path.contains('*') && !from.contains('{'), "{path}");
        for name in list.trim_end_matches('}').split(',').map(str::trim).filter(|name| !name.is_empty()) {
            names.insert(name.rsplit("::").next().unwrap_or(name).to_string());
        }
    }
    names
}

/// The public names, those of the network's room with it before them; what is hidden apart.
fn public_names() -> BTreeSet<String> {
    let root = include_str!("../src/lib.rs")
        .replace("#[cfg(feature = \"internals\")]\n#[doc(hidden)]\npub mod internals;", "");
    let network = include_str!("../src/network/mod.rs");
    assert!(
        root.matches("pub mod ").eq(["pub mod "]) && !root.contains("pub fn "),
        "the root re-exports, and has one room of its own"
    );
    assert!(root.contains("\npub mod network;\n"));
    assert!(!network.contains("pub mod ") && !network.contains("pub fn "), "the room re-exports");
    let mut names = re_exported(&root);
    names.insert("network".to_string());
    names.extend(re_exported(network).iter().map(|name| format!("network::{name}")));
    names
}

/// Whoever adds a name adds it to the list, and so sees how many there are.
#[test]
fn the_public_names_are_those_of_the_list() {
    let listed: BTreeSet<String> = include_str!("../public-names.txt").lines().map(String::from).collect();
    assert_eq!(public_names(), listed);
    let of_network = listed.iter().filter(|name| name.starts_with("network::")).count();
    assert!(listed.len() - of_network <= 50 && of_network <= 33, "{} names, {of_network}", listed.len());
}

/// Public types that a caller writes out field by field: complete as they are.
const WRITTEN_OUT: [&str; 2] = ["Segment", "network::PosedCamera"];

/// The files under a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let inside = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    inside.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Whether the type of a name can get another field or variant without breaking who uses it; `None` where a file has no such type.
fn may_grow(source: &str, name: &str) -> Option<bool> {
    let declared = ["struct", "enum"].map(|kind| format!("pub {kind} {name}"));
    let mut found = declared.iter().flat_map(|d| source.match_indices(d)).map(|(at, d)| (at, at + d.len()));
    let (at, end) = found.find(|(_, end)| !source[*end..].starts_with(char::is_alphanumeric))?;
    let attributes = &source[source[..at].rfind("\n\n").unwrap_or(0)..at];
    let body = source[end..].split("\n}").next().unwrap_or_default();
    let fields = body.lines().skip(1).map(str::trim_start);
    let hidden = fields.clone().any(|l| l.contains(": ") && !l.starts_with("pub ") && !l.starts_with("//"));
    let bare = body.starts_with(';') || body.starts_with("(pub(crate)");
    Some(attributes.contains("#[non_exhaustive]") || hidden || bare)
}

#[test]
fn public_types_may_grow() {
    let sources: Vec<(PathBuf, String)> = files(&Path::new(CRATE).join("src"))
        .into_iter()
        .map(|path| (path.clone(), std::fs::read_to_string(path).unwrap()))
        .collect();
    let grows = |full: &str| {
        let (room, name) = full.split_once("::").unwrap_or(("", full));
        let own = |path: &Path| path.starts_with(Path::new(CRATE).join("src/network")) == (room == "network");
        let here = sources.iter().filter(|(path, _)| own(path));
        here.filter_map(|(_, source)| may_grow(source, name)).collect::<Vec<_>>()
    };
    for name in public_names() {
        let complete = WRITTEN_OUT.contains(&name.as_str());
        assert!(grows(&name).iter().all(|grows| *grows != complete), "{name}");
    }
    assert_eq!(grows("Calibration"), [true]);
    assert_eq!(grows("network::Knowledge"), [true]);
    assert_eq!(may_grow("pub struct Ab {\n    pub a: u8,\n}\n", "A"), None);
    assert_eq!(may_grow("pub struct Ab {\n    pub a: u8,\n}\n", "Ab"), Some(false));
}
