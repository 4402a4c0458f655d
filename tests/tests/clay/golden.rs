//! The digest of a fixed run, pinned, and the same when the core is built for all that this processor can do.
//!
//! The run is `shared/examples/golden.rs`; prediction depends on its bits being the same for client and server.

use std::path::Path;
use std::process::Command;

use pottery_shared::clay::{MethodKind, PotError, Vectors};

#[path = "../../../shared/examples/golden.rs"]
#[expect(dead_code, reason = "its main is run as a program of its own")]
mod run;

/// Pinned on x86-64: nothing but IEEE operations and libm's own code makes a radius.
const PINNED: [u64; 3] = [0x0515_2ca1_9e46_3ec7, 0xd949_08a0_b6e0_0458, 0x3daf_771e_fdff_6bb9];

/// The same of a rib.
const PINNED_RIB: [u64; 3] = [0xf96f_2248_eaa5_a830, 0xc452_0ef1_85a1_6b9d, 0x4766_bde9_351d_6926];

/// The same of a hollow pot, of both skins of its wall and its folds.
const PINNED_HOLLOW: [u64; 3] = [0xe66f_7fe7_3100_d68f, 0x7e57_ac34_c309_9bef, 0x9351_a5bc_09f1_7976];

/// A run of each kind: what it is called, what it gives and what is pinned.
type Run = (&'static str, fn(MethodKind, Vectors) -> Result<(u64, f64), PotError>, [u64; 3]);
const RUNS: [Run; 3] = [
    ("", run::run, PINNED),
    (" with a rib", run::run_rib, PINNED_RIB),
    (" on a hollow pot", run::run_hollow, PINNED_HOLLOW),
];

/// Clay that a run moves at least, mm³: the digest of a pot that nobody touched would pin nothing.
const MOVED_MIN_MM3: f64 = 500.0;

#[test]
fn fixed_runs_give_the_pinned_pots() {
    for (name, run, pinned) in RUNS {
        let found = run::METHODS.map(|method| run(method, Vectors::default()).unwrap());
        for (method, (digest, moved_mm3)) in run::METHODS.iter().zip(found) {
            println!("{method:?}{name}: {digest:#018x}, {moved_mm3:.0} mm³ moved");
            assert!(moved_mm3 > MOVED_MIN_MM3, "{method:?}{name}: {moved_mm3} mm³");
        }
        let digests = found.map(|(digest, _)| digest);
        assert!(digests == pinned, "the pot{name} is another: the new digests are {digests:#018x?}");
    }
}

#[test]
fn the_narrowest_vectors_give_the_same_bits() {
    for (name, run, pinned) in RUNS {
        for (method, pinned) in run::METHODS.into_iter().zip(pinned) {
            assert_eq!(run(method, Vectors::baseline()).unwrap().0, pinned, "{method:?}{name}");
        }
    }
}

#[test]
fn this_machines_widest_vectors_give_the_same_bits() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden");
    let built = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--release", "--locked", "--package", "pottery-shared", "--example", "golden"])
        .arg("--target-dir")
        .arg(&folder)
        .env("RUSTFLAGS", "-C target-cpu=native")
        // nobody looks for a line in it
        .env("CARGO_PROFILE_RELEASE_DEBUG", "0")
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&built.stdout);
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    for (name, _, pinned) in RUNS {
        for (method, pinned) in run::METHODS.iter().zip(pinned) {
            assert!(said.contains(&format!("{method:?}{name} {pinned:#018x},")), "{said}");
        }
    }
}
