//! The programs as a newcomer runs them: command lines, files, windows and sentences.
//!
//! Runs the real binaries; the window is real too, on a virtual display.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::pot_file::PotFile;
use pottery_client::stroke::Stroke;
use pottery_shared::clay::{Conditions, Pot, PotSpec};
use pottery_shared::tool::{Shape, Sphere, Tool};
use pottery_shared::units::{Metres, Tick};
use pottery_tests::display::{Display, SIZE};
use pottery_tests::programs::{folder, program};

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

fn headless(out: &Path, arguments: &[&str]) -> Output {
    Command::new(program("pottery-studio"))
        .arg("--headless")
        .arg("--out")
        .arg(out)
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap()
}

/// What a person reads, when the run failed as it should.
fn sentence(output: &Output) -> String {
    assert!(!output.status.success(), "it was meant to fail");
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(!text.contains("panicked"), "{text}");
    let said = text.lines().last().unwrap();
    let twice = |(begin, sign): &(usize, &str)| said[..*begin].contains(said[begin + sign.len()..].trim_end());
    assert!(!said.match_indices(": ").any(|sign| twice(&sign)), "{text}");
    text
}

fn session(out: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(out.join("session.json")).unwrap()).unwrap()
}

#[test]
fn scripted_potters_leave_a_picture_a_solid_and_figures_that_agree() {
    let out = folder("headless");
    let output = headless(&out, &["--potters", "2", "--seconds", "2.5"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    let session = session(&out);
    assert_eq!(session["schema"], 1);
    assert_eq!(session["elements"], 144_000);
    assert_eq!(session["potters"], 2);
    let throwing = serde_json::json!({"wetness": 0.27, "yield_kpa": 40.0, "youngs_mpa": 2.0, "viscosity_ms": 119.5});
    assert_eq!(session["clay"], throwing);
    let digests = session["digest"]["clients"].as_array().unwrap();
    assert_eq!(digests.len(), 2);
    assert!(digests.iter().all(|digest| *digest == session["digest"]["server"]), "{session}");
    assert!(session["pressed_volume_mm3"].as_f64().unwrap() > 100.0, "{session}");
    assert!(session["haptic"]["ticks"].as_u64().unwrap() > 2_000, "{session}");
    assert!(session["haptic"]["force_n"]["max"].as_f64().unwrap() > 0.01, "{session}");
    for key in ["p50", "p99", "p999", "max"] {
        assert!(session["haptic"]["period_us"][key].is_number() && session["haptic"]["step_us"][key].is_number());
    }
    for key in ["down_bytes_per_s_per_client", "up_bytes_per_s_per_client"] {
        assert!(session["network"][key].as_f64().unwrap() > 100.0, "{session}");
    }
    assert!(session["prediction_error_mm"]["max"].is_number() && session["network"]["rtt_ms"]["p50"].is_number());

    let solid = stl_io::read_stl(&mut fs::File::open(out.join("pot.stl")).unwrap()).unwrap();
    solid.validate().expect("every edge has two triangles");

    let decoder = png::Decoder::new(BufReader::new(fs::File::open(out.join("pot.png")).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let picture = reader.next_frame(&mut pixels).unwrap();
    let colours = picture.color_type.samples();
    let is_clay = |pixel: &[u8]| i32::from(pixel[0]) - i32::from(pixel[2]) > 40;
    let clay = pixels.chunks_exact(colours).filter(|pixel| is_clay(pixel)).count();
    let share = clay as f64 / f64::from(picture.width * picture.height);
    assert!((0.05..0.6).contains(&share), "clay covers {share:.2} of the picture");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_recorded_stroke_can_be_replayed() {
    let out = folder("replay");
    let recording = out.join("mine.csv");
    let file = recording.to_str().unwrap();
    let first = headless(&out, &["--potters", "1", "--seconds", "2", "--record", file]);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let pressed = session(&out)["pressed_volume_mm3"].as_f64().unwrap();
    // a machine with other things to do plays on for longer than two seconds before it ends
    let whole = format!("{:.1}", Stroke::read(&recording).unwrap().end() + 0.5);
    let second = headless(&out, &["--potters", "1", "--seconds", &whole, "--stroke", file]);
    assert!(second.status.success(), "{}", String::from_utf8_lossy(&second.stderr));
    let again = session(&out)["pressed_volume_mm3"].as_f64().unwrap();
    // the wheel stands at another angle
    assert!(pressed > 100.0 && (again / pressed - 1.0).abs() < 0.3, "{pressed} and {again} mm³");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_simulated_hand_is_pushed_back_and_the_clients_agree() {
    let out = folder("hand");
    let output = headless(
        &out,
        &["--potters", "1", "--seconds", "2", "--hand", "simulated", "--method", "original", "--clay", "soft"],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(session(&out)["clay"]["wetness"], 0.45);
    assert!(session(&out)["pressed_volume_mm3"].as_f64().unwrap() > 10.0);
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_grid_follows_the_smallest_tool_and_the_finest_viewer() {
    let out = folder("finest");
    let output =
        headless(&out, &["--potters", "2", "--seconds", "2", "--smallest-tool-mm", "12", "--tool-radius", "12"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // elements of 3 mm on 377 mm round and 200 mm high
    assert_eq!(session(&out)["elements"], 126 * 68);
    assert!(session(&out)["pressed_volume_mm3"].as_f64().unwrap() > 10.0, "{}", session(&out));
    let shape = PotFile::read(&out.join("pot.pot")).unwrap().pot().spec().shape;
    assert_eq!((shape.columns(), shape.rows()), (126, 68));
    fs::remove_dir_all(&out).unwrap();
    let refused = sentence(&headless(&out, &["--smallest-tool-mm", "0.5"]));
    assert!(
        refused.contains("smallest_tool_mm = 0.5 cannot be used") && refused.contains("from 0.6 to 40"),
        "{refused}"
    );

    let server = |arguments: &[&str]| {
        let printed = Command::new(program("pottery-server")).arg("--print-config").args(arguments).output().unwrap();
        let settings: toml::Table = String::from_utf8(printed.stdout).unwrap().parse().unwrap();
        ["columns", "rows"].map(|key| settings[key].as_integer().unwrap())
    };
    assert_eq!(server(&["--smallest-tool-mm", "4"]), [377, 201]);
    assert_eq!(server(&["--smallest-tool-mm", "4", "--finest-view-mm", "2"]), [189, 101]);
    // 200 mm wide and 100 mm high
    assert_eq!(server(&["--smallest-tool-mm", "12", "--form", "bowl"]), [210, 35]);
}

#[test]
fn without_a_display_it_works_headless_and_says_so() {
    let out = folder("no-display");
    let output = Command::new(program("pottery-studio"))
        .args(["--potters", "1", "--seconds", "1", "--out"])
        .arg(&out)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && text.contains("headless"), "{text}");
    assert!(out.join("session.json").exists());
    fs::remove_dir_all(out).unwrap();
}

/// Whether a program takes a signal of that number itself, as far as the system says so.
#[cfg(unix)]
fn catches(program: &Child, number: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.is_none_or(|caught| u64::from_str_radix(caught.trim(), 16).unwrap() & (1 << (number - 1)) != 0)
}

#[cfg(unix)]
#[test]
fn an_interrupted_session_writes_what_was_made() {
    for (signal, number) in [("-INT", 2), ("-TERM", 15)] {
        let out = folder("interrupted");
        let mut studio = Command::new(program("pottery-studio"))
            .args(["--headless", "--potters", "1", "--seconds", "3600", "--out"])
            .arg(&out)
            .stderr(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs(2));
        let deadline = Instant::now() + PATIENCE;
        while !catches(&studio, number) {
            assert!(Instant::now() < deadline, "{signal} is not waited for");
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(Command::new("kill").args([signal, &studio.id().to_string()]).status().unwrap().success());
        assert!(wait(&mut studio, Duration::from_secs(30)).success(), "{signal}");
        assert!(out.join("pot.stl").exists(), "{signal}");
        let seconds = session(&out)["seconds"].as_f64().unwrap();
        assert!((0.0..60.0).contains(&seconds), "{signal}: {seconds} s were worked");
        fs::remove_dir_all(out).unwrap();
    }
}

#[test]
fn a_bad_stroke_names_its_line() {
    let out = folder("bad-stroke");
    let file = out.join("bad.csv");
    fs::write(&file, "t_s,x_mm,y_mm,z_mm\n0,90,0,50\n0.1,oops,0,50\n").unwrap();
    let text = sentence(&headless(&out, &["--stroke", file.to_str().unwrap()]));
    assert!(text.contains("line 3") && text.contains("bad.csv"), "{text}");
    let text = sentence(&headless(&out, &["--stroke", "no-such-file.csv"]));
    assert!(text.contains("no-such-file.csv"), "{text}");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_recording_that_is_there_already_is_kept() {
    let out = folder("recorded");
    let file = out.join("mine.csv");
    fs::write(&file, "precious").unwrap();
    let text = sentence(&headless(&out, &["--seconds", "86400", "--record", file.to_str().unwrap()]));
    assert!(text.contains("mine.csv already"), "{text}");
    assert_eq!(fs::read(&file).unwrap(), b"precious");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_folder_that_cannot_be_written_is_said_before_the_work() {
    let out = folder("not-a-folder");
    let file = out.join("file");
    fs::write(&file, "").unwrap();
    // if it worked first, it would work for a day
    let text = sentence(&headless(&file, &["--seconds", "86400"]));
    assert!(text.contains("--out"), "{text}");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn without_a_graphics_driver_the_other_files_are_written_and_the_package_is_named() {
    let out = folder("no-driver");
    let output = Command::new(program("pottery-studio"))
        .args(["--headless", "--potters", "1", "--seconds", "1", "--out"])
        .arg(&out)
        .env_remove("DISPLAY")
        .env("WGPU_BACKEND", "vulkan")
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{text}");
    assert!(text.contains("mesa-vulkan-drivers"), "{text}");
    assert!(out.join("pot.stl").exists() && out.join("session.json").exists() && !out.join("pot.png").exists());
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_port_in_use_is_one_sentence() {
    let taken = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let out = folder("port");
    let text = sentence(&headless(&out, &["--listen", &address]));
    assert!(text.contains(&address) && text.contains("--listen"), "{text}");
    let server = Command::new(program("pottery-server")).args(["--listen", &address]).output().unwrap();
    assert!(sentence(&server).contains(&address));
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn settings_that_make_no_sense_are_refused_with_their_range() {
    let out = folder("settings");
    let server =
        |arguments: &[&str]| sentence(&Command::new(program("pottery-server")).args(arguments).output().unwrap());
    assert!(server(&["--wheels", "0"]).contains("wheels"), "no wheels");
    assert!(server(&["--code", "CODE"]).contains("8 or 24"), "short code");
    let config = out.join("server.toml");
    for (text, said) in [
        ("columns = 0\n", "from 8 to 4096"),
        ("columns = 4000\nrows = 4000\n", "at most"),
        ("radius_mm = nan\n", "radius"),
        ("wheel_rpm = 1e9\n", "rpm"),
        ("method = \"magic\"\n", "magic"),
        ("wheel = 3\n", "did you mean 'wheels'?"),
        ("lobby = \"yes\"\n", "write true or false"),
        ("input = 3\n", "write it as a table"),
        ("listen = \"x\"\n", "such as 127.0.0.1:5000"),
        ("listen = 4747\n", "such as 127.0.0.1:5000"),
        ("clay = \"mud\"\n", "stiff, throwing, soft or slip"),
        ("wetness = 1.5\n", "from 0 to 1"),
        ("clay = \"soft\"\nwetness = 0.5\n", "leave one of them out"),
        ("form = \"vase\"\n", "cylinder, bowl, bottle or ball"),
        ("form = \"bowl\"\nheight_mm = 90\n", "leave 'height_mm'"),
        ("smallest_tool_mm = 12\ncolumns = 360\n", "leave 'columns' and 'rows' out"),
        ("smallest_tool_mm = 0\n", "from 0.5 to 40"),
        ("smallest_tool_mm = 0.5\nfinest_view_mm = 0.02\n", "elements"),
        ("finest_view_mm = 1\n", "give 'smallest_tool_mm' as well"),
    ] {
        fs::write(&config, text).unwrap();
        let sentence = server(&["--config", config.to_str().unwrap()]);
        assert!(sentence.contains(said), "{text}: {sentence}");
    }
    assert!(server(&["--config", "no-such.toml"]).contains("no-such.toml"));
    assert!(server(&["--clay", "mud"]).contains("stiff, throwing, soft or slip"));
    assert!(server(&["--form", "vase"]).contains("cylinder, bowl, bottle or ball"));
    assert!(server(&["--wetness", "-0.5"]).contains("from 0 to 1"));
    assert!(server(&["--wetness", "0.5", "--clay", "soft"]).contains("--clay"));
    assert!(sentence(&headless(&out, &["--seconds=0"])).contains("0.5"));
    for (arguments, said) in [
        (&["--clay", "mud"][..], "slip"),
        (&["--wetness", "1.5"], "from 0 to 1"),
        (&["--wetness", "-0.5"], "from 0 to 1"),
        (&["--wetness", "nan"], "from 0 to 1"),
        (&["--wetness", "damp"], "a number from 0.0 to 1.0"),
        (&["--clay", "soft", "--wetness", "0.5"], "--wetness"),
    ] {
        let sentence = sentence(&headless(&out, arguments));
        assert!(sentence.contains(said), "{arguments:?}: {sentence}");
    }
    fs::remove_dir_all(out).unwrap();
}

#[cfg(unix)]
#[test]
fn the_server_ends_well_on_a_signal() {
    for signal in ["-TERM", "-INT"] {
        let mut server = Command::new(program("pottery-server"))
            .args(["--listen", "127.0.0.1:0", "--wheels", "2", "--code", "K7QM-3XPD"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(server.stdout.take().unwrap()).lines();
        assert!(lines.next().unwrap().unwrap().contains("127.0.0.1:"));
        assert!(lines.next().unwrap().unwrap().contains("K7QM-3XPD-"));
        assert!(Command::new("kill").args([signal, &server.id().to_string()]).status().unwrap().success());
        let status = wait(&mut server, Duration::from_secs(5));
        assert!(status.success(), "{signal}: {status}");
    }
}

fn wait(child: &mut Child, patience: Duration) -> std::process::ExitStatus {
    let deadline = Instant::now() + patience;
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if Instant::now() > deadline {
            child.kill().unwrap();
            panic!("the program did not end within {patience:?}");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until a pot is seen between each two columns of the display: what a window is told before its first picture, it takes in at once.
fn until_drawn(display: &Display, windows: &[(usize, usize)]) {
    let deadline = Instant::now() + PATIENCE;
    let clay = |pixels: &[u8], (from, to): (usize, usize)| {
        let columns = pixels.chunks_exact(SIZE.0 * 3).flat_map(|row| row[from * 3..to * 3].chunks_exact(3));
        columns.filter(|pixel| i32::from(pixel[0]) > i32::from(pixel[2]) + 24).count()
    };
    loop {
        let pixels = display.pixels();
        let seen: Vec<_> = windows.iter().map(|&columns| clay(&pixels, columns)).collect();
        if seen.iter().all(|clay| *clay > 5000) {
            return;
        }
        assert!(Instant::now() < deadline, "no pot is drawn: {seen:?} pixels of clay");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn text_of(mut stream: impl Read) -> String {
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    text
}

#[test]
fn two_windows_share_a_pot_that_the_mouse_presses() {
    let out = folder("window");
    let recording = out.join("mine.csv");
    let display = Display::new();
    let mut host = display.studio(&["--listen", "127.0.0.1:0", "--record", recording.to_str().unwrap()]);
    let mut lines = BufReader::new(host.stdout.take().unwrap()).lines();
    let invitation = lines.next().unwrap().unwrap();
    let join: Vec<&str> = invitation.split_once("pottery-studio ").unwrap().1.split(' ').collect();
    let host_window = display.window(&[]);
    let mut guest = display.studio(&join);
    let guest_window = display.window(std::slice::from_ref(&host_window));
    for (window, x) in [(&host_window, "0"), (&guest_window, "500")] {
        display.run("xdotool", &["windowsize", "--sync", window, "500", "700"]);
        display.run("xdotool", &["windowmove", "--sync", window, x, "0"]);
    }
    display.run("xdotool", &["windowfocus", &host_window, "mousemove", "250", "20"]);
    until_drawn(&display, &[(0, 500), (500, 1000)]);
    // how many pixels of the two pots at the tool's height are other than in that look
    let changed = |before: &[u8], now: &[u8]| {
        [(150, 350), (650, 850)].map(|(from, to)| {
            let places = (330..430).flat_map(|y| (from..to).map(move |x| (y * 1000 + x) * 3));
            places.filter(|&at| before[at].abs_diff(now[at]) > 24).count()
        })
    };
    // on a wheel that stands, since what was thrown by hand is not quite round: what a look shows is then what every look shows
    display.run("xdotool", &["key", "space"]);
    let patience = Duration::from_secs(90);
    let (mut before, deadline) = (display.pixels(), Instant::now() + patience);
    loop {
        std::thread::sleep(Duration::from_secs(1));
        let later = display.pixels();
        let apart = changed(&before, &later);
        if apart == [0; 2] {
            break;
        }
        assert!(
            Instant::now() < deadline,
            "{apart:?} pixels of the two pots change though the wheel stands and nobody presses"
        );
        before = later;
    }
    // drawn over the middle of the host's pot, until the guest sees as well that something is there
    display.run("xdotool", &["mousemove", "215", "380"]);
    std::thread::sleep(Duration::from_millis(700));
    display.run("xdotool", &["mousedown", "1"]);
    for x in (215..=285).step_by(5) {
        display.run("xdotool", &["mousemove", &x.to_string(), "380"]);
        std::thread::sleep(Duration::from_millis(200));
    }
    let deadline = Instant::now() + patience;
    while changed(&before, &display.pixels()).iter().any(|pressed| *pressed <= 300) {
        assert!(Instant::now() < deadline, "the host holds its tool against the pot, and nothing changes");
        std::thread::sleep(Duration::from_millis(200));
    }
    display.run("xdotool", &["mouseup", "1", "mousemove", "250", "20"]);
    std::thread::sleep(Duration::from_millis(1500));
    // the guest saw the groove that the host drew: it stays when the tool is gone
    let pressed = changed(&before, &display.pixels());
    assert!(pressed.iter().all(|pressed| *pressed > 300), "{pressed:?} pixels of the two pots changed");
    display.run("xdotool", &["windowfocus", &host_window, "key", "ctrl+z"]);
    // and both that it was undone: the clay is what it was
    let deadline = Instant::now() + patience;
    let left = loop {
        let left = changed(&before, &display.pixels());
        if left.iter().zip(pressed).all(|(left, pressed)| *left <= pressed / 50) {
            break left;
        }
        assert!(Instant::now() < deadline, "{left:?} of {pressed:?} pixels of the two pots are still other");
        std::thread::sleep(Duration::from_millis(200));
    };
    println!("{pressed:?} pixels change when it is pressed, {left:?} are left after undoing");
    // one key does not end the studio for who is here beside the host
    display.run("xdotool", &["windowfocus", &host_window, "key", "Escape"]);
    std::thread::sleep(Duration::from_secs(2));
    assert!(host.try_wait().unwrap().is_none(), "the host's studio closed over its guest");
    display.run("xdotool", &["windowfocus", &guest_window, "key", "Escape"]);
    let status = wait(&mut guest, PATIENCE);
    assert!(status.success(), "{}", text_of(guest.stderr.take().unwrap()));
    // once it is known that the guest has gone, or a second time while that is said
    let deadline = Instant::now() + PATIENCE;
    while host.try_wait().unwrap().is_none() && Instant::now() < deadline {
        display.run("xdotool", &["windowfocus", &host_window, "key", "Escape"]);
        std::thread::sleep(Duration::from_secs(8));
    }
    let status = wait(&mut host, PATIENCE);
    assert!(status.success(), "{}", text_of(host.stderr.take().unwrap()));
    let recorded = Stroke::read(&recording).unwrap();
    assert!(recorded.duration() > 2.0, "{} s recorded", recorded.duration());
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn keys_in_the_window_save_and_export_the_pot() {
    let out = folder("window-files");
    let pot = out.join("mine.pot");
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/pots/version-1.pot"), &pot).unwrap();
    let display = Display::new();
    let mut studio = display.studio(&["--listen", "127.0.0.1:0", "--open", pot.to_str().unwrap()]);
    let window = display.window(&[]);
    display.run("xdotool", &["windowfocus", &window]);
    until_drawn(&display, &[(0, SIZE.0)]);
    // the pot comes with the first keyframe
    std::thread::sleep(Duration::from_secs(1));
    let opened = PotFile::read(&pot).unwrap();
    fs::remove_file(&pot).unwrap();
    let solid = pot.with_extension("stl");
    for (key, written) in [("ctrl+s", &pot), ("ctrl+e", &solid)] {
        display.run("xdotool", &["key", key]);
        let deadline = Instant::now() + PATIENCE;
        while !written.exists() {
            assert!(Instant::now() < deadline, "{key} wrote no {}", written.display());
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    display.run("xdotool", &["key", "Escape"]);
    let status = wait(&mut studio, PATIENCE);
    assert!(status.success(), "{}", text_of(studio.stderr.take().unwrap()));
    assert_eq!(PotFile::read(&pot).unwrap().pot(), opened.pot(), "what nobody touched is saved as it was");
    assert!(fs::metadata(&solid).unwrap().len() > 84);
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn tool_key_takes_the_next_tool_and_other_keys_turn_it() {
    let out = folder("tool-key");
    let recording = out.join("mine.csv");
    let display = Display::new();
    let mut studio =
        display.studio(&["--listen", "127.0.0.1:0", "--tool", "rib", "--record", recording.to_str().unwrap()]);
    let window = display.window(&[]);
    display
        .run("xdotool", &["windowsize", "--sync", &window, "1000", "700", "windowmove", "--sync", &window, "0", "0"]);
    display.run("xdotool", &["windowfocus", &window, "mousemove", "500", "20"]);
    until_drawn(&display, &[(0, SIZE.0)]);
    std::thread::sleep(Duration::from_secs(1));
    // from the rib past the blade to the knuckle, four steps round its upright
    display.run("xdotool", &["key", "--delay", "60", "t", "t", "q", "q", "q", "q"]);
    std::thread::sleep(Duration::from_millis(500));
    // the pot stands in the middle of what the panel leaves free
    display.run("xdotool", &["mousemove", "640", "380"]);
    std::thread::sleep(Duration::from_millis(700));
    display.run("xdotool", &["mousedown", "1"]);
    std::thread::sleep(Duration::from_millis(1500));
    display.run("xdotool", &["mouseup", "1", "mousemove", "640", "20"]);
    std::thread::sleep(Duration::from_millis(500));
    display.run("xdotool", &["key", "Escape"]);
    let status = wait(&mut studio, PATIENCE);
    assert!(status.success(), "{}", text_of(studio.stderr.take().unwrap()));
    let recorded = Stroke::read(&recording).unwrap();
    assert_eq!(recorded.tools().last(), Some(Tool::Convex(Shape::KNUCKLE)));
    let turned = recorded.orientation_at(recorded.end()).angles_rad().map(f32::to_degrees);
    // a step of the orientation is 0.0055°
    assert!((turned[0] - 20.0).abs() < 0.01 && turned[1..] == [0.0; 2], "turned {turned:?}");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn scripted_potters_hold_the_tool_that_is_asked_for_and_a_file_brings_one() {
    let out = folder("tool-file");
    // an octahedron of 20 mm, as text
    let mesh = out.join("eight.obj");
    let corners = "v 20 0 0\nv -20 0 0\nv 0 20 0\nv 0 -20 0\nv 0 0 20\nv 0 0 -20\n";
    let faces = "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    fs::write(&mesh, [corners, faces].concat()).unwrap();
    // the same finer than can be shared, as its corners need not be: every side cut into fourteen
    let fine = out.join("fine.obj");
    let faces_of = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let ends = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut text = String::new();
    for face in faces_of {
        let [a, b, c] = face.map(|end| ends[end] * 20.0);
        let at = |i: i32, j: i32| a + (b - a) * (i as f32 / 14.0) + (c - a) * (j as f32 / 14.0);
        for (i, j) in (0..14).flat_map(|i| (0..14 - i).map(move |j| (i, j))) {
            let upright = [at(i, j), at(i + 1, j), at(i, j + 1)];
            let turned = [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for triangle in [Some(upright), (i + j < 13).then_some(turned)].into_iter().flatten() {
                triangle.iter().for_each(|corner| text += &format!("v {} {} {}\n", corner.x, corner.y, corner.z));
                text += "f -3 -2 -1\n";
            }
        }
    }
    fs::write(&fine, text).unwrap();
    let recording = out.join("first.csv");
    for (flags, tool) in [
        (vec!["--tool", "rib"], Tool::Convex(Shape::RIB)),
        (vec!["--tool-radius", "20"], Tool::from(Sphere::new(Metres::from_mm(20.0)).unwrap())),
        (vec!["--tool-file", mesh.to_str().unwrap()], Tool::Convex(Shape(4))),
        (vec!["--tool-file", fine.to_str().unwrap()], Tool::Convex(Shape(4))),
    ] {
        let output = Command::new(program("pottery-studio"))
            .args(["--headless", "--potters", "2", "--seconds", "3", "--out", out.to_str().unwrap()])
            .args(["--record", recording.to_str().unwrap()])
            .args(&flags)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{flags:?}: {text}");
        assert_eq!(text.contains("has 1568 triangles") && text.contains("with 8,"), flags[1].ends_with("fine.obj"));
        let recorded = Stroke::read(&recording).unwrap();
        fs::remove_file(&recording).unwrap();
        assert!(recorded.tools().eq([tool]), "{flags:?}");
        assert!(recorded.duration() > 1.0, "{flags:?}: {} s recorded", recorded.duration());
    }
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn tools_that_cannot_be_brought_are_refused_in_a_sentence() {
    let out = folder("no-tool");
    let studio = || Command::new(program("pottery-studio"));
    let (open, stroke) = (out.join("open.obj"), out.join("needs.csv"));
    fs::write(&open, "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 4 3\n").unwrap();
    fs::write(&stroke, "# tool: 4\nt_s,x_mm,y_mm,z_mm\n0,90,0,50\n").unwrap();
    for (flags, expected) in [
        (["--headless", "--tool-file", open.to_str().unwrap()], "open.obj"),
        (["--headless", "--tool-file", "no/such.stl"], "no/such.stl"),
        (["--headless", "--stroke", stroke.to_str().unwrap()], "--tool-file"),
        (["--headless", "--tool-radius", "99"], "from 2 to 35"),
        (["--headless", "--tool", "spoon"], "rib"),
    ] {
        let output = studio().args(flags).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && text.contains(expected), "{flags:?}: {text}");
    }
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn files_and_links_that_cannot_be_used_are_told_of_once() {
    let out = folder("no-files");
    let [junk, pot] = ["junk.pot", "pot.pot"].map(|name| out.join(name).display().to_string());
    fs::write(&junk, "junk").unwrap();
    let untouched = Pot::new(PotSpec::default()).unwrap();
    PotFile::of(&untouched, &Conditions::default(), Tick(0)).write(pot.as_ref()).unwrap();
    let nowhere = out.join("no/where.stl").display().to_string();
    for (arguments, expected) in [
        (["--headless", "--open", &junk].as_slice(), "it is no pot file"),
        (&["--headless", "--open", "no/such.pot"], "no/such.pot"),
        (&["replay", &junk, "--headless"], "it is no session file"),
        (&["replay", "no/such.rec", "--headless"], "no/such.rec"),
        (&["export", &junk, "pot.stl"], "it is no pot file"),
        (&["export", &pot, &nowhere], "choose another place"),
        (&["join", "pottery://127.0.0.1:4747/K7QM"], "8 or 24 characters"),
    ] {
        let text = sentence(&Command::new(program("pottery-studio")).args(arguments).output().unwrap());
        assert!(text.lines().count() == 1 && text.contains(expected), "{arguments:?}: {text}");
    }
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn joining_what_is_not_there_is_one_sentence() {
    let display = Display::new();
    let closed = std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let mut studio = display.studio(&["join", &closed, "--code", "K7QM-3XPD"]);
    let status = wait(&mut studio, PATIENCE);
    let text = text_of(studio.stderr.take().unwrap());
    assert!(!status.success() && text.contains("no studio answers") && text.contains(&closed), "{text}");
    let mut studio = display.studio(&["join", "no.such.host.invalid", "--code", "K7QM-3XPD"]);
    let status = wait(&mut studio, PATIENCE);
    let text = text_of(studio.stderr.take().unwrap());
    assert!(!status.success() && text.contains("no.such.host.invalid"), "{text}");
}

#[test]
fn flags_that_nobody_in_a_window_follows_are_refused() {
    let display = Display::new();
    let mut studio = display.studio(&["--listen", "127.0.0.1:0", "--potters", "2", "--out", "x"]);
    let status = wait(&mut studio, PATIENCE);
    let text = text_of(studio.stderr.take().unwrap());
    assert!(!status.success() && text.contains("--potters, --out") && text.contains("--headless"), "{text}");
}

#[test]
fn a_window_without_a_connection_shows_no_figure_of_it() {
    let mut server = Command::new(program("pottery-server"))
        .args(["--listen", "127.0.0.1:0", "--code", "K7QM-3XPD", "--no-announce"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(server.stdout.take().unwrap()).lines();
    let address = lines.next().unwrap().unwrap().replace("listening on ", "");
    let display = Display::new();
    let (mut studio, window) = display.studio_with_controls(&["join", &address, "--code", "K7QM-3XPD", "--mute"]);
    let deadline = Instant::now() + PATIENCE;
    let until = |begin: &str| {
        while window.says(begin).is_none() {
            assert!(Instant::now() < deadline, "{begin}: {:#?}", window.all());
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    until("H: keys · round trip ");
    server.kill().unwrap();
    server.wait().unwrap();
    until("H: keys · no connection · ");
    studio.kill().unwrap();
    studio.wait().unwrap();
}

#[test]
fn flags_before_a_command_are_refused_and_not_forgotten() {
    let studio = || Command::new(program("pottery-studio"));
    let text = sentence(&studio().args(["--seconds", "3", "host", "--headless"]).output().unwrap());
    assert!(text.contains("host"), "{text}");
    let text = sentence(&studio().args(["--mute", "jon"]).output().unwrap());
    assert!(text.contains("unrecognized subcommand 'jon'"), "{text}");
}
