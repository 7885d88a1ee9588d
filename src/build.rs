//! Build script: the digest of each workspace crate's code, as it enters the cache keys.
//!
//! Counted: the token stream of every source file (comments, docs, formatting and tests are no part of it), the bytes of
//! every other file under `src/`, the crate's features and dependencies, the workspace crates it uses, and name, version
//! and checksum of every locked dependency. Not counted: `hvi-cache`, which knows bytes only, and modules called `show`
//! or kit's `view.rs`, which only present results that are already stored.
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, fs};
use syn::visit_mut::VisitMut;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    println!("cargo:rerun-if-changed={}", root.join("stages").display());
    println!("cargo:rerun-if-changed={}", root.join("Cargo.lock").display());
    println!("cargo:rerun-if-changed={}", root.join("Cargo.toml").display());
    println!("cargo:rerun-if-changed={}", root.join("src").display());
    let locked = locked_packages(&root.join("Cargo.lock"))?;
    let mut table = String::from(
        "/// (crate, digest of its code) in the order of their names.\npub const CODE: &[(&str, &str)] = &[\n",
    );
    let mut folders: Vec<_> = fs::read_dir(root.join("stages"))?.collect::<Result<_, _>>()?;
    folders.sort_by_key(fs::DirEntry::path);
    for folder in folders {
        if folder.path().join("Cargo.toml").exists() {
            let name = format!("hvi-{}", folder.file_name().to_string_lossy());
            table +=
                &format!("    ({:?}, {:?}),\n", name.replace('-', "_"), digest(&root, &name, &locked)?.to_string());
        }
    }
    table += "];\n";
    let version = std::process::Command::new(env::var("RUSTC")?).arg("--version").output()?;
    let (version, target) = (String::from_utf8_lossy(&version.stdout).trim().to_string(), env::var("TARGET")?);
    table += &format!(
        "/// Compiler that built this program, and its target.\npub const COMPILER: &str = {:?};\n",
        format!("{version}, {target}")
    );
    let mut program = blake3::Hasher::new();
    for file in files(&root.join("src"))? {
        program.update(&fs::read(file)?);
    }
    for file in files(&root.join("stages"))? {
        let path = file.strip_prefix(&root)?.to_string_lossy();
        if shows(&path, "") || path.ends_with("kit/src/view.rs") {
            program.update(&fs::read(file)?);
        }
    }
    table += &format!(
        "/// Digest of the orchestrator's own sources: what it writes for people may change with it.\npub const PROGRAM: &str = {:?};\n",
        program.finalize().to_string()
    );
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("code.rs"), table)?;
    Ok(())
}

/// Digest of everything that a result of crate `name` may depend on.
fn digest(root: &Path, name: &str, locked: &Locked) -> Result<blake3::Hash, Failure> {
    let mut hasher = blake3::Hasher::new();
    let mut add = |part: &[u8]| {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    };
    for package in closure(name, locked) {
        let Some(folder) = package.name.strip_prefix("hvi-").filter(|_| package.checksum.is_empty()) else {
            add(format!("{} {} {}", package.name, package.version, package.checksum).as_bytes());
            continue;
        };
        if folder == "cache" {
            continue;
        }
        let folder = root.join("stages").join(folder);
        add(package.name.as_bytes());
        add(manifest(root, &folder.join("Cargo.toml"))?.as_bytes());
        if folder.join("build.rs").exists() {
            add(tokens(&folder.join("build.rs"))?.as_bytes());
        }
        for file in counted_files(&folder.join("src"))? {
            let path = file.strip_prefix(&folder)?.to_string_lossy().into_owned();
            if shows(&path, &package.name) {
                continue;
            }
            add(path.as_bytes());
            if path.ends_with(".rs") {
                add(tokens(&file)?.as_bytes());
            } else {
                add(&fs::read(&file)?);
            }
        }
    }
    Ok(hasher.finalize())
}

/// Whether a source file only presents results that are already stored.
fn shows(path: &str, package: &str) -> bool {
    path.ends_with("/show.rs") || path.contains("/show/") || (package == "hvi-kit" && path == "src/view.rs")
}

/// The parts of a manifest that may change what is compiled, with what they take from the workspace's.
fn manifest(root: &Path, path: &Path) -> Result<String, Failure> {
    let workspace: toml::Table = fs::read_to_string(root.join("Cargo.toml"))?.parse()?;
    let workspace = workspace.get("workspace").ok_or("Cargo.toml has no [workspace]")?;
    let table: toml::Table = fs::read_to_string(path)?.parse()?;
    let part = |key: &str| table.get(key).map(ToString::to_string).unwrap_or_default();
    let own = ["dependencies", "features", "build-dependencies", "target"].map(part);
    let edition = workspace.get("package").and_then(|p| p.get("edition")).map(ToString::to_string);
    let names = ["dependencies", "build-dependencies"].into_iter().filter_map(|k| table.get(k)?.as_table());
    let shared = names.flat_map(|t| t.keys()).map(|name| {
        let entry = workspace.get("dependencies").and_then(|d| d.get(name));
        format!("{name} = {}", entry.map(ToString::to_string).unwrap_or_default())
    });
    Ok(own.into_iter().chain(edition).chain(shared).collect::<Vec<_>>().join("\n"))
}

struct Package {
    name: String,
    version: String,
    checksum: String,
    needs: Vec<String>,
}

/// Locked packages by name; a name may have several versions.
type Locked = BTreeMap<String, Vec<Package>>;

fn locked_packages(path: &Path) -> Result<Locked, Failure> {
    let lock: toml::Table = fs::read_to_string(path)?.parse()?;
    let text = |p: &toml::Value, key: &str| p.get(key).and_then(|v| v.as_str()).unwrap_or_default().to_string();
    let packages = lock.get("package").and_then(|p| p.as_array()).ok_or("Cargo.lock lists no packages")?;
    let mut all = Locked::new();
    for p in packages {
        let needs = p.get("dependencies").and_then(|d| d.as_array()).into_iter().flatten();
        let needs = needs.filter_map(|d| d.as_str()).map(str::to_string).collect();
        let package =
            Package { name: text(p, "name"), version: text(p, "version"), checksum: text(p, "checksum"), needs };
        all.entry(package.name.clone()).or_default().push(package);
    }
    Ok(all)
}

/// `name` and all it needs, in the order of names and versions. Development dependencies are locked too: proptest, the
/// only one of the stages, is left out by hand.
fn closure<'a>(name: &str, locked: &'a Locked) -> Vec<&'a Package> {
    let mut seen: BTreeMap<(&str, &str), &Package> = BTreeMap::new();
    let mut todo = vec![name.to_string()];
    while let Some(next) = todo.pop() {
        // "name", or "name version" where there are several.
        let mut words = next.split(' ');
        let (name, version) = (words.next().unwrap_or_default(), words.next());
        let fitting = locked.get(name).into_iter().flatten().filter(|p| version.is_none_or(|v| v == p.version));
        for package in fitting.filter(|p| p.name != "proptest") {
            // The store knows bytes only: what it is made of is no part of a result.
            if seen.insert((&package.name, &package.version), package).is_none() && name != "hvi-cache" {
                todo.extend(package.needs.iter().cloned());
            }
        }
    }
    seen.into_values().collect()
}

/// The files below `folder` but those of modules that are there for tests only.
fn counted_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let all = files(folder)?;
    let mut tests: Vec<PathBuf> = Vec::new();
    for path in all.iter().filter(|p| p.extension().is_some_and(|e| e == "rs")) {
        let stem = path.with_extension("");
        let is_root = matches!(stem.file_name().and_then(|n| n.to_str()), Some("mod" | "lib" | "main"));
        let home = if is_root { path.parent().unwrap_or(folder).to_path_buf() } else { stem };
        for item in syn::parse_file(&fs::read_to_string(path)?)?.items {
            if let syn::Item::Mod(module) = &item
                && module.content.is_none()
                && is_test(&item)
            {
                let name = home.join(module.ident.to_string());
                tests.extend([name.with_extension("rs"), name]);
            }
        }
    }
    Ok(all.into_iter().filter(|path| !tests.iter().any(|t| path.starts_with(t))).collect())
}

fn files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() { all.extend(files(&path)?) } else { all.push(path) }
    }
    all.sort();
    Ok(all)
}

/// The file's tokens as text, without docs and tests.
fn tokens(path: &Path) -> Result<String, Failure> {
    let text = fs::read_to_string(path)?;
    let mut file = syn::parse_file(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    Strip.visit_file_mut(&mut file);
    Ok(undocumented(file.into_token_stream()).to_string())
}

/// Drops items under `#[cfg(test)]`.
struct Strip;
impl VisitMut for Strip {
    fn visit_file_mut(&mut self, file: &mut syn::File) {
        file.items.retain(|item| !is_test(item));
        syn::visit_mut::visit_file_mut(self, file);
    }
    fn visit_item_mod_mut(&mut self, module: &mut syn::ItemMod) {
        if let Some((_, items)) = &mut module.content {
            items.retain(|item| !is_test(item));
        }
        syn::visit_mut::visit_item_mod_mut(self, module);
    }
}

fn is_test(item: &syn::Item) -> bool {
    use syn::Item::{Const, Enum, Fn, Impl, Macro, Mod, Static, Struct, Trait, Type, Use};
    let attributes = match item {
        Const(i) => &i.attrs,
        Enum(i) => &i.attrs,
        Fn(i) => &i.attrs,
        Impl(i) => &i.attrs,
        Macro(i) => &i.attrs,
        Mod(i) => &i.attrs,
        Static(i) => &i.attrs,
        Struct(i) => &i.attrs,
        Trait(i) => &i.attrs,
        Type(i) => &i.attrs,
        Use(i) => &i.attrs,
        _ => return false,
    };
    let plain = |a: &syn::Attribute| a.meta.to_token_stream().to_string().replace(' ', "");
    attributes.iter().any(|a| plain(a) == "cfg(test)")
}

/// Drops `#[doc = ...]` everywhere, macro bodies included: documentation comments are such attributes.
fn undocumented(stream: TokenStream) -> TokenStream {
    let mut kept: Vec<TokenTree> = Vec::new();
    for tree in stream {
        let TokenTree::Group(group) = tree else {
            kept.push(tree);
            continue;
        };
        let first = group.stream().into_iter().next();
        let doc = matches!(first, Some(TokenTree::Ident(ref i)) if i == "doc")
            && group.delimiter() == proc_macro2::Delimiter::Bracket;
        if doc && matches!(kept.last(), Some(TokenTree::Punct(p)) if matches!(p.as_char(), '#' | '!')) {
            while matches!(kept.last(), Some(TokenTree::Punct(p)) if matches!(p.as_char(), '#' | '!')) {
                kept.pop();
            }
        } else {
            kept.push(TokenTree::Group(proc_macro2::Group::new(group.delimiter(), undocumented(group.stream()))));
        }
    }
    kept.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(source: &str) -> String {
        let mut file = syn::parse_file(source).unwrap();
        Strip.visit_file_mut(&mut file);
        undocumented(file.into_token_stream()).to_string()
    }

    const CODE: &str = "pub const GAMMA: f64 = 1.97; pub fn f(x: [f64; 2], doc: usize) -> f64 { GAMMA * x[doc + 1] }";

    #[test]
    fn comments_docs_formatting_and_tests_do_not_count() {
        let same = "//! About.\n/// Gamma.\npub const GAMMA: f64 = 1.97; // a note\n\n#[doc = \"f\"]\n\
            pub fn f(x: [f64; 2], doc: usize) -> f64 {\n    /* why */ GAMMA * x[doc + 1]\n}\n\
            #[cfg(test)]\nstruct Helper;\n#[cfg(test)]\nmod tests { fn t() {} }\n";
        assert_eq!(text(same), text(CODE));
    }

    #[test]
    fn a_changed_constant_name_or_index_counts() {
        for (from, to) in [("1.97", "1.98"), ("GAMMA *", "GAMMA +"), ("doc + 1", "doc + 0"), ("f64; 2", "f64; 3")] {
            assert_ne!(text(&CODE.replace(from, to)), text(CODE), "{from} -> {to}");
        }
    }

    /// On a copy of the tree's shape: what is edited, and whether the digest of `hvi-a`, which uses `hvi-b`, may stay.
    #[test]
    fn what_a_stage_uses_counts_and_what_it_does_not_use_does_not() {
        let root = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        write("Cargo.toml", "[workspace.dependencies]\nlibm = { version = \"1\" }\nother = \"1\"\n");
        let lock = "[[package]]\nname = \"hvi-a\"\nversion = \"0.1.0\"\ndependencies = [\"hvi-b\", \"libm 2.0.0\"]\n\
            [[package]]\nname = \"hvi-b\"\nversion = \"0.1.0\"\n\
            [[package]]\nname = \"libm\"\nversion = \"1.0.0\"\nchecksum = \"old\"\n\
            [[package]]\nname = \"libm\"\nversion = \"2.0.0\"\nchecksum = \"new\"\n";
        write("Cargo.lock", lock);
        for name in ["a", "b", "c"] {
            write(&format!("stages/{name}/Cargo.toml"), "[dependencies]\nlibm.workspace = true\n");
            write(&format!("stages/{name}/src/lib.rs"), "pub const X: f64 = 1.0;\n#[cfg(test)]\nmod trial;\n");
            write(&format!("stages/{name}/src/trial.rs"), "fn t() {}");
            write(&format!("stages/{name}/src/show.rs"), "pub const LABEL: &str = \"x\";");
            write(&format!("stages/{name}/src/table.csv"), "1,2\n");
        }
        let now = || digest(root.path(), "hvi-a", &locked_packages(&root.path().join("Cargo.lock")).unwrap()).unwrap();
        let first = now();
        for (name, text, counts) in [
            ("stages/b/src/lib.rs", "pub const X: f64 = 2.0;", true),
            ("stages/b/src/table.csv", "1,3\n", true),
            ("stages/b/src/extra.rs", "pub fn g() {}", true),
            ("stages/b/build.rs", "fn main() {}", true),
            ("stages/a/Cargo.toml", "[dependencies]\nlibm.workspace = true\n[features]\nfast = []\n", true),
            ("Cargo.toml", "[workspace.dependencies]\nlibm = { version = \"1\", features = [\"x\"] }\n", true),
            ("Cargo.lock", &lock.replace("new", "newer"), true),
            ("Cargo.lock", &lock.replace("\"old\"", "\"older\""), false),
            ("stages/b/src/trial.rs", "fn other() {}", false),
            ("stages/b/src/show.rs", "pub const LABEL: &str = \"y\";", false),
            ("stages/b/src/show/words.rs", "pub const WORD: &str = \"y\";", false),
            ("stages/b/src/lib.rs", "//! Docs.\npub const X: f64 = 1.0;\n#[cfg(test)]\nmod trial;\n", false),
            ("stages/c/src/lib.rs", "pub const X: f64 = 3.0;", false),
        ] {
            let path = root.path().join(name);
            let old = fs::read_to_string(&path).ok();
            write(name, text);
            assert_eq!(now() != first, counts, "{name}: {text}");
            match old {
                Some(old) => write(name, &old),
                None => fs::remove_file(path).unwrap(),
            }
            assert_eq!(now(), first, "{name} put back");
        }
    }
}
