//! The public items of the crates that others may build on, compared with committed lists. After an intended change:
//! `SURFACE=write cargo test --test public_surface`.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use quote::ToTokens;
use syn::{Item, UseTree, Visibility};

/// Crates with a stable public surface: folder of `lib.rs`, and name of the list.
const CRATES: [(&str, &str); 4] = [
    ("src", "admire"),
    ("src/syntax", "admire-syntax"),
    ("src/results", "admire-results"),
    ("src/guide", "admire-guide"),
];

/// One crate being listed.
struct Listing {
    /// Folder of `lib.rs`.
    folder: PathBuf,
    /// Inherent implementations of all files.
    impls: Vec<syn::ItemImpl>,
    /// Lines of the list.
    lines: BTreeSet<String>,
}

/// A module: its items, and the folder of its submodules.
struct Module {
    items: Vec<Item>,
    folder: PathBuf,
}

impl Listing {
    fn of(folder: &Path) -> BTreeSet<String> {
        let mut new = Self {
            folder: folder.to_path_buf(),
            impls: Vec::new(),
            lines: BTreeSet::new(),
        };
        let root = new.root();
        new.collect_impls(&root);
        new.module(&root, "");
        new.lines
    }

    fn root(&self) -> Module {
        Module {
            items: parse(&self.folder.join("lib.rs")),
            folder: self.folder.clone(),
        }
    }

    fn submodule(module: &Module, of: &syn::ItemMod) -> Option<Module> {
        let name = of.ident.to_string();
        if let Some((_, items)) = &of.content {
            return Some(Module {
                items: items.clone(),
                folder: module.folder.join(name),
            });
        }
        let folder = module.folder.join(&name);
        let file = [
            module.folder.join(format!("{name}.rs")),
            folder.join("mod.rs"),
        ]
        .into_iter()
        .find(|file| file.is_file())?;
        Some(Module {
            items: parse(&file),
            folder,
        })
    }

    fn collect_impls(&mut self, module: &Module) {
        for item in &module.items {
            match item {
                Item::Impl(own) if own.trait_.is_none() => self.impls.push(own.clone()),
                Item::Mod(of) if !is_test(&of.attrs) => {
                    if let Some(inner) = Self::submodule(module, of) {
                        self.collect_impls(&inner);
                    }
                }
                _ => {}
            }
        }
    }

    /// Lists the public items of a module under a path such as `diff::`.
    fn module(&mut self, module: &Module, path: &str) {
        for item in &module.items {
            match item {
                Item::Mod(of) if is_public(&of.vis) && !is_test(&of.attrs) => {
                    if let Some(inner) = Self::submodule(module, of) {
                        let name = format!("{path}{}", of.ident);
                        self.lines.insert(format!("mod {name}"));
                        self.module(&inner, &format!("{name}::"));
                    }
                }
                Item::Use(own) if is_public(&own.vis) => {
                    for (source, name) in flat(&own.tree, Vec::new()) {
                        self.re_export(module, &source, &name, path);
                    }
                }
                _ => self.item(item, None, path),
            }
        }
    }

    /// Lists a re-exported item: at its definition if that is in this crate, else by name.
    fn re_export(&mut self, module: &Module, source: &[String], name: &str, path: &str) {
        let mut at = Module {
            items: module.items.clone(),
            folder: module.folder.clone(),
        };
        let (last, above) = source.split_last().expect("a name");
        let mut pieces = above.iter();
        let first = pieces.clone().next().map(String::as_str);
        if first == Some("crate") {
            at = self.root();
            pieces.next();
        } else if first == Some("self") {
            pieces.next();
        }
        for piece in pieces {
            let inner = at.items.iter().find_map(|item| match item {
                Item::Mod(of) if of.ident == piece => Self::submodule(&at, of),
                _ => None,
            });
            let Some(inner) = inner else {
                self.lines
                    .insert(format!("use {path}{name} = {}", source.join("::")));
                return;
            };
            at = inner;
        }
        let named = |item: &&Item| name_of(item).is_some_and(|own| own == *last);
        if let Some(item) = at.items.iter().find(named).cloned() {
            self.item(&item, Some(name), path);
            return;
        }
        let further = at.items.iter().filter_map(|item| match item {
            Item::Use(own) => flat(&own.tree, Vec::new())
                .into_iter()
                .find(|(_, own)| own == last),
            _ => None,
        });
        match further.into_iter().next() {
            Some((source, _)) => self.re_export(&at, &source, name, path),
            None => {
                self.lines
                    .insert(format!("use {path}{name} = {}", source.join("::")));
            }
        }
    }

    fn item(&mut self, item: &Item, name: Option<&str>, path: &str) {
        let Some(own) = name_of(item).filter(|_| is_public(visibility(item))) else {
            return;
        };
        let name = format!("{path}{}", name.unwrap_or(&own));
        match item {
            Item::Struct(of) => {
                self.lines
                    .insert(format!("struct {name}{}", text(&of.generics)));
                for (k, field) in of.fields.iter().enumerate() {
                    if is_public(&field.vis) {
                        let field_name = field
                            .ident
                            .as_ref()
                            .map_or_else(|| k.to_string(), ToString::to_string);
                        let line = format!("field {name}.{field_name}: {}", text(&field.ty));
                        self.lines.insert(line);
                    }
                }
                self.methods(&own, &name);
            }
            Item::Enum(of) => {
                self.lines
                    .insert(format!("enum {name}{}", text(&of.generics)));
                for variant in &of.variants {
                    let fields = variant_fields(&variant.fields);
                    self.lines
                        .insert(format!("variant {name}::{}{fields}", variant.ident));
                }
                self.methods(&own, &name);
            }
            Item::Trait(of) => {
                self.lines
                    .insert(format!("trait {name}{}", text(&of.generics)));
                for member in &of.items {
                    if let syn::TraitItem::Fn(function) = member {
                        self.lines
                            .insert(format!("fn {name}::{}", signature(&function.sig)));
                    }
                }
            }
            Item::Fn(of) => {
                let prefix = name.strip_suffix(own.as_str()).unwrap_or(path);
                self.lines
                    .insert(format!("fn {prefix}{}", signature(&of.sig)));
            }
            Item::Const(of) => {
                self.lines.insert(format!("const {name}: {}", text(&of.ty)));
            }
            Item::Static(of) => {
                self.lines
                    .insert(format!("static {name}: {}", text(&of.ty)));
            }
            Item::Type(of) => {
                self.lines.insert(format!("type {name} = {}", text(&of.ty)));
            }
            _ => {}
        }
    }

    fn methods(&mut self, own: &str, name: &str) {
        let mut lines = Vec::new();
        for block in &self.impls {
            let of = text(&block.self_ty);
            if of.split('<').next() != Some(own) {
                continue;
            }
            for member in &block.items {
                match member {
                    syn::ImplItem::Fn(of) if is_public(&of.vis) => {
                        lines.push(format!("fn {name}::{}", signature(&of.sig)));
                    }
                    syn::ImplItem::Const(of) if is_public(&of.vis) => {
                        lines.push(format!("const {name}::{}: {}", of.ident, text(&of.ty)));
                    }
                    _ => {}
                }
            }
        }
        self.lines.extend(lines);
    }
}

/// Formats the fields of a variant: names and types, without attributes.
fn variant_fields(fields: &syn::Fields) -> String {
    let field = |field: &syn::Field| match &field.ident {
        Some(name) => format!("{name}: {}", text(&field.ty)),
        None => text(&field.ty),
    };
    let list: Vec<String> = fields.iter().map(field).collect();
    match fields {
        syn::Fields::Named(_) => format!(" {{ {} }}", list.join(", ")),
        syn::Fields::Unnamed(_) => format!("({})", list.join(", ")),
        syn::Fields::Unit => String::new(),
    }
}

fn parse(file: &Path) -> Vec<Item> {
    let source =
        std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    syn::parse_file(&source)
        .expect("a source that compiles")
        .items
}

/// Returns the names that a `use` imports, each with its path.
fn flat(tree: &UseTree, mut path: Vec<String>) -> Vec<(Vec<String>, String)> {
    match tree {
        UseTree::Path(of) => {
            path.push(of.ident.to_string());
            flat(&of.tree, path)
        }
        UseTree::Name(of) => {
            let name = of.ident.to_string();
            path.push(name.clone());
            vec![(path, name)]
        }
        UseTree::Rename(of) => {
            path.push(of.ident.to_string());
            vec![(path, of.rename.to_string())]
        }
        UseTree::Glob(_) => {
            path.push("*".to_string());
            vec![(path, "*".to_string())]
        }
        UseTree::Group(of) => of
            .items
            .iter()
            .flat_map(|tree| flat(tree, path.clone()))
            .collect(),
    }
}

fn name_of(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Struct(of) => &of.ident,
        Item::Enum(of) => &of.ident,
        Item::Trait(of) => &of.ident,
        Item::Fn(of) => &of.sig.ident,
        Item::Const(of) => &of.ident,
        Item::Static(of) => &of.ident,
        Item::Type(of) => &of.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

fn visibility(item: &Item) -> &Visibility {
    match item {
        Item::Struct(of) => &of.vis,
        Item::Enum(of) => &of.vis,
        Item::Trait(of) => &of.vis,
        Item::Fn(of) => &of.vis,
        Item::Const(of) => &of.vis,
        Item::Static(of) => &of.vis,
        Item::Type(of) => &of.vis,
        _ => &Visibility::Inherited,
    }
}

const fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    let text = attributes
        .iter()
        .map(|one| one.to_token_stream().to_string());
    text.into_iter()
        .any(|text| text.contains("cfg (test)") || text.contains("\"python\""))
}

/// Returns tokens as text, with blanks nearly as by `cargo fmt`.
fn text(tokens: &impl ToTokens) -> String {
    let mut text = tokens.to_token_stream().to_string();
    for (from, to) in [
        (" :: ", "::"),
        (" < ", "<"),
        (" > ", "> "),
        ("< ", "<"),
        (" >", ">"),
        ("& ", "&"),
        (" ,", ","),
        ("( ", "("),
        (" )", ")"),
        (" (", "("),
        (" ;", ";"),
        (" :", ":"),
        ("[ ", "["),
        (" ]", "]"),
        ("> (", ">("),
    ] {
        text = text.replace(from, to);
    }
    text.trim().to_string()
}

fn signature(of: &syn::Signature) -> String {
    let whole = text(of);
    whole
        .split_once("fn ")
        .map_or(whole.clone(), |(_, rest)| rest.to_string())
}

#[test]
fn the_public_surface_is_the_committed_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut differences = String::new();
    for (folder, name) in CRATES {
        let found = Listing::of(&root.join(folder));
        let list = root.join("tests/surface").join(format!("{name}.txt"));
        let mut text = String::new();
        for line in &found {
            let _ = writeln!(text, "{line}");
        }
        if std::env::var("SURFACE").is_ok_and(|value| value == "write") {
            std::fs::create_dir_all(list.parent().expect("a folder")).expect("a folder");
            std::fs::write(&list, &text).expect("a list is written");
        }
        let committed = std::fs::read_to_string(&list).unwrap_or_default();
        let committed: BTreeSet<String> = committed.lines().map(str::to_string).collect();
        for line in found.symmetric_difference(&committed) {
            let sign = if found.contains(line) { '+' } else { '-' };
            let _ = writeln!(differences, "{name}: {sign} {line}");
        }
    }
    assert!(
        differences.is_empty(),
        "the public surface changed; SURFACE=write writes the lists anew\n{differences}"
    );
}

/// Checks known items, so that an error of the reader cannot leave the lists empty unnoticed.
#[test]
fn the_lists_hold_what_programs_use() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let facade = Listing::of(&root.join("src"));
    assert!(facade.contains("struct Deck"));
    assert!(
        facade
            .iter()
            .any(|line| line.starts_with("fn Deck::open(path: impl AsRef<Path>"))
    );
    assert!(
        facade
            .iter()
            .any(|line| line.starts_with("use Severity = admire_syntax"))
    );
    let syntax = Listing::of(&root.join("src/syntax"));
    assert!(
        syntax
            .iter()
            .any(|line| line.starts_with("fn Dataset::parse(source: Source)"))
    );
    assert!(
        syntax
            .iter()
            .all(|line| !line.contains("fn Dataset::named("))
    );
}
