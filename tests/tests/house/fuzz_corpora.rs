//! The corpora of the fuzz targets, replayed on any toolchain, each entry as it is and bent in many ways.
//!
//! Invariant under test: what strangers send is refused or taken, and nothing breaks; `tests/fuzz/src/bodies.rs` has the laws.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

#[expect(unreachable_pub, reason = "public for the fuzz targets, which are a package of their own")]
#[path = "../../fuzz/src/bodies.rs"]
mod bodies;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use pottery_shared::protocol::{self, DATAGRAM_MEMORY_MAX, Upload};
use pottery_tests::dice::Dice;

/// How often each entry is bent.
const BENT: u64 = 150;

/// The entries of a target, by name, and the empty one.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target);
    let mut entries: Vec<_> = fs::read_dir(&folder)
        .unwrap_or_else(|fault| panic!("{}: {fault}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    entries.sort();
    assert!(entries.len() >= 3, "{} entries of {target}", entries.len());
    entries.push(("nothing".into(), Vec::new()));
    entries
}

/// An entry with some bytes changed, taken out, doubled, or of another entry.
fn bent(entries: &[(String, Vec<u8>)], at: usize, dice: &mut Dice) -> Vec<u8> {
    let mut bytes = entries[at].1.clone();
    for _ in 0..1 + dice.roll() % 4 {
        let place = (dice.roll() as usize) % (bytes.len() + 1);
        match dice.roll() % 5 {
            0 => bytes.truncate(place),
            1 => bytes.insert(place, dice.roll() as u8),
            2 => {
                let other = &entries[(dice.roll() as usize) % entries.len()].1;
                let from = (dice.roll() as usize) % (other.len() + 1);
                bytes.truncate(place);
                bytes.extend(&other[from..]);
            }
            _ => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= 1 << (dice.roll() % 8);
                }
            }
        }
    }
    bytes
}

fn replay(target: &str, body: fn(&[u8])) {
    let entries = corpus(target);
    let run = |said: &dyn std::fmt::Display, bytes: &[u8]| {
        if catch_unwind(AssertUnwindSafe(|| body(bytes))).is_err() {
            let hex: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            panic!("{target}, {said}: {}", hex.concat());
        }
    };
    for (at, (name, bytes)) in entries.iter().enumerate() {
        run(name, bytes);
        for seed in 0..BENT {
            let mut dice = Dice::new(seed * 1000 + at as u64);
            run(&format!("{name} bent by {seed}"), &bent(&entries, at, &mut dice));
        }
    }
}

#[test]
fn samples_of_the_corpus_are_of_this_version_s_wire() {
    let entries = corpus("samples").into_iter().filter(|(name, _)| name != "nothing");
    for (name, bytes) in entries {
        let (mut rest, mut samples) = (&bytes[..], 0);
        while let Some((&[_, low, high], behind)) = rest.split_first_chunk() {
            let (own, behind) = behind.split_at(u16::from_le_bytes([low, high]).into());
            let upload: Upload = protocol::decode::<DATAGRAM_MEMORY_MAX, _>(own).unwrap();
            samples += upload.inputs.runs.iter().map(|run| 1 + run.steps.len()).sum::<usize>();
            rest = behind;
        }
        assert!(samples > 3, "{name} has {samples} samples");
    }
}

#[test]
fn envelopes_are_refused_or_read_back() {
    replay("envelope", bodies::envelope);
}

#[test]
fn tiles_of_strangers_are_taken_whole_or_not_at_all() {
    replay("tiles", bodies::tiles);
}

#[test]
fn codec_holds_what_a_full_copy_holds() {
    replay("copies", bodies::copies);
}

#[test]
fn samples_of_strangers_stay_in_order_and_within_reach() {
    replay("samples", bodies::samples);
}

#[test]
fn a_room_stands_whatever_peers_do() {
    replay("server", bodies::server);
}

#[test]
fn a_client_stands_whatever_a_server_says() {
    replay("client", bodies::client);
}
