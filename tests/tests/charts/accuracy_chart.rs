//! The accuracy chart from end to end, as small as it can be, and what its program refuses.
//!
//! Figures are looked at for being there and for what holds on any grid; how good they are is said by `reference.rs`.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use pottery_shared::clay::MethodKind;
use pottery_tests::chart::cases::Support;
use pottery_tests::chart::closed_forms::LAWS;
use pottery_tests::chart::entrant::{ENTRANTS, methods};
use pottery_tests::chart::extent::Extent;
use pottery_tests::chart::machine::Machine;
use pottery_tests::chart::progress::Progress;
use pottery_tests::chart::{self, Figures};
use pottery_tests::programs::program;

/// The smallest chart, measured and drawn once.
struct Chart {
    figures: Figures,
    files: Vec<(&'static str, Vec<u8>)>,
    /// Number of every piece that was told of, and of all that were expected.
    pieces: Vec<(u32, u32)>,
}

static CHART: LazyLock<Chart> = LazyLock::new(|| {
    let machine = Machine::this(Some("2026-08-21".to_owned()));
    let mut pieces = Vec::new();
    let mut progress = Progress::new(|piece| pieces.push((piece.done, piece.of)));
    let figures = chart::measure(Extent::smallest(), machine, &mut progress).unwrap();
    drop(progress);
    let files = chart::files(&figures).unwrap();
    Chart { figures, files, pieces }
});

impl Chart {
    fn named(&self, ending: &str) -> impl Iterator<Item = &'static str> {
        self.files.iter().map(|(name, _)| *name).filter(move |name| name.ends_with(ending))
    }

    fn bytes(&self, file: &str) -> &[u8] {
        &self.files.iter().find(|(name, _)| *name == file).unwrap().1
    }

    fn text(&self, file: &str) -> &str {
        std::str::from_utf8(self.bytes(file)).unwrap()
    }
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("accuracy-chart").join(name)
}

/// Names of the columns and the cells of every row.
fn table(file: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let text = CHART.text(file);
    let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut lines = text.lines();
    let columns = cells(lines.next().unwrap());
    let rows: Vec<_> = lines.map(cells).collect();
    assert!(!rows.is_empty(), "{file} has no rows");
    assert!(rows.iter().all(|row| row.len() == columns.len()), "{file} has rows of different lengths");
    (columns, rows)
}

fn run(arguments: &[&str]) -> Output {
    Command::new(program("accuracy-chart")).args(arguments).output().unwrap()
}

/// What the program says when it refuses, which is one line.
fn refusal(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(!output.status.success(), "{arguments:?} is accepted");
    assert!(output.stdout.is_empty(), "{arguments:?} prints figures");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
    said
}

/// All that is looked at in the chart that was measured once: every test may be a process of its own, which would measure it again.
#[test]
fn the_smallest_chart_is_whole() {
    every_file_of_figures_is_a_table_with_every_method();
    every_figure_has_its_unit_in_the_name_of_its_column();
    every_error_is_a_number_that_is_not_negative();
    every_grid_is_timed_in_every_step_that_was_asked_for();
    cusps_grow_with_the_pitch();
    a_wall_with_nothing_behind_it_gives_way_at_rest_and_on_the_way();
    ours_keeps_to_every_law_that_can_be_written_down();
    progress_tells_of_every_piece_that_was_expected();
    chart_is_written_into_a_new_folder();
    every_picture_is_whole_and_shown_on_the_page();
    machine_is_stated();
}

fn every_file_of_figures_is_a_table_with_every_method() {
    for file in CHART.named(".csv") {
        let (columns, rows) = table(file);
        assert_eq!(columns[0], "method", "{file}");
        let named: BTreeSet<&str> = rows.iter().map(|row| row[0].as_str()).collect();
        // the profile is of one law
        for (row, _) in methods().filter(|(_, method)| file != "lathe.csv" || *method == MethodKind::Plastic) {
            assert!(named.contains(ENTRANTS[row].name), "{file} lacks {}", ENTRANTS[row].name);
        }
    }
}

fn every_figure_has_its_unit_in_the_name_of_its_column() {
    const UNITS: &[&str] = &[
        "mm",
        "mm3",
        "us",
        "ms",
        "mpa",
        "kpa",
        "hz",
        "rpm",
        "n",
        "percent",
        "percent_of_depth",
        "percent_of_volume_in",
        "ratio",
        "element",
        "force",
    ];
    const COUNTS: &[&str] =
        &["columns", "rows", "elements", "touched_elements", "timed_steps", "steps", "steps_to_depth", "turns"];
    for file in CHART.named(".csv") {
        let (columns, rows) = table(file);
        for (at, column) in columns.iter().enumerate() {
            let is_figure = rows.iter().any(|row| row[at].parse::<f64>().is_ok());
            let unit = UNITS.iter().any(|unit| column.ends_with(&format!("_{unit}")));
            assert!(!is_figure || unit || COUNTS.contains(&column.as_str()), "{file}: {column}");
        }
    }
}

fn every_error_is_a_number_that_is_not_negative() {
    for file in ["methods.csv", "cases.csv", "convergence.csv", "lathe.csv"] {
        let (columns, rows) = table(file);
        let errors: Vec<usize> = (0..columns.len()).filter(|at| columns[*at].contains("rms_")).collect();
        assert!(!errors.is_empty(), "{file} has no errors");
        for row in &rows {
            for &at in &errors {
                let error: f64 = row[at].parse().unwrap();
                assert!(error >= 0.0 && error.is_finite(), "{file}: {} is {error}", columns[at]);
            }
        }
    }
}

fn every_grid_is_timed_in_every_step_that_was_asked_for() {
    let extent = Extent::smallest();
    for (row, _) in methods() {
        let own: Vec<_> = CHART.figures.methods.iter().filter(|figures| figures.row == row).collect();
        assert_eq!(own.iter().map(|figures| figures.grid).collect::<Vec<_>>(), extent.grids);
        for figures in own {
            let times = figures.times.unwrap();
            assert_eq!(times.steps, extent.timed_steps);
            assert!(times.least_us <= times.p50_us && times.p50_us <= times.p99_us && times.p99_us <= times.most_us);
        }
    }
}

fn cusps_grow_with_the_pitch() {
    // but for the improved method, which digs on at every pass
    for (row, _) in methods().filter(|(_, method)| *method != MethodKind::Improved) {
        let threads = CHART.figures.helix.iter().filter(|thread| thread.row == row);
        let own: Vec<f64> = threads.map(|thread| thread.cusps).collect();
        assert!(own.len() > 1 && own.windows(2).all(|pair| pair[0] < pair[1]), "{}: {own:?}", ENTRANTS[row].name);
    }
}

fn a_wall_with_nothing_behind_it_gives_way_at_rest_and_on_the_way() {
    let own = CHART.figures.forces.iter().filter(|force| ENTRANTS[force.row].name == "ours");
    let [backed, hollow] =
        [Support::Backed, Support::Hollow].map(|support| own.clone().rfind(|force| force.support == support).unwrap());
    assert!(backed.travel_mm == 2.0 && hollow.travel_mm == 2.0, "{backed:?}, {hollow:?}");
    // finite elements have a fifth of the force there
    assert!(hollow.resting_n < 0.5 * backed.resting_n, "{hollow:?}, {backed:?}");
    assert!(hollow.moving_n.unwrap() < 0.5 * backed.moving_n.unwrap(), "{hollow:?}, {backed:?}");
}

fn ours_keeps_to_every_law_that_can_be_written_down() {
    let own: Vec<_> = CHART.figures.closed_forms.iter().filter(|form| ENTRANTS[form.row].name == "ours").collect();
    assert_eq!(own.len(), LAWS.len());
    for form in own {
        let [least, most] = form.law.expected;
        assert!((least..=most).contains(&form.ratio), "{form:?}");
    }
}

fn progress_tells_of_every_piece_that_was_expected() {
    let expected = CHART.pieces[0].1;
    assert_eq!(CHART.pieces, (0..expected).map(|done| (done, expected)).collect::<Vec<_>>());
}

fn chart_is_written_into_a_new_folder() {
    let folder = folder("written");
    let files = chart::write(&CHART.figures, &folder).unwrap();
    assert_eq!(files.len(), CHART.files.len());
    for (name, bytes) in &CHART.files {
        assert_eq!(std::fs::read(folder.join(name)).unwrap(), *bytes, "{name}");
    }
}

fn every_picture_is_whole_and_shown_on_the_page() {
    let page = CHART.text("index.md");
    for file in CHART.named(".png") {
        assert!(page.contains(&format!("]({file})")), "index.md does not show {file}");
        let decoder = png::Decoder::new(std::io::Cursor::new(CHART.bytes(file)));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (1400, 900), "{file}");
        // a sheet with axes and words on it is neither empty nor full
        let dark = pixels.chunks_exact(3).filter(|pixel| pixel.iter().all(|part| *part < 128)).count();
        let share = dark as f64 / (1400.0 * 900.0);
        assert!((0.002..0.3).contains(&share), "{file}: {share} of it is dark");
    }
    for link in page.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
        assert!(CHART.named("").any(|name| name == link), "index.md names {link}, which was not written");
    }
}

fn machine_is_stated() {
    let text = CHART.text("machine.json");
    let value: serde_json::Value = serde_json::from_str(text).unwrap();
    assert!(value["rustc"].as_str().unwrap().starts_with("rustc 1."), "{text}");
    assert!(value["cores"].as_u64().unwrap() > 0, "{text}");
    assert_eq!(value["date"], "2026-08-21", "{text}");
    assert!(!value["cpu"].as_str().unwrap().is_empty(), "{text}");
}

#[test]
fn press_that_makes_no_sense_is_refused_with_field_and_range() {
    let file = folder("refused.csv");
    let cases: &[(&[&str], &[&str])] = &[
        (&["--grid", "0x0"], &["grid", "0 columns x 0 rows", "at least 8 x 4"]),
        (&["--grid", "31623x31623"], &["grid", "at most", "elements"]),
        (&["--grid", "many"], &["grid", "360x400"]),
        (&["--grid=-1x400"], &["grid", "8 to 4096 columns, 4 to 4096 rows and at most 4194304 elements"]),
        (&["--grid", "NaNxNaN"], &["grid", "8 to 4096 columns, 4 to 4096 rows and at most 4194304 elements"]),
        (&["--depth-mm", "NaN"], &["--depth-mm", "above 0 and at most 8 mm"]),
        (&["--depth-mm", "deep"], &["--depth-mm", "write it as a number, like 2.5"]),
        (&["--depth-mm", "0"], &["--depth-mm", "above 0 and at most 8 mm"]),
        (&["--depth-mm", "inf"], &["--depth-mm", "above 0 and at most 8 mm"]),
        // the core stands there, and a hollow pot would come out on the other side
        (&["--depth-mm", "2", "--wall-mm", "1"], &["depth of 2 mm", "at most 1 mm, how thick the backed wall is"]),
        (&["--depth-mm", "59", "--support", "hollow"], &["--depth-mm", "at most 20 mm, a third of the pot's radius"]),
        (&["--depth-mm", "20.1", "--wall-mm", "30"], &["--depth-mm", "at most 20 mm, a third of the pot's radius"]),
        (
            &["--tool-radius-mm", "39", "--pot-radius-mm", "30", "--wall-mm", "5"],
            &["--tool-radius-mm", "from 0.5 to 30 mm, the pot's radius"],
        ),
        (&["--tool-radius-mm", "-3"], &["tool radius", "from 0.5 to 40 mm"]),
        (&["--tool-radius-mm", "NaN"], &["tool radius", "from 0.5 to 40 mm"]),
        // no press can be made in such clay, which once gave a pot without a dent
        (&["--yield-kpa", "-1"], &["--yield-kpa", "yield stress of -1 kPa", "from 0.3 to 1000 kPa"]),
        (&["--yield-kpa", "1e-9"], &["yield stress of 1e-9 kPa", "from 0.3 to 1000 kPa"]),
        (&["--yield-kpa", "5000"], &["yield stress of 5000 kPa", "from 0.3 to 1000 kPa"]),
        (&["--yield-kpa", "10.1", "--youngs-mpa", "0.01"], &["--yield-kpa", "from 0.3 to 10 kPa, as much as Young's"]),
        (&["--youngs-mpa", "0"], &["--youngs-mpa", "Young's modulus of 0 MPa", "from 0.01 to 100 MPa"]),
        (&["--youngs-mpa", "0.001"], &["Young's modulus of 0.001 MPa", "from 0.01 to 100 MPa"]),
        (&["--youngs-mpa", "inf"], &["Young's modulus of inf MPa", "from 0.01 to 100 MPa"]),
        (&["--height-mm", "NaN"], &["--height-mm", "from 20 to 600 mm"]),
        (&["--pot-radius-mm", "0"], &["--pot-radius-mm", "from 10 to 150 mm"]),
        (&["--wall-mm", "50"], &["--wall-mm", "from 1 to 30 mm, half of the pot's radius"]),
        (&["--finger-mm", "8"], &["needs --support hollow", "no inside"]),
        (&["--finger-mm", "8", "--support", "hollow", "--depth-mm", "7.1"], &["--depth-mm", "at most 7 mm", "finger"]),
        (
            &["--finger-mm", "8", "--support", "hollow", "--wall-mm", "1", "--depth-mm", "0.1"],
            &[
                "--wall-mm",
                "wall of 1 mm leaves nothing to press against a finger",
                "as thick as the depth and 1 mm more",
            ],
        ),
        (
            &["--finger-mm", "52.1", "--support", "hollow"],
            &["--finger-mm", "finger radius of 52.1", "from 0.5 to 40 mm"],
        ),
        (
            &["--finger-mm", "7.6", "--support", "hollow", "--pot-radius-mm", "15", "--wall-mm", "7.5"],
            &["--finger-mm", "from 0.5 to 5.5 mm, so that it fits into the pot, pressed in so far"],
        ),
        (&["--method", "improved", "--support", "hollow", "--finger-mm", "8"], &["only our method", "finger"]),
        (&["--method", "original", "--support", "hollow", "--finger-mm", "8"], &["only our method", "finger"]),
        (&["--rpm", "NaN", "--turns", "1"], &["--rpm", "above 0 and at most 3000 rpm"]),
        (&["--rpm", "1e9", "--turns", "1"], &["speed of 1e9 rpm", "above 0 and at most 3000 rpm"]),
        (&["--rpm", "-5", "--turns", "1"], &["--rpm", "above 0 and at most 3000 rpm"]),
        (&["--rpm", "60", "--turns", "0"], &["--turns", "from 0.001 to 3600, from a millisecond to an hour"]),
        // no step is as short as that
        (&["--rpm", "60", "--turns", "0.0001"], &["turns of 1e-4", "from 0.001 to 3600"]),
        (&["--rpm", "0.001", "--turns", "9"], &["--turns", "to 0.06, from a millisecond to an hour"]),
        (&["--rpm", "60", "--turns", "1e9"], &["--turns", "from 0.001 to 3600"]),
        (&["--rpm", "60", "--turns", "1", "--feed-mm-per-rev", "NaN"], &["--feed-mm-per-rev", "from -100 to 100 mm"]),
        (
            &["--rpm", "60", "--turns", "8", "--feed-mm-per-rev", "-12.6"],
            &["feed of -12.6 mm a turn", "from -12.5 to 12.5 mm a turn, so that the tool stays at the pot"],
        ),
        (&["--rpm", "60"], &["--turns"]),
        (&["--turns", "2"], &["--rpm"]),
        (&["--feed-mm-per-rev", "1"], &["--rpm"]),
        (&["--method", "best"], &["best", "--method"]),
        (&["--rpm", "60", "--turns", "1", "--profile", "1000"], &["--profile", "from 0.01 to 20 percent of the depth"]),
        (&["--profile", "1"], &["--rpm"]),
        (&["--method", "original", "--rpm", "60", "--turns", "1", "--profile"], &["only our method", "--profile"]),
    ];
    for (flags, words) in cases {
        let mut arguments = vec!["dent", "--out", file.to_str().unwrap()];
        if !flags.contains(&"--method") {
            arguments.extend(["--method", "ours"]);
        }
        arguments.extend(*flags);
        let said = refusal(&arguments);
        for word in *words {
            assert!(said.contains(word), "{flags:?}: {said}");
        }
        assert!(!file.exists(), "{flags:?} wrote a file");
    }
}

#[test]
fn bound_that_is_told_is_taken() {
    for flags in [
        &["--wall-mm", "3", "--finger-mm", "12", "--depth-mm", "2"][..],
        &["--wall-mm", "1.01", "--finger-mm", "12", "--depth-mm", "0.01"],
        // a third of 50 mm, told to the micrometre
        &["--pot-radius-mm", "50", "--depth-mm", "16.667"],
        &["--youngs-mpa", "0.07", "--yield-kpa", "70"],
    ] {
        pressed("bound.csv", &[&["--method", "ours", "--support", "hollow", "--grid", "126x68"], flags].concat());
    }
}

#[test]
fn chart_without_a_folder_or_with_wrong_flags_is_refused() {
    assert!(refusal(&[]).contains("--out"));
    assert!(refusal(&["--quick"]).contains("--out"));
    assert!(refusal(&["--out", "x", "--date", "yesterday"]).contains("2026-08-21"));
    assert!(refusal(&["--out", "x", "--date", "2026-13-01"]).contains("twelve months"));
    for (day, days) in [("2026-02-29", 28), ("2024-02-30", 29), ("2026-04-31", 30), ("2026-01-00", 31)] {
        assert!(refusal(&["--out", "x", "--date", day]).contains(&format!("that month has {days} days")), "{day}");
    }
    assert!(refusal(&["--swift"]).contains("--swift"));
    let file = folder("file-in-the-way");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(&file, "").unwrap();
    assert!(refusal(&["--out", file.join("chart").to_str().unwrap()]).contains("choose another with --out"));
}

#[test]
fn dent_is_written_for_every_element_and_printed() {
    let file = folder("dent.csv");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let out = file.to_str().unwrap();
    let output = run(&["dent", "--method", "ours", "--grid", "60x70", "--release", "--out", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    for word in ["radial force", "volume in", "volume out", "pot becomes", "a step"] {
        assert!(said.contains(word), "{said}");
    }
    let text = std::fs::read_to_string(&file).unwrap();
    assert_eq!(text.lines().next(), Some("theta_rad,z_mm,u_r_mm"));
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 60 * 70);
    assert!(rows.iter().all(|row| row.len() == 3 && row.iter().all(|figure| figure.is_finite())));
    // the tool came in 2 mm, and the clay springs back a little
    let deepest = rows.iter().map(|row| row[2]).fold(0.0, f64::min);
    assert!((-2.0..-1.0).contains(&deepest), "{deepest}");
}

/// A dent that is written and not looked at: its figures, and what is said beside them.
fn pressed(name: &str, flags: &[&str]) -> (String, String) {
    let file = folder(name);
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let mut arguments = vec!["dent", "--out", file.to_str().unwrap()];
    arguments.extend(flags);
    let output = run(&arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{flags:?}: {said}");
    (String::from_utf8(output.stdout).unwrap(), said)
}

#[test]
fn a_wall_that_lies_beyond_a_tool_is_warned_of() {
    let flags = "--method ours --support hollow --grid 126x68 --tool-radius-mm 20 --depth-mm";
    let said = |depth| pressed("beyond.csv", &flags.split(' ').chain([depth]).collect::<Vec<_>>()).1;
    assert!(said("20").contains("mm beyond the tool"), "{}", said("20"));
    assert_eq!(said("4"), "");
    // the rim of a tall one goes farther than the tool, as that of a mast
    let tall = "--method ours --support hollow --grid 360x400 --height-mm 600 --depth-mm 2";
    assert_eq!(pressed("leaning.csv", &tall.split(' ').collect::<Vec<_>>()).1, "");
}

#[test]
fn grid_that_is_too_coarse_for_the_tool_is_warned_of_with_one_that_is_not() {
    let warning = |flags: &[&str]| pressed("coarse.csv", &[&["--method", "ours", "--release"], flags].concat()).1;
    assert!(
        warning(&["--grid", "16x16"])
            .contains("at most 3 mm, a quarter of the tool's radius; give at least --grid 126x68")
    );
    assert!(warning(&["--grid", "360x8"]).contains("give at least --grid 126x68"));
    assert!(warning(&["--tool-radius-mm", "0.5", "--depth-mm", "0.1"]).contains("no grid is fine enough"));
    assert_eq!(warning(&["--grid", "126x68"]), "");
    assert!(warning(&["--depth-mm", "0.04"]).contains("elements, so that its force comes in steps; press deeper"));
    let wide = ["--pot-radius-mm", "150", "--wall-mm", "20", "--depth-mm", "1"];
    assert!(warning(&wide).contains("columns across, so that force and dent come in steps"));
    // the reference's own
    assert_eq!(warning(&["--tool-radius-mm", "8", "--wall-mm", "8", "--depth-mm", "4"]), "");
    // no element is touched, and none was timed
    let (figures, _) = pressed("missed.csv", &["--method", "original", "--grid", "8x4"]);
    assert!(figures.contains("none met any clay") && !figures.contains("NaN"), "{figures}");
}

#[test]
fn published_method_says_which_flags_make_no_difference_to_it() {
    for method in ["original", "improved"] {
        let flags =
            ["--method", method, "--grid", "126x68", "--support", "hollow", "--wall-mm", "6", "--yield-kpa", "20"];
        let (figures, said) = pressed("idle.csv", &flags);
        assert!(said.contains("--wall-mm, --yield-kpa, --support hollow makes no difference"), "{said}");
        assert!(!figures.contains("inner wall"), "{figures}");
        assert_eq!(pressed("idle.csv", &["--method", method, "--grid", "126x68"]).1, "");
    }
    let flags = ["--method", "ours", "--grid", "126x68", "--support", "hollow", "--wall-mm", "6", "--yield-kpa", "20"];
    let (figures, said) = pressed("used.csv", &flags);
    assert!(said.is_empty() && figures.contains("inner wall"), "{figures}{said}");
}

#[test]
fn figures_that_nobody_reads_end_no_program_and_a_full_disk_is_said() {
    let file = folder("unread.csv");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let dent = |to: std::process::Stdio| {
        let mut command = Command::new(program("accuracy-chart"));
        command.args(["dent", "--method", "ours", "--grid", "126x68", "--out", file.to_str().unwrap()]);
        command.stdout(to).stderr(std::process::Stdio::piped()).spawn().unwrap()
    };
    let mut closed = dent(std::process::Stdio::piped());
    drop(closed.stdout.take());
    let closed = closed.wait_with_output().unwrap();
    assert_eq!((closed.status.code(), String::from_utf8_lossy(&closed.stderr).as_ref()), (Some(0), ""));
    #[cfg(target_os = "linux")]
    {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let full = dent(full.into()).wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&full.stderr);
        assert_eq!((full.status.code(), said.lines().count()), (Some(2), 1), "{said}");
        assert!(said.contains("cannot be printed: the disk is full"), "{said}");
    }
}

#[test]
fn dent_round_a_fast_wheel_is_near_enough_as_a_profile() {
    let dent = |name: &str, profile: &[&str]| {
        let file = folder(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        let mut arguments = vec!["dent", "--method", "ours", "--grid", "180x200", "--release", "--rpm", "180"];
        arguments.extend(["--feed-mm-per-rev", "1", "--turns", "40", "--out", file.to_str().unwrap()]);
        arguments.extend(profile);
        let output = run(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(&file).unwrap();
        let displaced_mm: Vec<f64> =
            text.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
        (displaced_mm, String::from_utf8(output.stdout).unwrap())
    };
    // nothing is as near as a ten-thousandth but the grid
    let [(grid_mm, on_grid, grid_n), (profile_mm, as_profile, profile_n)] =
        [("groove.csv", "0.01"), ("groove-profile.csv", "2")].map(|(name, bound)| {
            let (displaced_mm, said) = dent(name, &["--profile", bound]);
            let force = said.lines().find_map(|line| line.strip_prefix("radial force")).unwrap();
            let force_n: f64 = force.split_whitespace().next().unwrap().parse().unwrap();
            let line = said.lines().find(|line| line.starts_with("as a profile")).expect("it says how often");
            let steps: Vec<u32> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            (displaced_mm, steps, force_n)
        });
    // only once the tool has left the dent in which it began, which is not round
    assert!(on_grid[0] == 0 && as_profile[0] > as_profile[1] / 5, "{on_grid:?} and {as_profile:?}");
    // what the tool bears while it goes round, whichever way the clay under it is advanced
    println!("{grid_n} N on the grid, {profile_n} N as a profile");
    assert!((profile_n / grid_n - 1.0).abs() < 0.05, "{grid_n} and {profile_n} N");
    // over the rows that were worked, as the bound is meant
    let worked = |&(one_mm, other_mm): &(&f64, &f64)| one_mm.abs().max(other_mm.abs()) > 0.04;
    let pairs: Vec<_> = grid_mm.iter().zip(&profile_mm).filter(worked).collect();
    let squares: f64 = pairs.iter().map(|(one_mm, other_mm)| (*one_mm - *other_mm).powi(2)).sum();
    let error = (squares / pairs.len() as f64).sqrt() / 2.0;
    assert!(pairs.len() > 180 * 5 && error < 0.02, "{error} over {} elements", pairs.len());
}
