//! Files that import each other in a circle: neither can be read without the other.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Top modules without circles between their files.
const WITHOUT_CYCLES: &[&str] = &[
    "spatial",
    "solver",
    "parameters",
    "dynamics",
    "trajectory",
    "preparation",
    "effects",
    "regression",
    "diagnosis",
    "simulate",
    "web",
];

/// One imported path, and whether it is handed on.
struct Import {
    public: bool,
    path: Vec<String>,
}

/// Code of every file by its path in `src/`; unit tests and comments left out.
struct Sources(BTreeMap<String, Vec<Import>>);

impl Sources {
    fn read(root: &Path) -> Self {
        let of = |file: std::path::PathBuf| {
            let text = std::fs::read_to_string(&file).unwrap();
            let name = file.strip_prefix(root).unwrap().to_str().unwrap().to_string();
            (name, imports(text.split("#[cfg(test)]").next().unwrap_or_default()))
        };
        Self(super::sources(root).into_iter().map(of).collect())
    }

    fn file_of(&self, module: &[String]) -> Option<&str> {
        let path = module.join("/");
        let names = [format!("{path}.rs"), format!("{path}/mod.rs")];
        names
            .iter()
            .find_map(|n| self.0.get_key_value(n))
            .map(|(name, _)| name.as_str())
    }

    /// The file that defines what `path` names in `file`: what a folder only hands on is looked for where it comes from.
    fn resolved(&self, path: &[String], file: &str) -> Option<String> {
        let mut module = module_of(file);
        let mut rest = path;
        match rest.first()?.as_str() {
            "crate" => (module, rest) = (Vec::new(), &rest[1..]),
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|p| p == "super") {
                    module.pop();
                    rest = &rest[1..];
                }
            }
            _ => {}
        }
        while let Some(next) = rest.first() {
            let deeper: Vec<String> = module.iter().chain([next]).cloned().collect();
            if self.file_of(&deeper).is_none() {
                break;
            }
            (module, rest) = (deeper, &rest[1..]);
        }
        let here = self.file_of(&module)?.to_string();
        let handed_on = |i: &&Import| i.public && rest.first().is_some_and(|item| i.path.last() == Some(item)) && i.path != path;
        let elsewhere = self.0[&here]
            .iter()
            .find(handed_on)
            .and_then(|i| self.resolved(&i.path, &here));
        Some(elsewhere.unwrap_or(here))
    }

    /// Files of a top module that every file of it imports from.
    fn graph(&self, top: &str) -> BTreeMap<&str, BTreeSet<String>> {
        let within = |name: &str| name.starts_with(&format!("{top}/"));
        let used = |(name, imports): (&str, &Vec<Import>)| {
            let handed_on = |i: &&Import| !(i.public && name.ends_with("mod.rs"));
            let files = imports.iter().filter(handed_on).filter_map(|i| self.resolved(&i.path, name));
            files.filter(|f| within(f) && f != name).collect()
        };
        let own = self.0.iter().filter(|(name, _)| within(name));
        own.map(|(name, imports)| (name.as_str(), used((name, imports)))).collect()
    }
}

fn module_of(file: &str) -> Vec<String> {
    let mut parts: Vec<String> = file.trim_end_matches(".rs").split('/').map(String::from).collect();
    if parts.last().is_some_and(|p| p == "mod") {
        parts.pop();
    }
    parts
}

/// Every path that `use` names, braces multiplied out.
fn imports(code: &str) -> Vec<Import> {
    let lines = code.lines().filter(|l| !l.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join(" ");
    let statement = |part: &str| {
        let (before, body) = part.rsplit_once("use ")?;
        let before = before.trim_end();
        let starts = before.is_empty() || before.ends_with([';', '}', ']', ')']) || before.ends_with("pub");
        let public = before.ends_with("pub") || before.ends_with("pub(crate)") || before.ends_with("pub(super)");
        starts.then(|| {
            paths(body)
                .into_iter()
                .map(move |path| Import { public, path })
                .collect::<Vec<_>>()
        })
    };
    code.split(';').filter_map(statement).flatten().collect()
}

fn paths(body: &str) -> Vec<Vec<String>> {
    let plain = |p: &str| -> Vec<String> {
        let name = p.split(" as ").next().unwrap_or_default();
        name.split("::")
            .map(|s| s.trim().to_string())
            .filter(|s| !s.is_empty())
            .collect()
    };
    let Some((before, rest)) = body.split_once('{') else {
        return vec![plain(body)];
    };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inner.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().expect("one part at least").push(c),
        }
    }
    let whole = |p: &String| paths(p).into_iter().map(|p| [plain(before), p].concat());
    parts.iter().filter(|p| !p.trim().is_empty()).flat_map(whole).collect()
}

/// A file that can be reached from itself, with the way there.
fn circle<'a>(graph: &'a BTreeMap<&str, BTreeSet<String>>, from: &'a str) -> Option<Vec<&'a str>> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![vec![from]]);
    while let Some(way) = open.pop() {
        for next in &graph[way.last().expect("begins somewhere")] {
            if next == from {
                return Some(way);
            }
            if seen.insert(next) {
                open.push(way.iter().copied().chain([next.as_str()]).collect());
            }
        }
    }
    None
}

#[test]
fn files_do_not_import_each_other_in_circles() {
    let sources = Sources::read(&Path::new(super::ROOT).join("src"));
    let mut edges = 0;
    for top in WITHOUT_CYCLES {
        let graph = sources.graph(top);
        edges += graph.values().map(BTreeSet::len).sum::<usize>();
        for file in graph.keys() {
            let found = circle(&graph, file);
            assert!(found.is_none(), "a circle: {}", found.unwrap_or_default().join(" → "));
        }
    }
    // The reader of imports sees them at all.
    assert!(edges > 200, "{edges} imports");
}

#[test]
fn circles_are_seen() {
    let file = |name: &str, code: &str| (name.to_string(), imports(code));
    let sources = Sources(BTreeMap::from([
        file("a/mod.rs", "mod b; mod c; pub use c::Thing;"),
        file("a/b.rs", "use crate::a::Thing; pub struct Other;"),
        file("a/c.rs", "use super::{b::Other, d::{More, Most as Least}}; pub struct Thing;"),
        file("a/d.rs", ""),
    ]));
    let graph = sources.graph("a");
    assert_eq!(circle(&graph, "a/b.rs"), Some(vec!["a/b.rs", "a/c.rs"]));
    assert_eq!(circle(&graph, "a/d.rs"), None);
    assert_eq!(graph["a/c.rs"].len(), 2);
}
