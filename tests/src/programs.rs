//! The programs as they are run: where they are built, folders for what they write, and tests that need a process of their own.
//!
//! Builds what is asked for once a process; runs nothing else.
//! Invariant: no two tests share a folder.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Set where a test runs in a process of its own.
const ANEW: &str = "POTTERY_TEST_ANEW";

/// The program of that name, built as the whole workspace is, so that nothing is compiled twice.
///
/// # Panics
/// When it cannot be built.
#[must_use]
pub fn program(name: &str) -> PathBuf {
    static BUILT: OnceLock<()> = OnceLock::new();
    BUILT.get_or_init(|| {
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
        let mut build = Command::new(cargo);
        // what tells a test which package is its own and where that wrote would have dependencies built again, which look at it
        let is_packages =
            |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") || name == "OUT_DIR";
        for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(is_packages)) {
            build.env_remove(name);
        }
        let built = build
            .args(["build", "--workspace", "--bins", "--locked"])
            .args((!cfg!(debug_assertions)).then_some("--release"))
            .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
            .output()
            .expect("cargo runs, since it runs this test");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    });
    // a test lies in the same folder, one deeper
    let mut path = std::env::current_exe().expect("a running program has a path");
    path.pop();
    path.pop();
    path.join(name)
}

/// Whether this process was begun by [`anew`].
#[must_use]
pub fn is_anew() -> bool {
    std::env::var_os(ANEW).is_some()
}

/// Runs the test of that name alone in a process with other variables, for what is read from those alone; `None` takes one away.
///
/// # Panics
/// When the test fails there, with what it said, and when its name is in that of another one.
pub fn anew(test: &str, variables: &[(&str, Option<&OsStr>)]) {
    let mut command = Command::new(std::env::current_exe().expect("a running program has a path"));
    command.args([test, "--nocapture"]).env(ANEW, "1");
    for (name, value) in variables {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    let ran = command.output().expect("a test that runs can be run again");
    let said = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success() && said.contains(" 1 passed"), "in a process of its own: {said}");
}

/// An empty folder of the test's own.
///
/// # Panics
/// When it cannot be made.
#[must_use]
pub fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("pottery-{name}-{}", std::process::id()));
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("what an earlier test left can be removed");
    }
    fs::create_dir_all(&folder).expect("the folder for temporary files can be written");
    folder
}
