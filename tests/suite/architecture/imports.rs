//! Imports between the files of the source tree. Tests do not count, and a path counts for the file
//! that defines the item.

use super::{code, files_of, folder_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module with its `::` path and without its tests.
#[derive(Default)]
struct Module {
    /// Names that `use` brings into it, with their paths.
    scope: BTreeMap<String, String>,
    /// The paths that its code takes.
    paths: Vec<String>,
    /// Types of other files that it has an `impl` block of: it is a part of them.
    extended: BTreeSet<String>,
}

/// Names that each module takes from each other module.
pub(super) type Imports = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

fn joined(outer: &str, inner: &str) -> String {
    match (outer, inner) {
        ("", path) | (path, "") => path.to_owned(),
        _ => format!("{outer}::{inner}"),
    }
}

fn parent(module: &str) -> &str {
    module.rsplit_once("::").map_or("", |(parent, _)| parent)
}

/// `bottom/cloud/mod.rs` of the crate in `bottom` is `cloud`.
fn module_of(path: &Path, folder: &Path) -> String {
    let relative = path.strip_prefix(folder).expect("a path below the crate");
    let name = relative.with_extension("").to_string_lossy().replace('/', "::");
    let name = name.strip_suffix("::mod").unwrap_or(&name);
    name.strip_prefix("lib").filter(|rest| rest.is_empty()).unwrap_or(name).to_owned()
}

/// The code before the tests at the end of a file, and the test modules that it declares.
fn without_tests(code: &str) -> (String, Vec<String>) {
    let (mut kept, mut modules) = (String::new(), Vec::new());
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        if line != "#[cfg(test)]" {
            kept += line;
            kept.push('\n');
            continue;
        }
        let item = lines.next().unwrap_or_default();
        match item.strip_suffix(';').and_then(|item| item.split_once("mod ")) {
            Some((_, name)) => modules.push(name.to_owned()),
            None if item == "mod tests {" => break,
            None => {}
        }
    }
    (kept, modules)
}

/// The paths of a `use` tree with the names that they have in the file.
fn use_paths(before: &str, tree: &str, found: &mut Vec<(String, String)>) {
    let tree = tree.trim();
    if let Some((path, list)) = tree.split_once('{') {
        let path = joined(before, path.trim_end_matches("::"));
        let list = list.strip_suffix('}').unwrap_or(list);
        let (mut depth, mut start) = (0, 0);
        for (at, sign) in list.char_indices().chain([(list.len(), ',')]) {
            match sign {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    use_paths(&path, &list[start..at], found);
                    start = at + 1;
                }
                _ => {}
            }
        }
    } else if !tree.is_empty() {
        let (path, name) = tree.split_once(" as ").unwrap_or((tree, ""));
        let path = match joined(before, path) {
            path if path.ends_with("::self") => parent(&path).to_owned(),
            path => path,
        };
        let last = path.rsplit("::").next().unwrap_or(&path);
        let name = if name.is_empty() { last } else { name };
        found.push((path.clone(), name.to_owned()));
    }
}

impl Module {
    fn read(code: &str) -> Self {
        let mut module = Self::default();
        let (mut handed_on, mut rest) = (Vec::new(), String::new());
        for statement in code.split_inclusive(';') {
            let start = statement.rfind("use ").filter(|start| {
                let line = statement[..*start].lines().next_back().unwrap_or_default();
                line.trim().is_empty() || line.trim_start().starts_with("pub")
            });
            let (before, tree) = statement.split_at(start.unwrap_or(statement.len()));
            rest += before;
            let Some(tree) = tree.strip_prefix("use ") else {
                continue;
            };
            let mut found = Vec::new();
            use_paths("", tree.trim_end_matches(';'), &mut found);
            let is_handed_on = before.lines().next_back().is_some_and(|line| line.contains("pub"));
            for (path, name) in found {
                if is_handed_on {
                    handed_on.push((path.clone(), name.clone()))
                } else {
                    module.paths.push(path.clone())
                }
                module.scope.insert(name, path);
            }
        }
        let in_path = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
        let words: BTreeSet<&str> =
            (rest.split(|letter| !in_path(letter))).map(|word| word.trim_matches(':')).collect();
        let names: BTreeSet<&str> = words.iter().flat_map(|word| word.split("::")).collect();
        let used = handed_on.into_iter().filter(|(_, name)| names.contains(name.as_str()));
        module.paths.extend(used.map(|(path, _)| path));
        let paths = words.iter().filter(|word| word.contains("::"));
        module.paths.extend(paths.map(|path| (*path).to_owned()));
        let blocks = rest.split("\nimpl ").skip(1);
        let types = blocks.filter_map(|block| block.split_once(" {"));
        module.extended = types.map(|(name, _)| name.to_owned()).collect();
        module
    }
}

/// The module that defines the item at the end of a path, and the item.
/// `starts_inside`: the path starts in the module.
fn resolve(
    modules: &BTreeMap<String, Module>,
    (module, path): (&str, &str),
    starts_inside: bool,
    steps: usize,
) -> Option<(String, String)> {
    let (first, rest) = path.split_once("::").unwrap_or((path, ""));
    let below = joined(module, first);
    let here = match first {
        "super" => parent(module).to_owned(),
        "crate" if !starts_inside => String::new(),
        "self" if !starts_inside => module.to_owned(),
        _ if modules.contains_key(&below) => below,
        _ => {
            let known = modules.get(module)?.scope.get(first).filter(|_| steps < 20);
            return match known {
                Some(known) => resolve(modules, (module, &joined(known, rest)), false, steps + 1),
                None => starts_inside.then(|| (module.to_owned(), first.to_owned())),
            };
        }
    };
    let goes_on = !rest.is_empty();
    goes_on.then(|| resolve(modules, (&here, rest), true, steps + 1))?
}

/// Reads all files of a crate. What a file takes from the modules that contain it is no import.
pub(super) fn imports(name: &str) -> Imports {
    let mut files = BTreeMap::new();
    let mut tests = BTreeSet::new();
    for path in files_of(name) {
        let module = module_of(&path, &folder_of(name));
        let (code, test_modules) = without_tests(&code(&path));
        tests.extend(test_modules.iter().map(|name| joined(&module, name)));
        files.insert(module, code);
    }
    let is_test = |module: &str| {
        let below_test = |test: &String| module.strip_prefix(test.as_str());
        tests.iter().filter_map(below_test).any(|rest| rest.is_empty() || rest.starts_with("::"))
    };
    files.retain(|module, _| !is_test(module));
    let read = |(module, code): (&String, &String)| (module.clone(), Module::read(code));
    let modules: BTreeMap<String, Module> = files.iter().map(read).collect();
    let mut imports = Imports::new();
    for (module, Module { paths, extended, .. }) in &modules {
        let own = imports.entry(module.clone()).or_default();
        let items = paths.iter().filter_map(|path| resolve(&modules, (module, path), false, 0));
        for (other, name) in items {
            let contains =
                other.is_empty() || format!("{module}::").starts_with(&format!("{other}::"));
            if !contains && !extended.contains(&name) {
                own.entry(other).or_default().insert(name);
            }
        }
    }
    imports
}

/// Returns all modules that a module imports, directly or through others.
fn reached<'a>(imports: &'a Imports, start: &'a str) -> BTreeSet<&'a str> {
    let (mut seen, mut ahead) = (BTreeSet::new(), vec![start]);
    while let Some(module) = ahead.pop() {
        let others = imports.get(module).into_iter().flat_map(BTreeMap::keys);
        ahead.extend(others.map(String::as_str).filter(|other| seen.insert(*other)));
    }
    seen
}

/// Returns the names that modules take from each other where they import each other, directly or
/// through others: a sentence for each pair.
pub(super) fn circles(imports: &Imports) -> Vec<String> {
    let mut ties = Vec::new();
    for (module, imported) in imports {
        let others =
            imported.iter().filter(|(other, _)| reached(imports, other).contains(module.as_str()));
        ties.extend(others.map(|(other, names)| format!("{module} takes {names:?} from {other}")));
    }
    ties
}
