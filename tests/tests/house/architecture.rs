//! The rules of the house, held against the files as they are: who may use whom, and what every file keeps to.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What the modules of the core may use: the arrows of `ARCHITECTURE.md`.
const MAY_USE: &[(&str, &[&str])] = &[
    ("units", &[]),
    ("coding", &[]),
    ("lanes", &[]),
    ("tool", &["lanes", "units"]),
    ("clay", &["lanes", "tool", "units"]),
    ("haptics", &["clay", "tool", "units"]),
    ("protocol", &["coding", "units"]),
    ("snapshot", &["clay", "coding", "protocol", "tool", "units"]),
    ("prediction", &["clay", "protocol", "snapshot", "tool", "units"]),
    ("session", &["clay", "haptics", "prediction", "protocol", "snapshot", "tool", "units"]),
    ("room", &["clay", "protocol", "session", "snapshot", "tool", "units"]),
];

/// What the core never names: they reach outside.
const OUTSIDE: &[&str] = &["std", "tokio", "quinn", "quinn_proto", "wgpu", "winit", "egui", "rustls"];

/// Names that say nothing about what is inside.
const EMPTY_NAMES: &[&str] = &["utils", "util", "helpers", "helper", "common", "misc"];

const LINES_MAX: usize = 700;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|fault| panic!("cannot read {}: {fault}", path.display()))
}

/// Path from the root, with slashes on every system.
fn name(path: &Path) -> String {
    let parts: Vec<_> = path.strip_prefix(root()).unwrap_or(path).iter().map(|part| part.to_string_lossy()).collect();
    parts.join("/")
}

/// Every file below `folder` with one of the endings; what is built or hidden is left out.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let own_name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if !own_name.starts_with('.') && !["target", "studio-out", "node_modules"].contains(&own_name.as_str()) {
                found.extend(files(&path, endings));
            }
        } else if path.extension().is_some_and(|ending| endings.iter().any(|wanted| ending == *wanted)) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Fails with every broken rule at once, one a line.
fn assert_none(rule: &str, broken: &[String]) {
    assert!(broken.is_empty(), "{rule}:\n  {}", broken.join("\n  "));
}

/// Identifiers, `::` and single signs of Rust source; comments and the contents of strings are left out.
fn tokens(source: &str) -> Vec<String> {
    let chars: Vec<char> = source.chars().collect();
    let is_word = |at: usize| chars.get(at).is_some_and(|sign| sign.is_alphanumeric() || *sign == '_');
    let mut found = Vec::new();
    let mut at = 0;
    while at < chars.len() {
        let rest = &chars[at..];
        if rest.starts_with(&['/', '/']) {
            at += rest.iter().position(|&sign| sign == '\n').unwrap_or(rest.len());
        } else if rest.starts_with(&['/', '*']) {
            at += block_comment(rest);
        } else if let Some(length) = raw_string(rest) {
            at += length;
        } else if chars[at] == '"' {
            at += quoted(rest, '"');
        } else if chars[at] == '\'' && (rest.get(1) == Some(&'\\') || rest.get(2) == Some(&'\'')) {
            // a character; a lifetime has no second quote there
            at += quoted(rest, '\'');
        } else if is_word(at) {
            let end = (at..).find(|&end| !is_word(end)).unwrap_or(chars.len());
            found.push(chars[at..end].iter().collect());
            at = end;
        } else if rest.starts_with(&[':', ':']) {
            found.push("::".to_owned());
            at += 2;
        } else {
            if !chars[at].is_whitespace() {
                found.push(chars[at].to_string());
            }
            at += 1;
        }
    }
    found
}

/// Length of a block comment, with those inside it.
fn block_comment(rest: &[char]) -> usize {
    let mut depth = 0;
    let mut at = 0;
    while at < rest.len() {
        if rest[at..].starts_with(&['/', '*']) {
            depth += 1;
            at += 2;
        } else if rest[at..].starts_with(&['*', '/']) {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    at
}

/// Length of a raw string that begins here, or nothing.
fn raw_string(rest: &[char]) -> Option<usize> {
    let prefix = if rest.starts_with(&['b', 'r']) { 2 } else { usize::from(rest.first() == Some(&'r')) };
    let hashes = rest[prefix..].iter().take_while(|&&sign| sign == '#').count();
    if prefix == 0 || rest.get(prefix + hashes) != Some(&'"') {
        return None;
    }
    let end: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
    let start = prefix + hashes + 1;
    let inside = rest[start..].windows(end.len()).position(|window| window == end);
    Some(inside.map_or(rest.len(), |length| start + length + end.len()))
}

/// Length of a string or character that begins here, quotes included.
fn quoted(rest: &[char], quote: char) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != quote {
        at += if rest[at] == '\\' { 2 } else { 1 };
    }
    at + 1
}

/// The tokens without what is compiled for unit tests only.
fn without_tests(tokens: &[String]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at..].iter().take(7).map(String::as_str).eq(["#", "[", "cfg", "(", "test", ")", "]"]) {
            at += item_length(&tokens[at..]);
        } else {
            kept.push(tokens[at].clone());
            at += 1;
        }
    }
    kept
}

/// Number of tokens to the end of an item: its semicolon, or the brace that closes its body.
fn item_length(tokens: &[String]) -> usize {
    let mut depth = 0_i32;
    for (at, token) in tokens.iter().enumerate() {
        match token.as_str() {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 && (token == ";" || token == "}") {
            return at + 1;
        }
    }
    tokens.len()
}

/// The names that stand first behind `crate::` or behind a `super::` that leaves the module.
///
/// `depth` is the number of modules from the root of the crate to this file: 1 for `clay`, 2 for `clay::wheel`.
fn names_at_root(tokens: &[String], depth: usize) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut at = 0;
    while at < tokens.len() {
        let mut next = at;
        let mut climbed = 0;
        while tokens[next..].iter().take(2).map(String::as_str).eq(["super", "::"]) {
            climbed += 1;
            next += 2;
        }
        if tokens[at..].iter().take(2).map(String::as_str).eq(["crate", "::"]) {
            climbed = depth;
            next = at + 2;
        }
        if climbed > 0 && climbed >= depth {
            found.extend(first_names(&tokens[next..]));
        }
        at = next.max(at + 1);
    }
    found
}

/// The first name of a path, or those of every path of a group in braces.
fn first_names(tokens: &[String]) -> Vec<String> {
    if tokens.first().is_none_or(|first| first != "{") {
        return tokens.first().cloned().into_iter().collect();
    }
    let group = &tokens[..item_length(tokens)];
    let mut depth = 0;
    let mut names = Vec::new();
    for pair in group.windows(2) {
        depth += i32::from(pair[0] == "{") - i32::from(pair[0] == "}");
        if depth == 1 && (pair[0] == "{" || pair[0] == ",") {
            names.push(pair[1].clone());
        }
    }
    names
}

/// The modules from the root of the crate down to a file.
fn module_path(file: &Path, src: &Path) -> Vec<String> {
    let inside = file.strip_prefix(src).unwrap().with_extension("");
    inside.iter().map(|part| part.to_string_lossy().into_owned()).filter(|part| part != "mod").collect()
}

/// Every file of the core but `lib.rs`, with its modules and its tokens without tests.
fn core_files() -> Vec<(String, Vec<String>, Vec<String>)> {
    let src = root().join("shared/src");
    files(&src, &["rs"])
        .into_iter()
        .map(|file| (name(&file), module_path(&file, &src), without_tests(&tokens(&read(&file)))))
        .filter(|(_, modules, _)| modules != &["lib"])
        .collect()
}

#[test]
fn reader_of_source_sees_paths_and_nothing_else() {
    let source = r##"
        //! crate::comment
        /* crate::block /* crate::inner */ crate::block */
        use crate::{clay::{Pot, wheel}, units};
        use super::super::room::Room;
        use super::sibling::Thing;
        const TEXT: &str = "crate::string \" crate::string";
        const RAW: &str = r#"crate::raw " crate::raw"#;
        const SIGN: char = '"';
        fn of<'a>(text: &'a str) { crate::tool::press(text) }
        #[cfg(test)]
        mod tests { use crate::only_tests; fn inner() {} }
        #[cfg(test)]
        use crate::only_tests;
        struct After(crate::haptics::Proxy);
    "##;
    let found = names_at_root(&without_tests(&tokens(source)), 2);
    assert_eq!(found.iter().map(String::as_str).collect::<Vec<_>>(), ["clay", "haptics", "room", "tool", "units"]);
}

#[test]
fn arrows_between_modules_make_no_circle() {
    // whoever may be used stands further up
    for (at, (module, may_use)) in MAY_USE.iter().enumerate() {
        for used in *may_use {
            assert!(MAY_USE[..at].iter().any(|(name, _)| name == used), "{module} may use {used}, which comes later");
        }
    }
}

#[test]
fn no_root_is_taken_among_vectors_without_them() {
    // `lanes` says why, and has both
    let core = root().join("shared/src");
    let folders = ["clay", "tool"].map(|folder| core.join(folder));
    let modules = folders.iter().flat_map(|folder| files(folder, &["rs"]));
    let mut broken = Vec::new();
    for path in modules {
        let text = read(&path);
        let found = ["libm::sqrtf", "libm::hypotf"].into_iter().filter(|called| text.contains(called));
        broken.extend(found.map(|called| format!("{}: `{called}`", name(&path))));
    }
    assert_none("roots among vectors", &broken);
}

#[test]
fn core_modules_use_only_what_they_may() {
    let mut broken = Vec::new();
    for (file, modules, tokens) in core_files() {
        let Some((_, may_use)) = MAY_USE.iter().find(|(name, _)| *name == modules[0]) else {
            broken.push(format!("{file}: the module `{}` has no row in the table of arrows", modules[0]));
            continue;
        };
        for used in names_at_root(&tokens, modules.len()) {
            let is_module = MAY_USE.iter().any(|(name, _)| *name == used);
            if used == "*" || (is_module && used != modules[0] && !may_use.contains(&used.as_str())) {
                broken.push(format!("{file}: `{}` may not use `{used}`", modules[0]));
            }
        }
    }
    assert_none("arrows between the core's modules", &broken);
}

#[test]
fn core_names_nothing_outside() {
    let library = read(&root().join("shared/src/lib.rs"));
    assert!(library.lines().any(|line| line.trim() == "#![no_std]"), "shared/src/lib.rs is not no_std");
    let mut broken = Vec::new();
    let library = ("shared/src/lib.rs".to_owned(), Vec::new(), without_tests(&tokens(&library)));
    for (file, _, tokens) in core_files().into_iter().chain([library]) {
        broken.extend(
            OUTSIDE
                .iter()
                .filter(|name| tokens.iter().any(|token| token == *name))
                .map(|name| format!("{file}: names `{name}`")),
        );
    }
    for package in dependencies("shared") {
        if OUTSIDE.contains(&package.replace('-', "_").as_str()) || package.starts_with("pottery-") {
            broken.push(format!("shared/Cargo.toml: depends on {package}"));
        }
    }
    assert_none("the core reaches outside", &broken);
}

/// What a package depends on, also for its tests, its build and single targets.
#[test]
fn no_program_asks_what_time_of_day_it_is() {
    // somebody who sets a machine's clock, or a machine that finds the network's, changes nothing in a lesson: what is counted is how long
    // ago things were
    let folders = ["shared", "server", "client"].map(|folder| root().join(folder));
    let sources: Vec<_> = folders.iter().flat_map(|folder| files(folder, &["rs"])).collect();
    assert!(sources.len() > 100, "{} files", sources.len());
    let asks = |file: &PathBuf| {
        let tokens = without_tests(&tokens(&read(file)));
        ["SystemTime", "UNIX_EPOCH", "chrono", "time_t"].iter().any(|name| tokens.iter().any(|token| token == name))
    };
    let broken: Vec<_> = sources.iter().filter(|file| asks(file)).map(|file| name(file)).collect();
    assert_none("a program asks for the time of day", &broken);
}

#[test]
fn what_a_server_writes_down_knows_no_address_and_nobody_else_is_talked_to() {
    let names = |file: &PathBuf, words: &[&str]| {
        let tokens = without_tests(&tokens(&read(file)));
        words.iter().any(|word| tokens.iter().any(|token| token == word))
    };
    // who writes files, and the core, of which those are told
    let src = root().join("server/src");
    let mut writers = ["class_register.rs", "folder.rs", "store.rs", "teacher.rs", "certificate.rs", "recording.rs"]
        .map(|file| src.join(file))
        .to_vec();
    for folder in [src.join("recording"), root().join("shared")] {
        writers.extend(files(&folder, &["rs"]));
    }
    assert!(writers.iter().any(|file| names(file, &["File", "write_whole"])), "none of them writes");
    let broken: Vec<_> = writers
        .iter()
        .filter(|file| names(file, &["IpAddr", "Ipv4Addr", "Ipv6Addr", "SocketAddr", "remote_address"]))
        .map(|file| name(file))
        .collect();
    assert_none("what is kept knows where people are", &broken);
    // a studio and its server, the local network's announcement, operators of this machine, and a device beside it
    let known = [
        "client/src/device/inverse3.rs",
        "client/src/finding.rs",
        "client/src/rehearsal/proxy.rs",
        "client/src/transport.rs",
        "client/studio/src/hosting.rs",
        "server/src/announcing.rs",
        "server/src/batching.rs",
        "server/src/console.rs",
        "server/src/operation.rs",
        "server/src/server.rs",
        "server/src/transport.rs",
    ];
    let sockets = ["UdpSocket", "TcpStream", "TcpListener", "Socket", "ServiceDaemon", "UnixStream"];
    let folders = ["shared", "server", "client"].map(|folder| root().join(folder));
    let talk: Vec<_> = folders
        .iter()
        .flat_map(|folder| files(folder, &["rs"]))
        .filter(|file| names(file, &sockets) || read(file).contains("Endpoint::client("))
        .map(|file| name(&file))
        .collect();
    assert_eq!(talk.into_iter().collect::<BTreeSet<_>>(), known.map(str::to_owned).into());
}

fn dependencies(folder: &str) -> BTreeSet<String> {
    fn gather(table: &toml::Table, found: &mut BTreeSet<String>) {
        for (key, value) in table {
            let Some(inner) = value.as_table() else { continue };
            if key.ends_with("dependencies") {
                found.extend(inner.keys().cloned());
            } else {
                gather(inner, found);
            }
        }
    }
    let manifest = root().join(folder).join("Cargo.toml");
    let mut found = BTreeSet::new();
    gather(&read(&manifest).parse().unwrap(), &mut found);
    found
}

#[test]
fn packages_depend_one_way() {
    for (folder, never) in [
        ("shared", &["pottery-client", "pottery-server", "pottery-studio", "pottery-tests", "pottery-suites"][..]),
        ("shared/files", &["pottery-client", "pottery-server", "pottery-studio", "pottery-tests", "pottery-suites"]),
        ("server", &["pottery-client", "pottery-studio", "pottery-tests", "pottery-suites"]),
        ("client", &["pottery-server", "pottery-studio", "pottery-tests", "pottery-suites"]),
        ("client/studio", &["pottery-tests", "pottery-suites"]),
        ("tests", &["pottery-studio", "pottery-suites"]),
    ] {
        let found = dependencies(folder);
        assert!(!found.is_empty(), "{folder}/Cargo.toml has no dependencies");
        let broken: Vec<_> = never.iter().filter(|package| found.contains(**package)).collect();
        assert!(broken.is_empty(), "{folder}/Cargo.toml depends on {broken:?}");
    }
}

#[test]
fn every_source_file_begins_by_saying_what_it_is_for() {
    let mut broken = Vec::new();
    for file in files(&root(), &["rs", "wgsl"]) {
        let text = read(&file);
        let mark = if file.extension().is_some_and(|ending| ending == "rs") { "//! " } else { "// " };
        let first = text.lines().next().unwrap_or_default();
        if first.strip_prefix(mark).is_none_or(|said| said.trim().is_empty()) {
            broken.push(format!("{}: does not begin with `{mark}`", name(&file)));
        }
    }
    assert_none("files without a header", &broken);
}

#[test]
fn no_source_file_is_too_long() {
    let lengths = files(&root(), &["rs", "wgsl"]).into_iter().map(|file| (read(&file).lines().count(), file));
    let broken: Vec<_> = lengths
        .filter(|(lines, _)| *lines > LINES_MAX)
        .map(|(lines, file)| format!("{}: {lines} lines, at most {LINES_MAX}", name(&file)))
        .collect();
    assert_none("files that do more than one thing", &broken);
}

#[test]
fn every_module_has_a_name_that_says_something() {
    let mut broken = Vec::new();
    for file in files(&root(), &["rs"]) {
        let path = name(&file);
        let in_path = path.trim_end_matches(".rs").split('/').any(|part| EMPTY_NAMES.contains(&part));
        let code = tokens(&read(&file));
        let in_code = code.windows(2).any(|pair| pair[0] == "mod" && EMPTY_NAMES.contains(&pair[1].as_str()));
        if in_path || in_code {
            broken.push(path);
        }
    }
    assert_none("modules named after nothing", &broken);
}

/// Lines of a text in Markdown that are not in a fenced block.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fence && !fenced
    })
}

/// Whether a piece of code in prose is a path: only signs of a path, with a slash, and a known start or an ending.
fn is_path(code: &str) -> bool {
    let Some((first, _)) = code.split_once('/') else { return false };
    let signs = code.chars().all(|sign| sign.is_ascii_alphanumeric() || "._-/".contains(sign));
    let last = code.rsplit('/').next().unwrap_or_default();
    signs && !first.is_empty() && (last.is_empty() || last.contains('.') || root().join(first).exists())
}

#[test]
fn every_path_in_the_architecture_exists() {
    let text = read(&root().join("ARCHITECTURE.md"));
    let paths: BTreeSet<&str> =
        prose(&text).flat_map(|line| line.split('`').skip(1).step_by(2)).filter(|code| is_path(code)).collect();
    assert!(paths.len() >= 5, "ARCHITECTURE.md names only {paths:?}");
    let exists = |path: &str| {
        let there = root().join(path);
        if path.ends_with('/') { there.is_dir() } else { there.exists() }
    };
    let broken: Vec<_> = paths.into_iter().filter(|path| !exists(path)).map(str::to_owned).collect();
    assert_none("ARCHITECTURE.md names what is not there", &broken);
}

#[test]
fn architecture_names_every_package_and_every_module_of_the_core() {
    let text = read(&root().join("ARCHITECTURE.md"));
    let manifest: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    let members = manifest["workspace"]["members"].as_array().unwrap();
    let mut named: Vec<String> = members.iter().map(|member| format!("`{}/`", member.as_str().unwrap())).collect();
    named.extend(core_files().into_iter().map(|(_, modules, _)| format!("`{}`", modules[0])));
    named.retain(|wanted| !text.contains(wanted.as_str()));
    named.dedup();
    assert_none("ARCHITECTURE.md lacks", &named);
}

#[test]
fn every_relative_link_leads_somewhere() {
    assert!(root().join("README.md").is_file(), "there is no README.md");
    let mut broken = Vec::new();
    for file in files(&root(), &["md"]) {
        let text = read(&file);
        for line in prose(&text) {
            for link in line.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
                let target = link.split(['#', ' ']).next().unwrap_or_default();
                let elsewhere = link.contains("://") || link.starts_with("mailto:") || target.is_empty();
                if !elsewhere && !file.parent().unwrap().join(target).exists() {
                    broken.push(format!("{}: {link}", name(&file)));
                }
            }
        }
    }
    assert_none("links that lead nowhere", &broken);
}
