//! What the source of the hand's tick may not name: whatever waits, allocates, asks the system or ends a thread.
//!
//! Files that a tick goes through are read whole, so that a function that is new in one is looked at without being listed here.
//! Invariant: a function that is passed over stands in [`BESIDE`] and does break a rule.

use std::path::{Path, PathBuf};

/// What a tick goes through: files, and folders with all that is in them.
const TICK_PATH: [&str; 15] = [
    "client/src/haptic_loop.rs",
    "client/src/pacing.rs",
    "client/src/boundary.rs",
    "client/src/device/driven.rs",
    "client/src/device/pointer.rs",
    "client/src/device/simulated.rs",
    "client/src/device/scripted.rs",
    "client/src/device/rhythm.rs",
    "client/src/device/calibration.rs",
    "shared/src/prediction",
    "shared/src/haptics.rs",
    "shared/src/haptics",
    "shared/src/clay",
    "shared/src/tool.rs",
    "shared/src/tool",
];

/// Files among them that no tick goes through.
const ELSEWHERE: [&str; 7] = [
    // whose clay is brought up to the confirmed one: a worker's
    "shared/src/prediction/predictor.rs",
    "shared/src/prediction/milestones.rs",
    // a pot on another grid, a solid to print, one that turns fast as a profile
    "shared/src/clay/resample.rs",
    "shared/src/clay/solid.rs",
    "shared/src/clay/profile.rs",
    // tools before anybody holds them
    "shared/src/tool/facets.rs",
    "shared/src/tool/rack.rs",
];

/// Functions in the others that are beside the tick.
const BESIDE: [(&str, &[&str]); 23] = [
    // before the first tick and after the last
    ("client/src/haptic_loop.rs", &["new", "histogram"]),
    ("client/src/boundary.rs", &["boundary"]),
    // the rest between ticks, which the next test reads, and what a person types
    ("client/src/pacing.rs", &["wait_for", "wait_until", "from_str"]),
    // the window's side and the driver's
    (
        "client/src/device/driven.rs",
        &[
            "locked",
            "new",
            "notice",
            "about",
            "say",
            "fit",
            "fit_to",
            "found",
            "notify",
            "watch",
            "wait",
            "open",
            "monitor",
            "end",
            "supervise",
        ],
    ),
    // whose clay is copied, and whose tools: a worker's
    ("shared/src/prediction/field.rs", &["new", "shapes"]),
    // room that is made before the first step
    ("shared/src/clay/bending.rs", &["new", "assembled"]),
    ("shared/src/clay/contact.rs", &["with_room"]),
    ("shared/src/clay/joint.rs", &["with_room"]),
    ("shared/src/clay/lathe.rs", &["new"]),
    ("shared/src/clay/pot.rs", &["new", "on_grid"]),
    ("shared/src/clay/rays.rs", &["with_room"]),
    ("shared/src/clay/rim.rs", &["with_room"]),
    ("shared/src/clay/schedule.rs", &["new"]),
    ("shared/src/clay/substep.rs", &["with_rack", "for_spheres", "using", "rack"]),
    ("shared/src/clay/surface.rs", &["cylinder", "with_radii", "untouched", "directions"]),
    ("shared/src/clay/unbent.rs", &["with_room"]),
    ("shared/src/clay/wheel.rs", &["starting_at"]),
    ("shared/src/clay/window.rs", &["for_grid"]),
    ("shared/src/tool/convex.rs", &["new", "find_outermost", "normals"]),
    ("shared/src/tool/ray.rs", &["planes"]),
    ("shared/src/tool/ridges.rs", &["of"]),
    // room that is made anew for another grid
    ("shared/src/tool/outline.rs", &["make_room"]),
    ("shared/src/tool/section.rs", &["lay_out"]),
];

/// What waits, allocates, asks the system for something, or may end a thread that must not end.
const FORBIDDEN: [&str; 38] = [
    "Mutex",
    "RwLock",
    ".lock(",
    "locked(",
    ".wait(",
    ".recv(",
    ".join(",
    "yield_now",
    "park",
    "spawn",
    "sleep",
    "std::io",
    "std::fs",
    "std::net",
    "std::process",
    "std::env",
    "rustix",
    "SystemTime",
    "println!",
    "eprintln!",
    "print!",
    "tracing::",
    "log::",
    "format!",
    "Vec::",
    "vec!",
    "Box::",
    "Arc::",
    "String",
    ".to_vec(",
    ".to_owned(",
    ".to_string(",
    ".clone()",
    ".collect",
    ".unwrap()",
    ".expect(",
    "panic!",
    "File",
];

/// Ranges, of which a copy is two numbers.
const RANGES: [&str; 3] = ["rows.clone()", "range.clone()", "chunks.clone()"];

/// A function of a file: its name and its lines, without comments.
struct Function {
    name: String,
    lines: Vec<String>,
}

impl Function {
    /// What it names that no tick may.
    fn broken(&self) -> Vec<String> {
        let lines =
            self.lines.iter().map(|line| RANGES.iter().fold(line.clone(), |line, range| line.replace(range, "")));
        let words = lines.flat_map(|line| {
            let named = FORBIDDEN.iter().filter(move |word| line.contains(**word));
            named.copied().collect::<Vec<_>>()
        });
        words.map(|word| format!("{}: `{word}`", self.name)).collect()
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The functions of a file, but for those of its tests.
fn functions(path: &Path) -> Vec<Function> {
    let text = std::fs::read_to_string(path).expect("a file of the path can be read");
    let source = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines: Vec<_> = source.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned()).collect();
    let mut functions = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let Some((_, after)) = line.split_once("fn ").filter(|(before, _)| before.is_empty() || before.ends_with(' '))
        else {
            continue;
        };
        let name: String = after.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
        let (mut depth, mut is_inside) = (0, false);
        for (length, line) in lines[start..].iter().enumerate() {
            depth += line.matches('{').count() as i32 - line.matches('}').count() as i32;
            is_inside |= line.contains('{');
            if is_inside && depth == 0 {
                functions.push(Function { name, lines: lines[start..=start + length].to_vec() });
                break;
            }
            // what a trait only asks for
            if !is_inside && line.trim_end().ends_with(';') {
                break;
            }
        }
    }
    functions
}

/// The files of the path, from the repository's root.
fn files() -> Vec<String> {
    let mut found = Vec::new();
    let mut left: Vec<PathBuf> = TICK_PATH.map(PathBuf::from).to_vec();
    while let Some(path) = left.pop() {
        let whole = root().join(&path);
        if whole.is_dir() {
            let name = |entry: std::io::Result<std::fs::DirEntry>| path.join(entry.expect("it is there").file_name());
            left.extend(std::fs::read_dir(whole).expect("a folder can be read").map(name));
        } else {
            found.push(path.to_str().expect("names are letters").to_owned());
        }
    }
    found.sort();
    found
}

#[test]
fn tick_names_nothing_that_waits_or_allocates() {
    let files = files();
    for path in ELSEWHERE.iter().chain(BESIDE.iter().map(|(path, _)| path)) {
        assert!(files.iter().any(|file| file == path), "{path} is not on the path");
    }
    let (mut read, mut wrong) = (0, Vec::new());
    for path in files.iter().filter(|path| !ELSEWHERE.contains(&path.as_str())) {
        let beside = BESIDE.iter().find(|(file, _)| file == path).map_or(&[][..], |(_, beside)| beside);
        let functions = functions(&root().join(path));
        for function in functions.iter().filter(|function| !beside.contains(&function.name.as_str())) {
            read += 1;
            wrong.extend(function.broken().into_iter().map(|broken| format!("{path}, {broken}")));
        }
        for name in beside {
            let breaks = functions.iter().any(|function| function.name == *name && !function.broken().is_empty());
            if !breaks {
                wrong.push(format!("{path}, {name}: is passed over and breaks no rule"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(read > 500, "{read} functions were read");
}

#[test]
fn the_thread_asks_the_system_for_sleep_alone() {
    let wait =
        functions(&root().join("client/src/pacing.rs")).into_iter().find(|function| function.name == "wait_until");
    let wait = wait.expect("the rest between ticks").lines;
    let named = |word: &str| wait.iter().filter(|line| line.contains(word)).count();
    assert_eq!(named("std::thread::sleep(left - spun)"), 1);
    let broken: Vec<_> = FORBIDDEN.iter().filter(|word| named(word) > usize::from(**word == "sleep")).collect();
    assert!(broken.is_empty(), "{broken:?}");
}
