//! What the programs say of flags and settings that make no sense: one sentence, which names them and what would be taken.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::Command;

use pottery_shared::clay::{GridShape, PotSpec};
use pottery_shared::units::Metres;
use pottery_tests::programs::{folder, program};

/// The one line in which a program says why it does not run.
fn refusal(name: &str, arguments: &[&str]) -> String {
    let output = Command::new(program(name))
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success(), "{name} {arguments:?} runs: {said}");
    assert_eq!(said.lines().count(), 1, "{name} {arguments:?}: {said}");
    assert!(said.starts_with(&format!("{name}: ")), "{said}");
    said
}

#[test]
fn flag_out_of_its_range_is_refused_in_one_sentence_with_the_range() {
    let cases: &[(&str, &[&str], &[&str])] = &[
        ("pottery-studio", &["--smallest-tool-mm", "0.001"], &["--smallest-tool-mm", "from 0.5 to 40"]),
        ("pottery-studio", &["--smallest-tool-mm", "0"], &["--smallest-tool-mm", "from 0.5 to 40"]),
        ("pottery-studio", &["--smallest-tool-mm", "1e9"], &["--smallest-tool-mm", "from 0.5 to 40"]),
        (
            "pottery-studio",
            &["--smallest-tool-mm", "12", "--finest-view-mm", "1e9"],
            &["--finest-view-mm", "from 0.01 to 10"],
        ),
        ("pottery-studio", &["--potters", "-1"], &["'-1'", "--potters", "from 1 to 16"]),
        ("pottery-studio", &["--potters", "99"], &["--potters", "from 1 to 16"]),
        ("pottery-studio", &["--seconds", "nan"], &["--seconds", "from 0.5 to 86400"]),
        ("pottery-studio", &["join", "localhost", "--wheel", "-1"], &["--wheel", "from 1 to 1024"]),
        ("pottery-studio", &["replay", "monday.session", "--at", "-1"], &["--at", "from 0 to"]),
        ("pottery-studio", &["haptics", "--bench", "--seconds", "-1"], &["--seconds", "from 0.5 to 86400"]),
        ("pottery-studio", &["replay", "monday.session", "--out", "x"], &["--headless"]),
        ("pottery-studio", &["--listen", "foo"], &["'foo'", "--listen", "such as 127.0.0.1:5000"]),
        ("pottery-studio", &["join", "http://127.0.0.1:5001/"], &["http://127.0.0.1:5001/", "192.168.1.20:4747"]),
        (
            "pottery-studio",
            &["--headless", "--potters", "1", "--stroke", "a.csv", "--stroke", "b.csv"],
            &["2 strokes are too many for 1 potter;", "--potters"],
        ),
        ("pottery-studio", &["--method", "best"], &["--method", "original, improved, plastic"]),
        ("pottery-studio", &["--swift"], &["--swift"]),
        (
            "pottery-studio",
            &["--device", "replay:file=/nowhere/lead.csv"],
            &["--device", "/nowhere/lead.csv", "there is no such file or folder"],
        ),
        ("pottery-studio", &["--headless", "--tool", "rib", "--tool-radius", "8"], &["--tool-radius", "--tool sphere"]),
        ("pottery-server", &["--smallest-tool-mm", "0.001"], &["--smallest-tool-mm", "from 0.5 to 40"]),
        ("pottery-server", &["--smallest-tool-mm", "-1"], &["--smallest-tool-mm", "from 0.5 to 40"]),
        ("pottery-server", &["--smallest-tool-mm", "0.5"], &["smallest_tool_mm = 0.5", "from 0.6 to 40"]),
        (
            "pottery-server",
            &["--smallest-tool-mm", "12", "--finest-view-mm", "0"],
            &["--finest-view-mm", "from 0.01 to 10"],
        ),
        ("pottery-server", &["--wheels", "-1"], &["'-1'", "--wheels", "from 1 to 1024"]),
        ("pottery-server", &["--people", "many"], &["--people", "from 1 to 4096"]),
        ("pottery-server", &["--figures", "0"], &["--figures", "from 1 to 86400"]),
        ("pottery-server", &["--code-hours", "-1"], &["--code-hours", "from 0.01 to 10000"]),
        ("load-test", &["--spawn", "--wheels", "-1"], &["'-1'", "--wheels", "from 1 to 1024"]),
        ("load-test", &["--spawn", "--threads", "65"], &["--threads", "from 1 to 64"]),
        ("load-test", &["knee", "--spawn", "--from", "-1"], &["--from", "from 1 to 4096"]),
        ("load-test", &["soak", "--virtual-s", "0"], &["--virtual-s", "from 1 to 86400"]),
        ("load-test", &["--spawn", "--ramp", "-1"], &["'-1'", "--ramp", "from 0 to 3600"]),
        (
            "accuracy-chart",
            &["dent", "--method", "ours", "--out", "x", "--grid=-1x400"],
            &["--grid", "8 to 4096 columns"],
        ),
    ];
    for (name, arguments, words) in cases {
        let said = refusal(name, arguments);
        for word in *words {
            assert!(said.contains(word), "{name} {arguments:?} lacks {word}: {said}");
        }
    }
}

#[test]
fn setting_out_of_its_range_is_refused_with_its_line_and_its_range() {
    let folder = folder("written");
    let file = folder.join("class.toml");
    let path = file.to_str().unwrap();
    for (text, words) in [
        ("wheels = 2\ncolumns = -5\n", ["line 2, columns = -5: ", "a whole number from 8 to 4096"]),
        ("rows = nan\n", ["line 1, rows = nan: ", "a whole number from 4 to 4096"]),
        ("rows = 4097\n", ["line 1, rows = 4097: ", "a whole number from 4 to 4096"]),
        ("wheels = 2.5\n", ["line 1, wheels = 2.5: ", "a whole number from 1 to 1024"]),
        ("people_max = \"many\"\n", ["line 1, people_max = \"many\": ", "a whole number from 1 to 4096"]),
        ("[arrivals]\nburst = -1\n", ["line 2, burst = -1: ", "a whole number from 1 to 1000000000"]),
        ("[input]\nrequests_per_s = 0\n", ["line 2, requests_per_s = 0: ", "a whole number from 1 to 1000000000"]),
        ("radius_mm = 1e9\n", ["radius_mm = 1000000000 cannot", "from 10 to 150"]),
        ("radius_mm = \"wide\"\n", ["line 1, radius_mm = \"wide\": ", "write a number"]),
        ("height_mm = 0.1\n", ["height_mm = 0.1 cannot", "from 20 to 600"]),
        ("wall_mm = nan\n", ["wall_mm = NaN cannot", "from 1 to 30"]),
        ("wheel_rpm = 1e9\n", ["wheel_rpm = 1000000000 cannot", "choose a number from -"]),
        ("smallest_tool_mm = 1e9\n", ["smallest_tool_mm = 1000000000 cannot", "from 0.5 to 40"]),
        ("smallest_tool_mm = 1\nradius_mm = 150\nheight_mm = 600\n", ["smallest_tool_mm = 1 cannot", "from 1.5 to 40"]),
        ("smallest_tool_mm = 4\nfinest_view_mm = 1e9\n", ["finest_view_mm = 1000000000 cannot", "from 0.01 to 10"]),
        ("wheels 4\n", ["line 1, wheels 4: ", ""]),
    ] {
        fs::write(&file, text).unwrap();
        let said = refusal("pottery-server", &["--print-config", "--config", path]);
        for word in words {
            assert!(said.contains(word), "{text} lacks {word}: {said}");
        }
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn ends_of_the_ranges_that_are_told_are_taken() {
    let print = |arguments: &[&str]| {
        let printed = Command::new(program("pottery-server")).arg("--print-config").args(arguments).output().unwrap();
        assert!(printed.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&printed.stderr));
    };
    print(&["--smallest-tool-mm", "0.6"]);
    print(&["--smallest-tool-mm", "40", "--finest-view-mm", "0.01"]);
    print(&["--smallest-tool-mm", "0.5", "--finest-view-mm", "10"]);
    print(&["--code-hours", "0.01"]);
    for (columns, rows, is_taken) in [
        (8, 4, true),
        (4096, 1024, true),
        (1024, 4096, true),
        (7, 4, false),
        (8, 3, false),
        (4097, 4, false),
        (8, 4097, false),
    ] {
        assert_eq!(GridShape::new(columns, rows).is_ok(), is_taken, "{columns} x {rows}");
    }
    // an element of the largest tool's grid is as long as the longest view
    let pot = PotSpec::default();
    let [tool, view] = [(40.0, 0.01), (1.0, 10.0)].map(|(tool_mm, seen_mm)| {
        GridShape::for_tool_and_view(&pot, Metres::from_mm(tool_mm), Metres::from_mm(seen_mm)).unwrap()
    });
    assert_eq!(tool, view);
}
