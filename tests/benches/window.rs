//! What a window costs and how quick it is: the first picture, at home and of a studio that is joined, a pointer's way into the picture, a
//! studio at rest, and what pictures do to the hand beside them.
//!
//! Runs the studio on a virtual display and reads what it logs and what the system counts of its threads. Drawn by the processor where
//! there is no card: these are then the figures of the automatic mode.
//! `cargo bench -p pottery-tests --bench window`; with `-- join`, `first`, `pointer`, `rest` or `hand`, those parts and nothing else.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use pottery_tests::display::{Display, SIZE};
use pottery_tests::programs::{folder, program};

/// Starts that are timed, movements of the pointer, and how long a studio rests: longer than its clay is seen to dry.
const STARTS: usize = 5;
const MOVES: usize = 60;
const DRIES: Duration = Duration::from_secs(240);
const RESTS: Duration = Duration::from_secs(30);

fn open(display: &Display) -> (Child, String) {
    open_with(display, &["--listen", "127.0.0.1:0", "--mute"])
}

fn open_with(display: &Display, arguments: &[&str]) -> (Child, String) {
    let studio = display.studio_that_logs(arguments, "warn,pottery_studio=debug,winit=error", &[]);
    // nothing looks for the window or pulls at it until its first picture is there
    std::thread::sleep(Duration::from_secs(2));
    let window = display.window(&[]);
    let (width, height) = (SIZE.0.to_string(), SIZE.1.to_string());
    display.run("xdotool", &["windowsize", "--sync", &window, &width, &height]);
    display.run("xdotool", &["windowmove", "--sync", &window, "0", "0", "windowfocus", &window]);
    std::thread::sleep(Duration::from_secs(2));
    (studio, window)
}

/// Turns of a hand that is measured without pictures and with them, and how long each is.
const TURNS: usize = 5;
const HAND_S: &str = "10";

/// What the hand's own bench says of late ticks.
struct Late {
    /// Of the hand, and of a loop with nothing to do before and after it.
    said: String,
    percent: f64,
}

/// A hand beside a server, with pictures drawn or without.
fn late(has_pictures: bool) -> Late {
    let out = folder("window-hand");
    let mut hand = Command::new(program("pottery-studio"));
    hand.args(["haptics", "--bench", "--server", "--seconds", HAND_S, "--out"]).arg(&out);
    let said = hand.args(has_pictures.then_some("--renderer")).output().expect("the studio was built");
    fs::remove_dir_all(&out).expect("what the bench wrote can be removed");
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    let line = |begin: &str| said.lines().find_map(|line| line.strip_prefix(begin)).map_or("no figures", str::trim);
    let late = line("late ");
    let percent = late.trim_end_matches(" %").rsplit(' ').next().and_then(|figure| figure.parse().ok());
    let said = ["pictures ", "machine "].iter().fold(late.to_owned(), |all, begin| match line(begin) {
        "no figures" => all,
        more => format!("{all}; {more}"),
    });
    Late { said, percent: percent.unwrap_or(f64::NAN) }
}

/// Closes it; the figures of every line that says `what`, by their names.
fn close(display: &Display, window: &str, mut studio: Child, what: &str) -> Vec<BTreeMap<String, f64>> {
    display.run("xdotool", &["windowfocus", window, "key", "Escape"]);
    let mut said = String::new();
    if let Some(mut stderr) = studio.stderr.take() {
        stderr.read_to_string(&mut said).expect("the studio's words are text");
    }
    studio.wait().expect("the studio ends");
    let lines = said.lines().filter(|line| line.contains(what));
    let figures = lines.map(|line| {
        let fields = line.split_whitespace().filter_map(|field| field.split_once('='));
        fields.filter_map(|(name, value)| Some((name.to_owned(), value.parse().ok()?))).collect()
    });
    figures.collect()
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of.get(of.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Ticks of processor time that each thread of a process has had, by their names; a tick is 10 ms.
fn threads(studio: &Child) -> BTreeMap<String, u64> {
    let mut threads = BTreeMap::new();
    let folder = format!("/proc/{}/task", studio.id());
    for task in fs::read_dir(folder).into_iter().flatten().flatten() {
        let read = |name: &str| fs::read_to_string(task.path().join(name)).unwrap_or_default();
        let (name, stat) = (read("comm"), read("stat"));
        // behind the name in brackets: state, ten figures, then user and system time
        let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
        let ticks: u64 = fields.skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
        *threads.entry(name.trim().to_owned()).or_default() += ticks;
    }
    threads
}

/// From asking to join a studio of another process over a line as on a local network, to the first picture of its pot.
fn join(display: &Display) {
    let mut server = Command::new(program("pottery-server"));
    server.args(["--listen", "127.0.0.1:0", "--no-announce", "--code", "K7QM-3XPD"]).stdout(Stdio::piped());
    let mut server = server.spawn().expect("the server was built");
    let said = BufReader::new(server.stdout.take().expect("its output was asked for")).lines().map_while(Result::ok);
    let address = said.filter_map(|line| Some(format!("127.0.0.1:{}", port(line.split_once("127.0.0.1:")?.1)))).next();
    let address = address.expect("the server says where it listens");
    let mut took = Vec::new();
    for _ in 0..STARTS {
        let arguments = ["join", &address, "--code", "K7QM-3XPD", "--network", "lan", "--mute"];
        let (studio, window) = open_with(display, &arguments);
        let lines = close(display, &window, studio, "first picture");
        took.extend(lines.iter().filter_map(|line| line.get("since_join_ms").copied()));
    }
    println!(
        "from asking to join to the first picture, on a local network: {:.0} ms (median of {}: {took:?})",
        median(took.clone()),
        took.len()
    );
    server.kill().expect("the server runs");
    server.wait().expect("the server ends");
}

fn port(text: &str) -> &str {
    text.split(|letter: char| !letter.is_ascii_digit()).next().unwrap_or_default()
}

/// From the start of the binary to the first picture of a studio of one's own.
fn first(display: &Display) {
    let mut firsts = Vec::new();
    for _ in 0..STARTS {
        let (studio, window) = open(display);
        firsts
            .extend(close(display, &window, studio, "first picture").iter().filter_map(|line| line.get("ms").copied()));
    }
    println!(
        "from the start of the binary to the first picture: {:.0} ms (median of {}: {firsts:?})",
        median(firsts.clone()),
        firsts.len()
    );
}

/// From a pointer that moves to a picture of it.
fn pointer(display: &Display) {
    let (studio, window) = open(display);
    for step in 0..MOVES {
        display.run("xdotool", &["mousemove", &(560 + 2 * step).to_string(), &(260 + 3 * step).to_string()]);
        std::thread::sleep(Duration::from_millis(150));
    }
    let moves = close(display, &window, studio, "input in picture");
    let of = |name: &str| moves.iter().filter_map(|line| line.get(name).copied()).collect::<Vec<_>>();
    let pictures = of("pictures");
    let within = pictures.iter().filter(|pictures| **pictures <= 2.0).count();
    println!(
        "from a pointer that moves to a picture of it: {:.0} pictures, {:.0} ms (medians of {}; {within} within two pictures)",
        median(pictures.clone()),
        median(of("ms")),
        pictures.len(),
    );
}

/// What a studio takes that nobody touches.
fn rest(display: &Display) {
    let (studio, window) = open(display);
    display.run("xdotool", &["mousemove", "140", "672", "key", "space"]);
    println!("a studio at rest, once its clay has dried …");
    std::thread::sleep(DRIES);
    let (before, began) = (threads(&studio), Instant::now());
    std::thread::sleep(RESTS);
    let (after, passed_s) = (threads(&studio), began.elapsed().as_secs_f64());
    let share = |name: &str, ticks: u64| (ticks - before.get(name).copied().unwrap_or(ticks)) as f64 / passed_s;
    let mut total = 0.0;
    for (name, &ticks) in &after {
        let percent = share(name, ticks);
        total += percent;
        if percent > 0.0 {
            println!("  {name:<16} {percent:5.2} % of a core");
        }
    }
    println!("  {:<16} {total:5.2} %", "together");
    close(display, &window, studio, "first picture");
}

/// What pictures do to the hand beside them: turns without and with, and what the middle ones of both say.
fn hand() {
    println!("a hand at a server's wheel, {TURNS} turns of {HAND_S} s each way:");
    let mut turns = [Vec::new(), Vec::new()];
    for turn in 0..TURNS {
        // whichever is first in one turn is second in the next, so that neither has the quieter half
        for has_pictures in [turn % 2 == 1, turn % 2 == 0] {
            let Late { said, percent } = late(has_pictures);
            println!("  {turn} {:<16} {said}", if has_pictures { "with pictures" } else { "without" });
            turns[usize::from(has_pictures)].push(percent);
        }
    }
    let spread = |of: &[f64]| {
        let (least, most) =
            of.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), late| (least.min(*late), most.max(*late)));
        format!("{:.3} % late ({least:.3} to {most:.3})", median(of.to_vec()))
    };
    println!("  medians: {} without pictures, {} with", spread(&turns[0]), spread(&turns[1]));
}

/// The parts, in the order in which they are run.
const PARTS: [&str; 5] = ["join", "first", "pointer", "rest", "hand"];

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|argument| PARTS.contains(&argument.as_str())).collect();
    let display = Display::new();
    for part in PARTS.into_iter().filter(|part| asked.is_empty() || asked.iter().any(|asked| asked == part)) {
        match part {
            "join" => join(&display),
            "first" => first(&display),
            "pointer" => pointer(&display),
            "rest" => rest(&display),
            _ => hand(),
        }
    }
}
