//! What the studio reads and writes when it is run: pots that are gone on with, and sentences when it cannot be.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use pottery_client::pot_file::PotFile;
use pottery_tests::programs::{folder, program};

fn studio(arguments: &[&str]) -> Output {
    Command::new(program("pottery-studio"))
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn assert_success(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The one line that a person reads when the run failed as it should.
fn sentence(output: &Output) -> String {
    assert!(!output.status.success(), "it was meant to fail");
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(!text.contains("panicked"), "{text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    text
}

#[test]
fn saved_pot_is_gone_on_with() {
    let folder = folder("saved");
    let (first, second) = (folder.join("first"), folder.join("second"));
    let made = ["--headless", "--potters", "2", "--seconds", "2.5", "--clay", "soft"];
    assert_success(&studio(&[&made[..], &["--out", text(&first)]].concat()));
    let saved = PotFile::read(&first.join("pot.pot")).unwrap();
    // a tool that stays away leaves the pot as it was
    let away = folder.join("away.csv");
    fs::write(&away, "# tool_radius_mm: 10\nt_s,x_mm,y_mm,z_mm\n0,300,0,50\n1,300,0,60\n").unwrap();
    let opened = ["--headless", "--potters", "1", "--seconds", "0.5", "--stroke", text(&away)];
    let pot = first.join("pot.pot");
    assert_success(&studio(&[&opened[..], &["--open", text(&pot), "--out", text(&second)]].concat()));
    let after = PotFile::read(&second.join("pot.pot")).unwrap();
    assert_eq!(after.pot(), saved.pot(), "radius by radius");
    assert!(after.pot().pot() == saved.pot().pot());
    assert_eq!((after.clay(), after.method()), (saved.clay(), saved.method()));
    let solids = [first, second].map(|folder| fs::read(folder.join("pot.stl")).unwrap());
    assert!(solids[0] == solids[1], "the solid is the same, byte by byte");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn pot_that_cannot_be_opened_is_one_sentence() {
    let folder = folder("unopened");
    let (none, damaged) = (folder.join("none.pot"), folder.join("damaged.pot"));
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/pots/version-1.pot");
    let mut bytes = fs::read(&sample).unwrap();
    bytes[100] ^= 1;
    fs::write(&damaged, bytes).unwrap();
    for (path, expected) in [(&none, "No such file"), (&damaged, "take another copy"), (&folder, "directory")] {
        let text = sentence(&studio(&["--headless", "--open", text(path)]));
        assert!(text.contains(expected), "{text}");
    }
    let output = studio(&["--headless", "--open", text(&sample), "--clay", "soft"]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("cannot be used with"));
    fs::remove_dir_all(folder).unwrap();
}
