//! A virtual display with windows of the studio on it, as a person would have them.
//!
//! Owns Xvfb and what is typed and pointed there, also at a control by what it says; knows no clay.
//! Invariant: the studio finds preferences of the display's own, and the display ends with the value.

use std::fmt;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use x11rb::COPY_DEPTH_FROM_PARENT;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    Atom, ConnectionExt, CreateWindowAux, ImageFormat, InputFocus, PropMode, Window, WindowClass,
};
use x11rb::rust_connection::{ReplyError, RustConnection};
use x11rb::wrapper::ConnectionExt as _;

use crate::programs::{folder, program};

/// Pixels of the display.
pub const SIZE: (usize, usize) = (1000, 700);

/// A virtual display with the programs that work on it; ends with the value.
#[derive(Debug)]
pub struct Display {
    server: Child,
    name: String,
    settings: PathBuf,
}

impl Display {
    /// A display for somebody who knows the lesson.
    ///
    /// # Panics
    /// Without Xvfb.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "it starts a program")]
    pub fn new() -> Self {
        let display = Self::of_newcomer();
        let preferences = display.preferences();
        fs::create_dir_all(preferences.parent().expect("it lies in a folder")).expect("a new folder can be made");
        fs::write(preferences, "knows_lesson = true\n").expect("a new folder can be written");
        display
    }

    /// A display for somebody who has never opened the studio.
    ///
    /// # Panics
    /// Without Xvfb.
    #[must_use]
    pub fn of_newcomer() -> Self {
        let mut server = Command::new("Xvfb")
            // without a reset, in which nobody can connect, whenever the last of the programs here has ended
            .args(["-noreset", "-displayfd", "1", "-screen", "0", "1000x700x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the window's test needs Xvfb (Debian: apt-get install xvfb xdotool)");
        let mut number = String::new();
        let said = server.stdout.take().expect("its output was asked for");
        BufReader::new(said).read_line(&mut number).expect("Xvfb says its number");
        let number = number.trim();
        let settings = folder(&format!("display-{number}"));
        Self { server, name: format!(":{number}"), settings }
    }

    /// The file of the person's preferences.
    #[must_use]
    pub fn preferences(&self) -> PathBuf {
        self.data().join("preferences.toml")
    }

    /// The folder of what the studio keeps for this person.
    #[must_use]
    pub fn data(&self) -> PathBuf {
        self.settings.join("pottery-studio")
    }

    /// For `--device`: a simulated hand that presses, up and down the clay, for ten minutes; the studio's own rests after nine seconds.
    ///
    /// # Panics
    /// When its stroke cannot be written.
    #[must_use]
    pub fn hand_that_goes_on(&self) -> String {
        let mut stroke = "t_s,x_mm,y_mm,z_mm\n0,80,0,100\n1,64,0,100\n".to_owned();
        for way in 1..120 {
            // 8 mm behind the wall, for 2.4 N
            stroke += &format!("{},64,0,{}\n", 1 + 5 * way, if way % 2 == 0 { 90 } else { 110 });
        }
        fs::create_dir_all(&self.settings).expect("a new folder can be made");
        let path = self.settings.join("stroke.csv");
        fs::write(&path, stroke).expect("a new folder can be written");
        format!("simulated:file={}", path.display())
    }

    /// Runs a program on the display; what it says.
    ///
    /// # Panics
    /// When there is no such program.
    pub fn run(&self, program: &str, arguments: &[&str]) -> String {
        let output = Command::new(program).args(arguments).env("DISPLAY", &self.name).output();
        let output = output.unwrap_or_else(|error| panic!("{program}: {error} (Debian: apt-get install {program})"));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Starts the studio on the display.
    ///
    /// # Panics
    /// When it does not start.
    #[must_use]
    pub fn studio(&self, arguments: &[&str]) -> Child {
        self.studio_that_logs(arguments, "warn,winit=error,pulseaudio=off", &[])
    }

    /// Starts it with a log of that filter, which goes to its standard error without colours, and with variables of its environment.
    ///
    /// # Panics
    /// When it does not start.
    #[must_use]
    pub fn studio_that_logs(&self, arguments: &[&str], filter: &str, variables: &[(&str, &str)]) -> Child {
        Command::new(program("pottery-studio"))
            .args(arguments)
            .env("DISPLAY", &self.name)
            .env("XDG_CONFIG_HOME", &self.settings)
            .env("XDG_DATA_HOME", &self.settings)
            // Mesa takes every core for a picture otherwise, for which windows of other tests wait
            .env("LP_NUM_THREADS", "1")
            .env("LC_ALL", "C.UTF-8")
            .env("RUST_LOG", filter)
            .env("NO_COLOR", "1")
            .envs(variables.iter().copied())
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the studio was built")
    }

    /// Starts it in a window that fills the display, of which one knows where its controls lie.
    ///
    /// # Panics
    /// When it does not start.
    #[must_use]
    pub fn studio_with_controls(&self, arguments: &[&str]) -> (Child, Controls<'_>) {
        self.studio_with_controls_in(arguments, &[])
    }

    /// The same with variables of its environment.
    ///
    /// # Panics
    /// When it does not start.
    #[must_use]
    pub fn studio_with_controls_in(&self, arguments: &[&str], variables: &[(&str, &str)]) -> (Child, Controls<'_>) {
        let filter = "warn,winit=error,pulseaudio=off,pottery_studio::window::overlay=trace";
        let mut studio = self.studio_that_logs(arguments, filter, variables);
        let said = Arc::new(Mutex::new(Said::default()));
        let (log, heard) = (studio.stderr.take().expect("its errors were asked for"), Arc::clone(&said));
        thread::spawn(move || {
            for line in BufReader::new(log).lines().map_while(Result::ok) {
                match line.split_once("overlay: panel ") {
                    Some((_, said)) => *heard.lock().unwrap_or_else(PoisonError::into_inner) = Said::read(said),
                    None => eprintln!("{line}"),
                }
            }
        });
        let window = self.window(&[]);
        let (width, height) = (SIZE.0.to_string(), SIZE.1.to_string());
        self.run("xdotool", &["windowsize", "--sync", &window, &width, &height]);
        self.run("xdotool", &["windowmove", "--sync", &window, "0", "0", "windowfocus", &window]);
        (studio, Controls { display: self, said })
    }

    /// Takes the keyboard away from every window.
    ///
    /// # Panics
    /// When the display does not do as it is asked.
    pub fn leave_windows(&self) {
        let (server, _) = RustConnection::connect(Some(&self.name)).expect("the display runs");
        let left = server.set_input_focus(InputFocus::NONE, x11rb::NONE, x11rb::CURRENT_TIME);
        left.expect("the display runs").check().expect("the display does as it is asked");
    }

    /// Waits until a window besides `known` is seen: one that is there already but not shown yet takes no keyboard.
    ///
    /// # Panics
    /// When none appears.
    #[must_use]
    pub fn window(&self, known: &[String]) -> String {
        let deadline = Instant::now() + Duration::from_secs(60);
        while Instant::now() < deadline {
            let found = self.run("xdotool", &["search", "--onlyvisible", "--name", "Pottery studio"]);
            if let Some(window) = found.lines().find(|window| !known.iter().any(|known| known == window)) {
                return window.to_owned();
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("no window appeared");
    }

    /// RGB pixels of the whole display, row by row.
    ///
    /// # Panics
    /// When the display does not do as it is asked.
    #[must_use]
    pub fn pixels(&self) -> Vec<u8> {
        let looked = || {
            let (server, screen) = RustConnection::connect(Some(&self.name)).expect("the display runs");
            let (root, [width, height]) = (server.setup().roots[screen].root, [SIZE.0, SIZE.1].map(|size| size as u16));
            server.get_image(ImageFormat::Z_PIXMAP, root, 0, 0, width, height, u32::MAX)?.reply()
        };
        let looked: Result<_, ReplyError> = looked();
        let seen = looked.expect("the display does as it is asked").data;
        // a pixel is blue, green, red and nothing
        let pixels: Vec<u8> = seen.chunks_exact(4).flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect();
        assert_eq!(pixels.len(), SIZE.0 * SIZE.1 * 3);
        pixels
    }
}

/// What a desktop tells its windows of the screen they are on, as the XSETTINGS specification of freedesktop.org has it; for as long as the value lives.
#[derive(Debug)]
pub struct Desktop {
    server: RustConnection,
    window: Window,
    settings: Atom,
    changes: u32,
}

impl Desktop {
    /// A desktop for a display on which no window is yet.
    ///
    /// # Panics
    /// When the display does not do as it is asked.
    #[must_use]
    pub fn of(display: &Display, pixels_an_inch: u32) -> Self {
        let (server, screen) = RustConnection::connect(Some(&display.name)).expect("the display runs");
        let mut desktop = Self::on(server, screen).expect("the display does as it is asked");
        desktop.change_screen(pixels_an_inch);
        desktop
    }

    fn on(server: RustConnection, screen: usize) -> Result<Self, ReplyError> {
        let root = server.setup().roots[screen].root;
        let window = server.generate_id().map_err(|_| x11rb::errors::ConnectionError::UnknownError)?;
        let (kind, properties) = (WindowClass::INPUT_ONLY, CreateWindowAux::new());
        server.create_window(COPY_DEPTH_FROM_PARENT, window, root, 0, 0, 1, 1, 0, kind, 0, &properties)?.check()?;
        let named = |name: &str| Ok::<_, ReplyError>(server.intern_atom(false, name.as_bytes())?.reply()?.atom);
        let (settings, owner) = (named("_XSETTINGS_SETTINGS")?, named(&format!("_XSETTINGS_S{screen}"))?);
        server.set_selection_owner(window, owner, x11rb::CURRENT_TIME)?.check()?;
        Ok(Self { server, window, settings, changes: 0 })
    }

    /// Puts another screen in the place of the one before, with so many pixels an inch; 96 are one to a point.
    ///
    /// # Panics
    /// When the display does not do as it is asked.
    pub fn change_screen(&mut self, pixels_an_inch: u32) {
        self.changes += 1;
        let [changes, one, dpi] = [self.changes, 1, pixels_an_inch * 1024].map(u32::to_le_bytes);
        // numbers have their lowest byte first; one setting, which is a number, with its name's length and its name
        let setting = [&[0, 0, 7, 0][..], b"Xft/DPI\0", &changes, &dpi].concat();
        let bytes = [&[0; 4], &changes, &one, &setting[..]].concat();
        let (window, kind) = (self.window, self.settings);
        let told = self.server.change_property8(PropMode::REPLACE, window, self.settings, kind, &bytes);
        told.expect("the display runs").check().expect("a window has settings");
    }
}

/// Something in a window that says what it is, as a screen reader is told of it.
#[derive(Clone, PartialEq, Eq)]
pub struct Control {
    /// What it is, in AccessKit's words.
    pub role: String,
    /// What it says.
    pub name: String,
    /// Left, top, width and height, pixels.
    pub place: [i32; 4],
}

/// On one line: a window has a hundred of them, and a test that fails shows them all.
impl fmt::Debug for Control {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {:?} at {:?}", self.role, self.name, self.place)
    }
}

impl Control {
    fn read(text: &str) -> Option<Self> {
        let (said, place) = text.rsplit_once(" @")?;
        let (role, name) = said.split_once(' ')?;
        let place: Vec<i32> = place.split(',').filter_map(|number| number.parse().ok()).collect();
        Some(Self { role: role.to_owned(), name: name.to_owned(), place: place.try_into().ok()? })
    }

    fn middle(&self) -> (i32, i32) {
        let [left, top, width, height] = self.place;
        (left + width / 2, top + height / 2)
    }
}

/// What a window's panel says of itself when it is laid out and is not as it was.
#[derive(Debug, Default)]
struct Said {
    /// Whether it stays so by itself.
    rests: bool,
    /// Where it is pointed at, pixels.
    pointer: Option<(i32, i32)>,
    controls: Vec<Control>,
}

impl Said {
    fn read(text: &str) -> Self {
        let mut parts = text.split(" ¦ ");
        let (ends, at) = parts.next().and_then(|begin| begin.split_once(' ')).unwrap_or_default();
        let pointer = at.split_once(',').and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
        Self { rests: ends == "rests", pointer, controls: parts.filter_map(Control::read).collect() }
    }
}

/// The controls of the one window on a display.
#[derive(Debug)]
pub struct Controls<'a> {
    display: &'a Display,
    said: Arc<Mutex<Said>>,
}

impl Controls<'_> {
    /// Rows of pixels in which a control can be clicked on: between the window's top and the line of figures at its foot.
    const SEEN: std::ops::Range<i32> = 40..640;
    /// Above this row, a menu has room below, also when a line or two come above it meanwhile.
    const MENU: i32 = 370;
    /// Rows by which a step of the mouse wheel moves the panel at most.
    const TURN: i32 = 60;

    /// All of them, as they were drawn last.
    #[must_use]
    pub fn all(&self) -> Vec<Control> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).controls.clone()
    }

    /// The lowest of them whose words begin so and that is no mere label.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<Control> {
        let named = self.all().into_iter().filter(|control| control.role != "Label" && control.name.starts_with(name));
        named.max_by_key(|control| control.place[1])
    }

    /// What is said that begins so.
    #[must_use]
    pub fn says(&self, begin: &str) -> Option<String> {
        self.all().into_iter().find(|control| control.name.starts_with(begin)).map(|control| control.name)
    }

    /// Clicks on the control whose words begin so, once the panel lies still; turns the mouse wheel until it is seen.
    ///
    /// # Panics
    /// When there is none for a minute.
    pub fn press(&self, name: &str) {
        self.press_within(name, Self::SEEN);
    }

    /// The same with one that opens a menu, which is to have room below it.
    ///
    /// # Panics
    /// When there is none for a minute.
    pub fn open(&self, name: &str) {
        self.press_within(name, Self::SEEN.start..Self::MENU);
    }

    /// Presses an entry of a menu that is open: it lies over what is at the window's foot.
    ///
    /// # Panics
    /// When there is none for a minute.
    pub fn choose(&self, name: &str) {
        self.press_within(name, Self::SEEN.start..700);
    }

    fn press_within(&self, name: &str, rows: std::ops::Range<i32>) {
        let deadline = Instant::now() + Duration::from_secs(60);
        let mut turned = None;
        loop {
            assert!(Instant::now() < deadline, "there is no '{name}': {:#?}", self.all());
            let Some(control) = self.find(name) else {
                thread::sleep(Duration::from_millis(50));
                continue;
            };
            let (x, y) = control.middle();
            // what the mouse wheel does not move any more is as high as it gets
            let is_last = turned.as_ref() == Some(&control) && Self::SEEN.contains(&y);
            if rows.contains(&y) || is_last {
                self.display.run("xdotool", &["mousemove", &x.to_string(), &y.to_string()]);
                if self.rests_under((x, y), deadline) && self.find(name).as_ref() == Some(&control) {
                    // the panel takes what was clicked on to be what the mouse is over when it is laid out next
                    let (aside, y_text) = ((x + 4, y), y.to_string());
                    self.display.run("xdotool", &["click", "1", "mousemove", &aside.0.to_string(), &y_text]);
                    // the window may be gone by it
                    self.rests_under(aside, Instant::now() + Duration::from_secs(5));
                    return;
                }
            } else {
                let (text, turn) = (x.to_string(), if y < rows.start { "4" } else { "5" });
                // as many steps as leave it short of the middle, or one
                let times = ((y - i32::midpoint(rows.start, rows.end)).abs() / Self::TURN).max(1).to_string();
                // what is moved after the turn is seen no sooner than the turn
                let [to, on] = [["mousemove", &text, "340"], ["mousemove", &text, "341"]];
                let click = ["click", "--repeat", &times, "--delay", "1", turn];
                self.display.run("xdotool", &[&to[..], &click, &on].concat());
                turned = self.rests_under((x, 341), deadline).then_some(control);
            }
        }
    }

    /// Waits until the panel lies still with the mouse there: all that was done before is seen in it then; false at the deadline.
    fn rests_under(&self, (x, y): (i32, i32), deadline: Instant) -> bool {
        while Instant::now() < deadline {
            thread::sleep(Duration::from_millis(20));
            let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
            if said.rests && said.pointer.is_some_and(|now| now.0.abs_diff(x) <= 1 && now.1.abs_diff(y) <= 1) {
                return true;
            }
        }
        false
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        drop(self.server.kill());
        drop(self.server.wait());
        drop(fs::remove_dir_all(&self.settings));
    }
}

/// A picture of RGB pixels, so many in a row, with each colour's mean over squares of so many pixels a side.
#[must_use]
pub fn folded(pixels: &[u8], width: usize, by: usize) -> Vec<u8> {
    let height = pixels.len() / 3 / width;
    let mut picture = Vec::with_capacity(pixels.len() / by / by);
    for (y, x) in (0..height / by).flat_map(|y| (0..width / by).map(move |x| (y, x))) {
        for of in 0..3 {
            let square = (0..by * by).map(|at| (y * by + at / by, x * by + at % by));
            let sum: usize = square.map(|(y, x)| usize::from(pixels[(y * width + x) * 3 + of])).sum();
            picture.push((sum / (by * by)) as u8);
        }
    }
    picture
}

/// Colours of pixels in which two pictures differ, above the row of that number.
#[must_use]
pub fn differing(one: &[u8], other: &[u8], row: usize) -> usize {
    let above = row * SIZE.0 * 3;
    one[..above].iter().zip(&other[..above]).filter(|(one, other)| one != other).count()
}
