//! What is published: licences, and the names at the root, which are few on purpose.

use std::collections::BTreeSet;
use std::path::Path;

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

/// Names that `pub use` and `pub mod` give the root, hidden ones apart.
fn root_names() -> BTreeSet<String> {
    let source = include_str!("../src/lib.rs").replace("#[doc(hidden)]\npub mod internals;", "");
    let mut names = BTreeSet::new();
    for item in source.split(';').filter_map(|item| item.split_once("pub use ")) {
        let path = item.1.trim();
        let (from, list) = path.split_once('{').unwrap_or(("", path));
        assert!(!path.contains('*') && !from.contains('{'), "{path}");
        for name in list.trim_end_matches('}').split(',').map(str::trim).filter(|name| !name.is_empty()) {
            names.insert(name.rsplit("::").next().unwrap_or(name).to_string());
        }
    }
    assert!(
        source.matches("pub mod ").eq(["pub mod "]) && !source.contains("pub fn "),
        "the root re-exports, and has one room of its own"
    );
    assert!(source.contains("\npub mod network;\n"));
    names.insert("network".to_string());
    names
}

/// Whoever adds a name adds it to the list, and so sees how many there are.
#[test]
fn the_root_has_the_names_of_the_list() {
    let listed: BTreeSet<String> = include_str!("../public-names.txt").lines().map(String::from).collect();
    assert_eq!(root_names(), listed);
    assert!(listed.len() <= 50, "{} names", listed.len());
}
