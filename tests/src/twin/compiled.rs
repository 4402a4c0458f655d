//! C sources beside this file, compiled when a test asks for them.
//!
//! Invariant: a test that cannot compile says which compiler to install; each library is a file of its own, so that twins in one
//! process share nothing.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

/// Compiles `src/twin/{source}` to a library with the compiler's flags, and says where it lies.
///
/// # Panics
/// Without a C compiler, with what to install.
pub(super) fn library(source: &str, flags: &[&str]) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = format!("{}-twin-{}-{number}.so", source.trim_end_matches(".c"), std::process::id());
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/twin").join(source);
    let file = std::env::temp_dir().join(name);
    let arguments = ["-shared", "-fPIC", "-O1", "-o"];
    let libraries = ["-lpthread", "-ldl", "-lm"];
    let compiled = Command::new("cc").args(flags).args(arguments).arg(&file).arg(&source).args(libraries).output();
    let compiled = compiled.unwrap_or_else(|error| {
        panic!("a twin in C needs a compiler named cc: {error} (Debian: apt-get install gcc libc6-dev)")
    });
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    file
}
