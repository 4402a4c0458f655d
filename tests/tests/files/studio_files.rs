//! What the studio reads and writes when it is run: pots that are gone on with, and sentences when it cannot be.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
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
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/pots/version-1.pot");
    let mut bytes = fs::read(&sample).unwrap();
    bytes[100] ^= 1;
    fs::write(&damaged, bytes).unwrap();
    for (path, expected) in
        [(&none, "there is no such file"), (&damaged, "take another copy"), (&folder, "that is a folder")]
    {
        let text = sentence(&studio(&["--headless", "--open", text(path)]));
        assert!(text.contains(expected), "{text}");
    }
    let output = studio(&["--headless", "--open", text(&sample), "--clay", "soft"]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("cannot be used with"));
    fs::remove_dir_all(folder).unwrap();
}

/// The pot file that comes with the tests.
fn sample() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/pots/version-1.pot")
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn one_command_writes_every_form() {
    let folder = folder("every-form");
    let endings = ["stl", "3mf", "obj", "ply", "glb", "svg", "png", "gif"];
    let out: Vec<_> = endings.iter().map(|ending| folder.join("pot").with_extension(ending)).collect();
    let sample = sample();
    let mut arguments = vec!["export", text(&sample)];
    arguments.extend(out.iter().map(|path| text(path)));
    let output = studio(&arguments);
    assert_success(&output);
    let said = String::from_utf8(output.stdout).unwrap();
    for (path, magic) in out.iter().zip([b"" as &[u8], b"PK", b"#", b"ply", b"glTF", b"<?xml", b"\x89PNG", b"GIF89a"]) {
        assert!(said.contains(text(path)), "{said}");
        assert!(fs::read(path).unwrap().starts_with(magic), "{}", path.display());
    }
    assert_eq!(names(&folder).len(), endings.len());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn export_that_cannot_be_written_leaves_the_old_file() {
    let folder = folder("unwritten");
    let (sample, old, protected) = (sample(), folder.join("old.stl"), folder.join("protected.obj"));
    fs::create_dir(folder.join("folder.ply")).unwrap();
    for path in [&old, &protected] {
        fs::write(path, "old").unwrap();
    }
    let mut permissions = fs::metadata(&protected).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&protected, permissions).unwrap();
    for (out, expected) in [
        (folder.join("folder.ply"), "is a folder"),
        (folder.join("none/pot.glb"), "there is no such file or folder"),
        (protected.clone(), "permission denied"),
        (old.join("pot.svg"), "before its name is no folder"),
        (folder.join("pot.doc"), "let it end in .stl"),
    ] {
        let said = sentence(&studio(&["export", text(&sample), text(&out)]));
        assert!(said.contains(expected) && said.contains(text(&out)), "{said}");
    }
    assert_eq!(names(&folder), ["folder.ply", "old.stl", "protected.obj"]);
    assert_eq!(fs::read_to_string(&protected).unwrap(), "old");
    fs::remove_dir_all(folder).unwrap();
}

/// A disk that takes 16 kB and no more: the limit of the shell, and a full device.
#[cfg(target_os = "linux")]
#[test]
fn full_disk_leaves_the_old_file() {
    let folder = folder("full-disk");
    let (sample, old) = (sample(), folder.join("old.stl"));
    fs::write(&old, "old").unwrap();
    let limited = "trap '' XFSZ; ulimit -f 16; exec \"$@\"";
    let output = Command::new("bash")
        .args(["-c", limited, "bash"])
        .arg(program("pottery-studio"))
        .args(["export", text(&sample), text(&old)])
        .output()
        .unwrap();
    let said = sentence(&output);
    assert!(said.contains("cannot be written") && said.contains("make room"), "{said}");
    assert_eq!((fs::read_to_string(&old).unwrap().as_str(), names(&folder).len()), ("old", 1));
    let full = folder.join("full.stl");
    std::os::unix::fs::symlink("/dev/full", &full).unwrap();
    let said = sentence(&studio(&["export", text(&sample), text(&full)]));
    assert!(said.contains("the disk is full"), "{said}");
    fs::remove_dir_all(folder).unwrap();
}

/// The recording goes to a full device, and then everything to a disk that takes 1 kB a file.
#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_recorded_is_said_and_takes_nothing_else_along() {
    let folder = folder("full-recording");
    let (full, out, session) = (folder.join("full.csv"), folder.join("out"), folder.join("s.session"));
    std::os::unix::fs::symlink("/dev/full", &full).unwrap();
    let made = ["--headless", "--potters", "1", "--seconds", "2", "--out", text(&out)];
    let output = studio(&[&made[..], &["--record", text(&full)]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("full.csv cannot be written (the disk is full)"), "{said}");
    PotFile::read(&out.join("pot.pot")).unwrap();
    assert!(out.join("session.json").exists() && out.join("pot.stl").exists(), "{said}");
    let output = Command::new("bash")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$@\"", "bash"])
        .arg(program("pottery-studio"))
        .args(made)
        .args(["--record-session", text(&session)])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("not everything was kept (the end of the recording)"), "{said}");
    assert!(session.exists(), "what was recorded stays");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn start_that_comes_to_nothing_leaves_no_recordings() {
    let folder = folder("no-start");
    let (out, stroke, session) = (folder.join("out"), folder.join("r.csv"), folder.join("r.session"));
    let made = ["--headless", "--potters", "1", "--seconds", "1", "--out", text(&out)];
    let made = [&made[..], &["--record", text(&stroke), "--record-session", text(&session)]].concat();
    let taken = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    for start in [["--listen", &address], ["--stroke", "no-such-file.csv"]] {
        sentence(&studio(&[&made[..], &start].concat()));
        assert!(!stroke.exists() && !session.exists(), "{start:?}: {:?}", names(&folder));
    }
    assert_success(&studio(&made));
    assert!(session.exists());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn bad_network_is_felt_and_the_clay_stays_the_same() {
    let folder = folder("network");
    let session = ["--headless", "--potters", "1", "--seconds", "3", "--network", "intercontinental"];
    let output = studio(&[&session[..], &["--out", text(&folder)]].concat());
    assert_success(&output);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("intercontinental: 110.0 to 125.0 ms each way, 0.9 % lost, 10 Mbit/s"), "{said}");
    let figures = fs::read_to_string(folder.join("session.json")).unwrap();
    let figures: serde_json::Value = serde_json::from_str(&figures).unwrap();
    let round_trip_ms = figures["network"]["rtt_ms"]["p50"].as_f64().unwrap();
    assert!(round_trip_ms >= 220.0, "{round_trip_ms} ms there and back");
    let refused = sentence_of_usage(&studio(&["--headless", "--network", "moon"]));
    assert!(refused.contains("lan, school-wifi, home, intercontinental, awful"), "{refused}");
    fs::remove_dir_all(folder).unwrap();
}

/// What a person reads when an argument is not understood.
fn sentence_of_usage(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn recorded_session_is_replayed_to_the_same_pot() {
    let folder = folder("session");
    let (session, worked, replayed) = (folder.join("s.session"), folder.join("worked"), folder.join("replayed"));
    let made = ["--headless", "--potters", "2", "--seconds", "2.5", "--out", text(&worked)];
    assert_success(&studio(&[&made[..], &["--record-session", text(&session)]].concat()));
    let replay = ["replay", text(&session), "--headless", "--out", text(&replayed)];
    let output = studio(&replay);
    assert_success(&output);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("agreement  all of"), "{said}");
    let pots = [&worked, &replayed].map(|folder| PotFile::read(&folder.join("pot.pot")).unwrap());
    assert!(pots[0].pot() == pots[1].pot(), "radius by radius");
    // before anybody came
    assert_success(&studio(&[&replay[..], &["--at", "0"]].concat()));
    assert!(PotFile::read(&replayed.join("pot.pot")).unwrap().pot() != pots[0].pot());
    // as it lies when the program is killed
    let bytes = fs::read(&session).unwrap();
    fs::write(&session, &bytes[..bytes.len() - 60]).unwrap();
    let output = studio(&replay);
    assert_success(&output);
    assert!(String::from_utf8(output.stderr).unwrap().contains("cut short"));
    let mut bent = bytes;
    bent[200] ^= 1;
    fs::write(&session, &bent).unwrap();
    let text_of = sentence(&studio(&replay));
    assert!(text_of.contains("take another copy"), "{text_of}");
    let there = sentence(&studio(&[&made[..], &["--record-session", text(&session)]].concat()));
    assert!(there.contains("does not exist yet"), "{there}");
    fs::remove_dir_all(folder).unwrap();
}
