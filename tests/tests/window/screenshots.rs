//! Pictures of the window as a person sees it, held against those in `data/pictures/window`, which the README shows as well.
//!
//! A real window on a virtual display, driven by mouse and keys, and drawn in software: a graphics card's rounding is not the
//! reference's. The wheel stands still and the clay is fired, which does not dry; nothing is looked at before the window has come to rest,
//! when it has every pixel on any machine, and no time is measured.
//! After a change that is meant to be seen, `POTTERY_WRITE_PICTURES=1 cargo test -p pottery-suites --test window screenshots` writes them
//! anew.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use pottery_client::pot_file::PotFile;
use pottery_shared::clay::{Conditions, Pot, PotSpec};
use pottery_shared::units::Tick;
use pottery_tests::display::{Desktop, Display, SIZE, differing, folded};
use pottery_tests::programs::folder;

/// How long the studio takes at most to do what it was asked for; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(120);
/// Pixels of the window, each way, that are one of a picture that is kept, and that are one of what is compared: letters' edges go into the
/// mean there, and so does how sharp a picture is that is drawn while something moves.
const KEPT: usize = 2;
const BLURRED: usize = 10;
/// Largest mean difference at rest, in the colour that differs most, steps of 255: runs on one machine differ by up to 0.01, busy or not, and by 0.16
/// where the clay was pressed quickly; and a driver that rounds otherwise is off by one step in some of the pixels.
const MEAN_MAX: f64 = 0.5;
/// Most colours of pixels, of two million, in which a window at rest differs from itself: clay gives way for ever more slowly under a tool that is
/// held, and 13 were seen to come and go half a minute long.
const EDGES_MAX: usize = 30;
/// And while something moves, when a busy machine draws half of the pixels each way: that is up to 0.87.
const MOVING_MEAN_MAX: f64 = 1.5;
/// Largest share of squares that may differ by more than [`FAR`] in any colour: none was seen, and up to 0.33 % at the edges of what was pressed quickly.
/// The two references that are most alike differ in 0.6 %, by a ball of 30 mm.
const FAR: i32 = 16;
const FAR_MAX: f64 = 0.002;

/// A part of the window: left, top, width, height.
type Part = [usize; 4];
/// The line of figures, which differs from run to run.
const FIGURES: Part = [0, 670, 1000, 30];
/// The slider of a session that is replayed, whose length is another every time.
const TIME: Part = [140, 610, 720, 90];
/// The panel: what it says is the words' tests' affair, and where it lies is held by the picture beside it.
const PANEL: Part = [0, 0, 290, 700];
/// What in the panel is another in each run: address and code, and where the pot lies.
const ADDRESS: Part = [0, 30, 290, 90];
const FILE: Part = [0, 560, 290, 110];
/// The figures with twice as many pixels an inch.
const DOUBLED_FIGURES: Part = [0, 640, 1000, 60];
/// The other one's name, which is drawn by lot.
const NAME: Part = [700, 290, 220, 60];

/// The window's pixels as they are kept.
fn kept(pixels: &[u8]) -> Vec<u8> {
    folded(pixels, SIZE.0, KEPT)
}

/// The squares of two kept pictures outside of what is left out: left and top, and how much more the first has of each colour.
fn squares(one: &[u8], other: &[u8], left_out: &[Part]) -> Vec<([usize; 2], [i32; 3])> {
    let width = SIZE.0 / BLURRED;
    let [one, other] = [one, other].map(|picture| folded(picture, SIZE.0 / KEPT, BLURRED / KEPT));
    let pixels = one.as_chunks::<3>().0.iter().zip(other.as_chunks::<3>().0).enumerate();
    let squares = pixels.map(|(at, (one, other))| {
        ([at % width * BLURRED, at / width * BLURRED], [0, 1, 2].map(|of| i32::from(one[of]) - i32::from(other[of])))
    });
    let is_left_out = |[x, y]: [usize; 2]| {
        let holds =
            |&[left, top, wide, high]: &Part| (left..left + wide).contains(&x) && (top..top + high).contains(&y);
        left_out.iter().any(holds)
    };
    squares.filter(|(at, _)| !is_left_out(*at)).collect()
}

/// Whether a square is far from what it should be.
fn is_far((_, more): &([usize; 2], [i32; 3])) -> bool {
    more.iter().any(|more| more.abs() > FAR)
}

/// Mean difference of two kept pictures outside of what is left out, in the colour that differs most, and the share of squares that are far apart.
fn difference(one: &[u8], other: &[u8], left_out: &[Part]) -> (f64, f64) {
    let squares = squares(one, other, left_out);
    let sum = |of: usize| squares.iter().map(|(_, more)| more[of].abs()).sum::<i32>();
    let most = [0, 1, 2].map(sum).into_iter().max().unwrap_or_default();
    let far = squares.iter().filter(|square| is_far(square)).count();
    (f64::from(most) / squares.len() as f64, far as f64 / squares.len() as f64)
}

fn is_same((mean, far): (f64, f64), comes: Comes) -> bool {
    let most = if comes == Comes::ToRest { MEAN_MAX } else { MOVING_MEAN_MAX };
    mean <= most && far <= FAR_MAX
}

fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/pictures/window").join(name).with_extension("png")
}

fn read(path: &Path) -> Vec<u8> {
    let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

fn write(path: &Path, picture: &[u8]) {
    let mut encoder =
        png::Encoder::new(fs::File::create(path).unwrap(), (SIZE.0 / KEPT) as u32, (SIZE.1 / KEPT) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header().unwrap().write_image_data(picture).unwrap();
}

/// How long a window is left alone between two looks. What is compared with a reference is looked at until it is the same, so that a window that stood
/// still for a moment alone costs another look.
const LOOKS_APART: Duration = Duration::from_millis(600);
/// And under a tool that is held, since clay gives way for ever more slowly.
const PRESSES_APART: Duration = Duration::from_millis(2500);

/// Whether the window moves by itself while it is looked at.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Comes {
    ToRest,
    Alive,
}

/// The window once it stands still: three times the same but for its figures and a few edges under a tool that is held, as far apart as
/// several looks at rest on a busy machine.
fn at_rest(display: &Display, apart: Duration) -> Vec<u8> {
    let deadline = Instant::now() + PATIENCE;
    let (mut first, mut same) = (display.pixels(), 0);
    loop {
        std::thread::sleep(apart);
        let now = display.pixels();
        same = if differing(&first, &now, FIGURES[1]) <= EDGES_MAX { same + 1 } else { 0 };
        if same == 2 || Instant::now() > deadline {
            return kept(&now);
        }
        if same == 0 {
            first = now;
        }
    }
}

/// Presses a key that moves the tool, and waits until the window has shown it, or long enough for a tool that is as far as it goes: several of
/// them that a busy machine took in at once would be one quick press, which leaves a higher ridge.
fn press_slowly(display: &Display, key: &str) {
    let (before, deadline) = (display.pixels(), Instant::now() + Duration::from_secs(2));
    display.run("xdotool", &["key", key]);
    while differing(&before, &display.pixels(), FIGURES[1]) <= EDGES_MAX && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_millis(400));
}

/// Waits until the window looks as the reference does.
fn until_as(display: &Display, name: &str, comes: Comes, left_out: &[Part]) {
    let path = reference(name);
    let look = || if comes == Comes::ToRest { at_rest(display, LOOKS_APART) } else { kept(&display.pixels()) };
    static WRITTEN: Mutex<Vec<String>> = Mutex::new(Vec::new());
    if std::env::var_os("POTTERY_WRITE_PICTURES").is_some() {
        let mut written = WRITTEN.lock().unwrap();
        if !written.iter().any(|written| written == name) {
            written.push(name.to_owned());
            // nothing says here that what is waited for has come
            std::thread::sleep(Duration::from_secs(6));
            write(&path, &look());
        }
    }
    let (expected, deadline) = (read(&path), Instant::now() + PATIENCE);
    loop {
        let seen = look();
        let (mean, far) = difference(&seen, &expected, left_out);
        if is_same((mean, far), comes) {
            return println!("{name}: {mean:.3} steps in the mean, {:.2} % of the squares far apart", 100.0 * far);
        }
        if Instant::now() > deadline {
            let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name).with_extension("png");
            write(&kept, &seen);
            let mut apart = squares(&seen, &expected, left_out);
            apart.retain(is_far);
            panic!("{name}: {mean:.3} and {far:.4} from {}; seen: {}; {apart:?}", path.display(), kept.display());
        }
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// Brings a window to the size of the display.
fn fill(display: &Display, window: &str) {
    let (width, height) = (SIZE.0.to_string(), SIZE.1.to_string());
    display.run("xdotool", &["windowsize", "--sync", window, &width, &height]);
    display.run("xdotool", &["windowmove", "--sync", window, "0", "0", "windowfocus", window]);
}

/// A studio that fills the display, on a pot that stands still; fired clay, since wet clay dries while one looks.
struct Studio<'a> {
    display: &'a Display,
    child: Child,
    folder: PathBuf,
}

impl<'a> Studio<'a> {
    fn open(display: &'a Display, name: &str, arguments: &[&str]) -> Self {
        Self::open_with(display, name, arguments, &[])
    }

    fn open_with(display: &'a Display, name: &str, arguments: &[&str], variables: &[(&str, &str)]) -> Self {
        let folder = folder(name);
        let pot = folder.join("still.pot");
        PotFile::of(&Pot::new(PotSpec::default()).unwrap(), &Conditions::default(), Tick(0)).write(&pot).unwrap();
        let liked = "knows_lesson = true\nfinish = \"biscuit\"\nlanguage = \"english\"\nsound = false\n";
        fs::write(display.preferences(), liked).unwrap();
        let always = ["--listen", "127.0.0.1:0", "--mute", "--open", pot.to_str().unwrap()];
        let child =
            display.studio_that_logs(&[&always, arguments].concat(), "warn,winit=error,pulseaudio=off", variables);
        let studio = Self { display, child, folder };
        studio.fill(&display.window(&[]));
        studio
    }

    fn fill(&self, window: &str) {
        fill(self.display, window);
        self.rest();
    }

    /// Takes the pointer off the wheel.
    fn rest(&self) {
        self.display.run("xdotool", &["mousemove", "140", "672"]);
    }

    fn close(mut self) {
        self.display.run("xdotool", &["key", "Escape"]);
        let deadline = Instant::now() + PATIENCE;
        while self.child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "the studio does not close");
            std::thread::sleep(Duration::from_millis(50));
        }
        assert!(self.child.wait().unwrap().success());
        fs::remove_dir_all(&self.folder).unwrap();
    }
}

#[test]
fn black_and_empty_windows_are_told_from_every_reference() {
    let mut references: Vec<_> =
        fs::read_dir(reference("x").parent().unwrap()).unwrap().map(|entry| entry.unwrap().path()).collect();
    references.sort();
    assert!(references.len() >= 5, "{references:?}");
    let flat = |value: u8| vec![value; SIZE.0 / KEPT * (SIZE.1 / KEPT) * 3];
    let mut nearest = f64::INFINITY;
    for (number, path) in references.iter().enumerate() {
        let picture = read(path);
        for value in [0, 24, 128, 255] {
            let apart = difference(&flat(value), &picture, &[PANEL]);
            assert!(!is_same(apart, Comes::Alive), "{} looks like all {value}", path.display());
        }
        // a window that has drawn its backdrop and panel and nothing on the wheel
        let mut empty = picture.clone();
        for (y, x) in (0..SIZE.1 / KEPT).flat_map(|y| (PANEL[2] / KEPT..SIZE.0 / KEPT).map(move |x| (y, x))) {
            let backdrop = (y * SIZE.0 / KEPT + SIZE.0 / KEPT - 1) * 3;
            let at = (y * SIZE.0 / KEPT + x) * 3;
            empty.copy_within(backdrop..backdrop + 3, at);
        }
        assert!(!is_same(difference(&empty, &picture, &[PANEL]), Comes::Alive), "{} looks empty", path.display());
        // and no two of them look alike, or a window that stands still would do for both
        for other in &references[..number] {
            let (mean, far) = difference(&read(other), &picture, &[PANEL, FIGURES]);
            nearest = nearest.min((mean / MOVING_MEAN_MAX).max(far / FAR_MAX));
            assert!(!is_same((mean, far), Comes::Alive), "{} and {}", path.display(), other.display());
        }
    }
    println!("the two that are most alike are {nearest:.1} times as far apart as pictures that are the same may be");
}

#[test]
fn a_pot_is_pressed_keys_and_panel_are_opened_and_it_is_exported() {
    let display = Display::new();
    let kept = folder("pressed-session");
    let session = kept.join("kept.session");
    let studio = Studio::open(&display, "pressed", &["--record-session", session.to_str().unwrap()]);
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    // a larger ball, three times, until the clay gives way no more
    display.run("xdotool", &["key", "--delay", "60", "plus", "plus", "plus", "plus", "plus", "plus", "plus", "plus"]);
    for height in ["230", "320", "410"] {
        display.run("xdotool", &["mousemove", "625", height]);
        at_rest(&display, PRESSES_APART);
        display.run("xdotool", &["mousedown", "1"]);
        // a millimetre at a time
        (0..14).for_each(|_| press_slowly(&display, "w"));
        at_rest(&display, PRESSES_APART);
        display.run("xdotool", &["mouseup", "1"]);
        display.run("xdotool", &[&["key", "--delay", "60"][..], &["s"; 20]].concat());
        at_rest(&display, PRESSES_APART);
    }
    studio.rest();
    until_as(&display, "pressed", Comes::ToRest, &[PANEL, FIGURES]);
    display.run("xdotool", &["key", "h"]);
    until_as(&display, "keys", Comes::ToRest, &[PANEL, FIGURES]);
    display.run("xdotool", &["key", "h"]);
    // the panel is folded away and opened again
    display.run("xdotool", &["key", "p"]);
    until_as(&display, "folded", Comes::ToRest, &[FIGURES]);
    display.run("xdotool", &["key", "p"]);
    until_as(&display, "pressed", Comes::ToRest, &[ADDRESS, FILE, FIGURES]);

    display.run("xdotool", &["key", "ctrl+e"]);
    let solid = studio.folder.join("still.stl");
    let deadline = Instant::now() + PATIENCE;
    while !solid.exists() {
        assert!(Instant::now() < deadline, "no {}", solid.display());
        std::thread::sleep(Duration::from_millis(50));
    }
    // the panel says where to, which is another folder every time
    until_as(&display, "pressed", Comes::ToRest, &[PANEL, FIGURES]);
    assert!(fs::metadata(&solid).unwrap().len() > 1_000_000);

    // the file has the pot as it was before: opened on the running wheel, it takes the place of this one, and can be taken back
    display.run("xdotool", &["key", "ctrl+o"]);
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    display.run("xdotool", &["key", "ctrl+z"]);
    until_as(&display, "pressed", Comes::ToRest, &[PANEL, FIGURES]);
    // one that was cut short is refused, and the wheel has what it had
    let whole = fs::read(studio.folder.join("still.pot")).unwrap();
    fs::write(studio.folder.join("still.pot"), &whole[..whole.len() - 100]).unwrap();
    display.run("xdotool", &["key", "ctrl+o"]);
    until_as(&display, "pressed", Comes::ToRest, &[PANEL, FIGURES]);
    display.run("xdotool", &["key", "k", "key", "p"]);
    until_as(&display, "cut", Comes::ToRest, &[FIGURES]);
    studio.close();

    // and the session that was kept shows the same pot at its end
    let mut replay = display.studio(&["replay", session.to_str().unwrap(), "--at", "9999"]);
    let window = display.window(&[]);
    fill(&display, &window);
    until_as(&display, "replayed", Comes::ToRest, &[TIME]);
    display.run("xdotool", &["windowfocus", &window, "key", "Escape"]);
    assert!(replay.wait().unwrap().success());
    fs::remove_dir_all(kept).unwrap();
}

#[test]
fn a_second_client_is_seen_at_the_wheel() {
    let display = Display::new();
    let mut studio = Studio::open(&display, "joined", &[]);
    let mut said = String::new();
    std::io::BufRead::read_line(&mut BufReader::new(studio.child.stdout.take().unwrap()), &mut said).unwrap();
    let join: Vec<&str> = said.trim().split_once("pottery-studio ").unwrap().1.split(' ').collect();
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    // the other one's hand rests beside the pot, on a display of its own
    let still = studio.folder.join("still.csv");
    // it trembles by a tenth of a millimetre, or it would be taken for one that was put down
    let row = |at: usize| format!("{:.2},70.000,-75.000,{}\n", at as f64 * 0.01, ["120.000", "120.100"][at / 10 % 2]);
    let rows: String = (0..60_000).map(row).collect();
    fs::write(
        &still,
        format!("# a hand that hardly moves\n# tool_radius_mm: 15\n# wheel_rpm: 0\nt_s,x_mm,y_mm,z_mm\n{rows}"),
    )
    .unwrap();
    let elsewhere = Display::new();
    let device = format!("replay:file={}", still.display());
    let mut guest = elsewhere.studio(&[&join[..], &["--mute", "--device", &device]].concat());
    until_as(&display, "joined", Comes::Alive, &[PANEL, FIGURES, NAME]);
    let window = elsewhere.window(&[]);
    elsewhere.run("xdotool", &["windowfocus", &window, "key", "Escape"]);
    assert!(guest.wait().unwrap().success());
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    studio.close();
}

#[test]
fn a_window_of_any_size_that_is_hidden_and_shown_again_looks_as_before() {
    let display = Display::new();
    let studio = Studio::open(&display, "sizes", &[]);
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    let window = display.window(&[]);
    for (width, height) in [("640", "480"), ("3840", "2160"), ("1", "1"), ("500", "1")] {
        display.run("xdotool", &["windowsize", "--sync", &window, width, height]);
        at_rest(&display, LOOKS_APART);
        assert!(
            display.run("xdotool", &["search", "--name", "Pottery studio"]).contains(&window),
            "{width} × {height}"
        );
    }
    studio.fill(&window);
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    display.run("xdotool", &["windowunmap", "--sync", &window]);
    at_rest(&display, LOOKS_APART);
    display.run("xdotool", &["windowmap", "--sync", &window]);
    studio.fill(&window);
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    studio.close();
}

#[test]
fn a_screen_with_other_pixels_shows_the_same_in_another_size() {
    let display = Display::new();
    let mut desktop = Desktop::of(&display, 96);
    let studio = Studio::open(&display, "screens", &[]);
    let window = display.window(&[]);
    until_as(&display, "untouched", Comes::ToRest, &[ADDRESS, FILE, FIGURES]);
    // twice as many pixels an inch: the window asks for twice its size, is given what there is, and folds its panel, which would take half of it
    desktop.change_screen(192);
    at_rest(&display, LOOKS_APART);
    studio.fill(&window);
    until_as(&display, "doubled", Comes::ToRest, &[DOUBLED_FIGURES]);
    desktop.change_screen(96);
    at_rest(&display, LOOKS_APART);
    studio.fill(&window);
    until_as(&display, "untouched", Comes::ToRest, &[ADDRESS, FILE, FIGURES]);
    studio.close();
}

/// Closes a studio with a lost device; what it said on its way, and whether it ended well.
fn words_of(child: Child) -> (bool, String) {
    let output = child.wait_with_output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_lost_graphics_device_costs_a_picture_and_nothing_else() {
    let display = Display::new();
    // the second time, the processor draws
    let lost = [("POTTERY_LOSE_DEVICE_AFTER", "2,5")];
    let studio = Studio::open_with(&display, "lost", &[], &lost);
    until_as(&display, "untouched", Comes::ToRest, &[PANEL, FIGURES]);
    display.run("xdotool", &["key", "p", "key", "p", "key", "h"]);
    // no picture is kept of these keys beside this pot
    at_rest(&display, PRESSES_APART);
    display.run("xdotool", &["key", "h"]);
    // with its letters
    until_as(&display, "untouched", Comes::ToRest, &[ADDRESS, FILE, FIGURES]);
    display.run("xdotool", &["key", "Escape"]);
    let (is_well, said) = words_of(studio.child);
    assert!(is_well && said.matches("the graphics device was lost").count() == 2, "{said}");
    assert!(!said.contains("panicked"), "{said}");
    fs::remove_dir_all(&studio.folder).unwrap();
    // and where every device is lost, one sentence ends it
    let lost = [("POTTERY_LOSE_DEVICE_AFTER", "2,3,4")];
    let studio = display.studio_that_logs(&["--listen", "127.0.0.1:0", "--mute"], "error", &lost);
    let (is_well, said) = words_of(studio);
    // beside what the graphics library says of the machine
    let own: Vec<_> = said.lines().filter(|line| line.starts_with("pottery-studio: ")).collect();
    assert!(!is_well && own.len() == 1 && own[0].contains("lost again and again"), "{said}");
    assert!(!said.contains("panicked"), "{said}");
}
