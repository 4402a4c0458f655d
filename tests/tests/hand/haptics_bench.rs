//! `pottery-studio haptics` as a person runs it: what it says, what it writes, and what it refuses.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::{Command, Output, Stdio};

use pottery_tests::programs::{folder, program};

fn haptics(arguments: &[&str]) -> Output {
    Command::new(program("pottery-studio")).arg("haptics").args(arguments).output().unwrap()
}

fn text(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn what_the_thread_is_granted_is_said_in_a_sentence() {
    let said = text(&haptics(&[]));
    assert!(said.contains("a hand's thread has real-time priority") || said.contains("refuses real time"), "{said}");
    let said = text(&haptics(&["--ordinary"]));
    assert!(said.contains("ordinary priority, since more was not asked for, on any core"), "{said}");
}

#[test]
fn figures_that_nobody_reads_any_more_are_written_all_the_same() {
    let out = folder("haptics-unread");
    let arguments = ["haptics", "--bench", "--seconds", "1", "--out", out.to_str().unwrap()];
    let mut bench = Command::new(program("pottery-studio")).args(arguments).stdout(Stdio::piped()).spawn().unwrap();
    drop(bench.stdout.take());
    let status = bench.wait().unwrap();
    assert!(status.success(), "{status}");
    for file in ["haptics.csv", "haptics.svg"] {
        assert!(fs::metadata(out.join(file)).is_ok_and(|about| about.len() > 0), "{file}");
    }
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_measured_hand_leaves_figures_a_table_and_a_picture_that_agree() {
    let out = folder("haptics");
    let said = text(&haptics(&["--bench", "--server", "--seconds", "1.5", "--out", out.to_str().unwrap()]));
    for figure in ["beside     a server", "thread ", "ticks ", "late ", "period     p50", "work       p50", "contact "]
        .into_iter()
        .chain(["machine    a loop with nothing to do is late in"])
    {
        assert!(said.contains(figure), "{figure}: {said}");
    }
    let ticks: u64 = said.split("ticks").nth(1).unwrap().trim().split(',').next().unwrap().parse().unwrap();
    assert!(ticks > 100, "{said}");

    let table = fs::read_to_string(out.join("haptics.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("from_us,to_us,periods,works"));
    let (mut periods, mut works, mut end) = (0, 0, "0".to_owned());
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[0], end, "{line}");
        end = fields[1].to_owned();
        periods += fields[2].parse::<u64>().unwrap();
        works += fields[3].parse::<u64>().unwrap();
    }
    // the first tick has none before it
    assert_eq!((periods, works, end.as_str()), (ticks - 1, ticks, "inf"));

    let picture = fs::read_to_string(out.join("haptics.svg")).unwrap();
    assert!(picture.contains(&format!("{ticks} ticks beside a server")) && picture.ends_with("</svg>\n"), "{picture}");
    // one bar for each row that has anything in it
    let bars = picture.matches("fill-opacity").count();
    let filled = table.lines().skip(1).flat_map(|line| line.split(',').skip(2)).filter(|count| *count != "0").count();
    assert_eq!(bars, filled);
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn what_cannot_be_measured_is_refused_in_a_sentence() {
    let out = folder("no-haptics");
    let file = out.join("file");
    fs::write(&file, "").unwrap();
    for (arguments, said) in [
        (&["--pin-core", "100000"][..], "core 100000 is not among those that this program may use"),
        (&["--pin-core", "first"], "counted from 0"),
        (&["--bench", "--seconds", "0"], "0.5"),
        (&["--seconds", "5"], "--bench"),
        (&["--renderer"], "--bench"),
        (&["--bench", "--out", file.to_str().unwrap()], "--out"),
    ] {
        let output = haptics(arguments);
        let sentence = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && sentence.contains(said), "{arguments:?}: {sentence}");
        assert!(!sentence.contains("panicked"), "{sentence}");
    }
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn help_tells_how_to_read_the_figures() {
    let said = text(&haptics(&["--help"]));
    for word in ["--bench", "--server", "--renderer", "--pin-core", "late", "0.1 %", "haptics.csv"] {
        assert!(said.contains(word), "{word}: {said}");
    }
}
