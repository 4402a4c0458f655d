//! A virtual display with windows of the studio on it, as a person would have them.
//!
//! Owns Xvfb and what is typed and pointed there; knows no clay.
//! Invariant: the studio finds preferences of the display's own, and the display ends with the value.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

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
            .expect("the window's test needs Xvfb (Debian: apt-get install xvfb xdotool imagemagick)");
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
        self.settings.join("pottery-studio").join("preferences.toml")
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

    /// Waits until a window besides `known` is there.
    ///
    /// # Panics
    /// When none appears.
    #[must_use]
    pub fn window(&self, known: &[String]) -> String {
        let deadline = Instant::now() + Duration::from_secs(60);
        while Instant::now() < deadline {
            let found = self.run("xdotool", &["search", "--name", "Pottery studio"]);
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
    /// Without ImageMagick.
    #[must_use]
    pub fn pixels(&self) -> Vec<u8> {
        let output = Command::new("import")
            .args(["-window", "root", "-depth", "8", "rgb:-"])
            .env("DISPLAY", &self.name)
            .output()
            .expect("the window's test needs imagemagick");
        assert_eq!(output.stdout.len(), SIZE.0 * SIZE.1 * 3, "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        drop(self.server.kill());
        drop(self.server.wait());
        drop(fs::remove_dir_all(&self.settings));
    }
}
