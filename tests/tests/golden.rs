//! The digest of a fixed run, pinned, and the same when the core is built for all that this processor can do.
//!
//! The run is `shared/examples/golden.rs`; prediction depends on its bits being the same for client and server.

use std::path::Path;
use std::process::Command;

use pottery_shared::clay::Vectors;

#[path = "../../shared/examples/golden.rs"]
#[expect(dead_code, reason = "its main is run as a program of its own")]
mod golden;

/// Pinned on x86-64: nothing but IEEE operations and libm's own code makes a radius.
const PINNED: [u64; 3] = [0x0515_2ca1_9e46_3ec7, 0xd949_08a0_b6e0_0458, 0x3361_1661_a322_293a];

/// The same of a rib.
const PINNED_RIB: [u64; 3] = [0x28a1_e01f_b874_d90a, 0x5730_458f_6fc7_aa2c, 0x1e9a_dca3_bf8d_37bb];

#[test]
fn fixed_run_of_a_rib_gives_the_pinned_pot() {
    let found = golden::METHODS.map(|method| golden::run_rib(method, Vectors::default()).unwrap());
    for (method, (digest, volume_mm3)) in golden::METHODS.iter().zip(found) {
        println!("{method:?}: {digest:#018x}, {volume_mm3:.0} mm³ pressed away");
        assert!(volume_mm3 > 100.0, "{method:?}: {volume_mm3} mm³");
    }
    let digests = found.map(|(digest, _)| digest);
    assert!(digests == PINNED_RIB, "the pot is another: the new digests are {digests:#018x?}");
}

#[test]
fn fixed_run_gives_the_pinned_pot() {
    let found = golden::METHODS.map(|method| golden::run(method, Vectors::default()).unwrap());
    for (method, (digest, volume_mm3)) in golden::METHODS.iter().zip(found) {
        println!("{method:?}: {digest:#018x}, {volume_mm3:.0} mm³ pressed away");
        assert!(volume_mm3 > 100.0, "{method:?}: {volume_mm3} mm³");
    }
    let digests = found.map(|(digest, _)| digest);
    assert!(digests == PINNED, "the pot is another: the new digests are {digests:#018x?}");
}

#[test]
fn the_narrowest_vectors_give_the_same_bits() {
    for (method, (pinned, pinned_rib)) in golden::METHODS.into_iter().zip(PINNED.into_iter().zip(PINNED_RIB)) {
        assert_eq!(golden::run(method, Vectors::baseline()).unwrap().0, pinned, "{method:?}");
        assert_eq!(golden::run_rib(method, Vectors::baseline()).unwrap().0, pinned_rib, "{method:?} with a rib");
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
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&built.stdout);
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    for (method, (pinned, pinned_rib)) in golden::METHODS.iter().zip(PINNED.into_iter().zip(PINNED_RIB)) {
        assert!(said.contains(&format!("{method:?} {pinned:#018x},")), "{said}");
        assert!(said.contains(&format!("{method:?} with a rib {pinned_rib:#018x},")), "{said}");
    }
}
