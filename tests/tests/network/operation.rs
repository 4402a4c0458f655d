//! A server as its operator runs it: pots that outlast it, pages that are asked for, settings, logs, and who knocks too often.
//!
//! Real sockets and the real binary; what is measured in time is a bound that a busy machine keeps.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use pottery_client::device::ScriptedDevice;
use pottery_client::stroke::Stroke;
use pottery_client::{JoinError, Onlooker, Potter, PotterOptions, Target, client_config, endpoint};
use pottery_files::pot_file::PotFile;
use pottery_server::{Arrivals, Input, Server, ServerConfig, ServerError, StoreError};
use pottery_shared::clay::{Conditions, Material, Pot, PotSpec, Preset};
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::programs::{folder, program};

const PATIENCE: Duration = Duration::from_secs(20);

fn config() -> ServerConfig {
    ServerConfig { listen: SocketAddr::from(([127, 0, 0, 1], 0)), ..ServerConfig::default() }
}

fn target(server: &Server, wheel: u16) -> Target {
    Target::new(server.address().to_string(), server.code().clone(), wheel)
}

/// Presses at a wheel for a while and leaves with everything confirmed.
async fn press(target: &Target, seconds: f32) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/strokes/waist.csv");
    let device = Box::new(ScriptedDevice::new(Arc::new(Stroke::read(&path).unwrap())));
    let own = endpoint().unwrap();
    let potter = Potter::join(&own, target, device, PotterOptions::default()).await.unwrap();
    tokio::time::sleep(Duration::from_secs_f32(seconds)).await;
    assert!(potter.settle(PATIENCE).await);
    potter.leave().await.unwrap();
    own.close(0_u32.into(), b"");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn pots_outlast_the_server_and_are_gone_on_with_or_put_aside() {
    let data = folder("data").join("pots");
    let kept = ServerConfig { wheels: 2, data: Some(data.clone()), ..config() };
    let server = Server::start(kept.clone()).unwrap();
    press(&target(&server, 2), 1.6).await;
    // everybody has left: the pot is written long before half a minute has passed
    let file = data.join("wheel-2.pot");
    let began = Instant::now();
    while !file.exists() {
        assert!(began.elapsed() < PATIENCE, "the pot of a wheel that was left is not written");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let digests = server.standing().await.unwrap().digests;
    server.stop().await;
    assert!(!data.join("wheel-1.pot").exists(), "what nobody touched is not worth a file");
    let pressed = PotFile::read(&file).unwrap();

    let server = Server::start(kept.clone()).unwrap();
    let standing = server.standing().await.unwrap();
    assert_eq!(standing.digests[0], digests[0]);
    assert_eq!(standing.pots[1].digest(), pressed.pot().pot().digest(), "the next day goes on with it");
    // and what happens on the next day is kept by the clean stop, without waiting
    press(&target(&server, 1), 1.6).await;
    server.stop().await;
    let first = PotFile::read(&data.join("wheel-1.pot")).unwrap();

    let server = Server::start(ServerConfig { is_fresh: true, ..kept.clone() }).unwrap();
    assert_eq!(server.standing().await.unwrap().digests, [digests[0]; 2], "new pots on both wheels");
    server.stop().await;
    assert_eq!(PotFile::read(&data.join("wheel-1-before-1.pot")).unwrap(), first);
    assert_eq!(PotFile::read(&data.join("wheel-2-before-1.pot")).unwrap(), pressed);

    fs::write(&file, b"no pot").unwrap();
    let error = Server::start(kept).unwrap_err();
    assert!(matches!(error, ServerError::Store(StoreError::Pot { .. })), "{error}");
    assert!(error.to_string().contains("wheel-2.pot") && error.to_string().contains("--fresh"), "{error}");
    assert_eq!(fs::read(&file).unwrap(), b"no pot", "and it is left as it was");
    fs::remove_dir_all(data.parent().unwrap()).unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_kept_pot_is_gone_on_with_in_the_clay_and_at_the_speed_that_it_was_left_in() {
    let data = folder("clay");
    let [throwing, soft, stiff] =
        [Preset::Throwing, Preset::Soft, Preset::Stiff].map(|preset| Material::from_wetness(preset.wetness()));
    let kept = ServerConfig { wheels: 2, data: Some(data.clone()), clay: throwing, ..config() };
    let server = Server::start(kept.clone()).unwrap();
    // makes clay and speed of the second wheel others, presses nothing, and leaves
    let own = endpoint().unwrap();
    let still = || Box::new(ScriptedDevice::new(Arc::new(Stroke::parse("t_s,x_mm,y_mm,z_mm\n0,90,0,100\n").unwrap())));
    let potter = Potter::join(&own, &target(&server, 2), still(), PotterOptions::default()).await.unwrap();
    assert!(potter.command(pottery_client::Command::Clay(soft)));
    assert!(potter.command(pottery_client::Command::WheelSpeed(Rpm(-150.0))));
    let seen = |potter: &Potter| {
        let (own, view) = (potter.tick(), potter.view().lock());
        let tick = Tick(own.0.saturating_add_signed(view.tick_offset));
        (view.conditions.material.at(tick), view.conditions.wheel.speed(tick).0.round())
    };
    let began = Instant::now();
    while seen(&potter) != (soft, -150.0) {
        assert!(began.elapsed() < PATIENCE, "clay and speed do not become others");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    potter.leave().await.unwrap();
    server.stop().await;
    assert_eq!(PotFile::read(&data.join("wheel-2.pot")).unwrap().clay(), soft);
    assert!(!data.join("wheel-1.pot").exists(), "nothing has changed there");

    // the settings are for new pots
    let server = Server::start(ServerConfig { clay: stiff, ..kept }).unwrap();
    for (wheel, clay, rpm) in [(1, stiff, 60.0), (2, soft, -150.0)] {
        let potter = Potter::join(&own, &target(&server, wheel), still(), PotterOptions::default()).await.unwrap();
        assert_eq!(seen(&potter), (clay, rpm), "at wheel {wheel}");
        potter.leave().await.unwrap();
    }
    server.stop().await;
    fs::remove_dir_all(data).unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_disk_that_takes_nothing_is_said_and_the_lesson_goes_on() {
    let data = folder("full");
    // a folder stands where the file should
    fs::create_dir(data.join("wheel-1.pot")).unwrap();
    fs::write(data.join("wheel-1.pot").join("in the way"), "").unwrap();
    let refused = Server::start(ServerConfig { data: Some(data.clone()), ..config() }).unwrap_err().to_string();
    assert!(refused.contains("wheel-1.pot"), "{refused}");
    fs::remove_dir_all(data.join("wheel-1.pot")).unwrap();

    let operate = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
    let server = Server::start(ServerConfig { data: Some(data.clone()), operate, ..config() }).unwrap();
    fs::create_dir(data.join("wheel-1.pot")).unwrap();
    press(&target(&server, 1), 1.6).await;
    let began = Instant::now();
    while figure(&get(server.operated_at().unwrap(), "/metrics"), "pottery_pots_unwritten") == 0.0 {
        assert!(began.elapsed() < PATIENCE, "nobody says that the pot is not written");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    // the lesson goes on, and so does the keeping once there is room
    fs::remove_dir(data.join("wheel-1.pot")).unwrap();
    press(&target(&server, 1), 1.6).await;
    server.stop().await;
    assert!(PotFile::read(&data.join("wheel-1.pot")).is_ok());
    fs::remove_dir_all(data).unwrap();
}

/// What a server of its own process says of itself at first.
struct Own {
    child: Child,
    address: String,
    code: String,
}

impl Own {
    /// Waits until a server that was started listens.
    fn new(mut child: Child) -> Self {
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
        let mut said = |begin: &str| {
            let line = lines.by_ref().find(|line| line.starts_with(begin));
            line.unwrap_or_else(|| panic!("it does not say '{begin}'"))[begin.len()..].trim().to_owned()
        };
        let (address, code) = (said("listening on"), said("join code"));
        // what else it says is read to the end, so that it can go on
        std::thread::spawn(move || lines.for_each(drop));
        Self { child, address, code }
    }

    fn target(&self, wheel: u16) -> Target {
        Target::new(self.address.clone(), self.code.parse().unwrap(), wheel)
    }
}

#[test]
fn pots_that_are_kept_and_of_another_make_than_is_asked_for_are_told_of() {
    let data = folder("unlike");
    let pot = Pot::new(PotSpec::default()).unwrap();
    PotFile::of(&pot, &Conditions::default(), Tick(0)).write(&data.join("wheel-1.pot")).unwrap();
    let logged = |flags: &[&str]| {
        let mut command = Command::new(program("pottery-server"));
        command.args(["--listen", "127.0.0.1:0", "--data", data.to_str().unwrap()]).args(flags);
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut own = Own::new(child);
        assert!(terminate(&mut own.child));
        let mut log = String::new();
        own.child.stderr.take().unwrap().read_to_string(&mut log).unwrap();
        log
    };
    let same = logged(&[]);
    assert!(!same.contains("gone on with"), "{same}");
    let other = logged(&["--support", "hollow", "--method", "improved"]);
    for words in
        ["gone on with as they are: backed", "--fresh): hollow", "the plastic method are gone on with by the improved"]
    {
        assert!(other.contains(words), "{words}: {other}");
    }
    assert!(!other.contains("does not bend"), "the kept one is backed: {other}");
    let stiff = logged(&["--fresh", "--support", "hollow", "--method", "improved"]);
    assert!(stiff.contains("a hollow pot's wall does not bend by the improved method"), "{stiff}");
    fs::remove_dir_all(data).unwrap();
}

/// A disk that takes a kilobyte a file and no more, as the shell limits it.
#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn on_a_full_disk_the_lesson_goes_on_and_a_pot_that_was_kept_stays() {
    let data = folder("full-disk");
    let server = Server::start(ServerConfig { data: Some(data.clone()), ..config() }).unwrap();
    press(&target(&server, 1), 1.6).await;
    server.stop().await;
    let file = data.join("wheel-1.pot");
    let kept = fs::read(&file).unwrap();
    assert!(kept.len() > 1024, "the pot would fit: {} bytes", kept.len());

    // a port that was free a moment ago
    let operate = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let child = Command::new("bash")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$@\"", "bash"])
        .arg(program("pottery-server"))
        .args(["--listen", "127.0.0.1:0", "--no-announce", "--operate", &operate.to_string(), "--data"])
        .arg(&data)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut own = Own::new(child);
    press(&own.target(1), 1.6).await;
    let began = Instant::now();
    while figure(&get(operate, "/metrics"), "pottery_pots_unwritten") == 0.0 {
        assert!(began.elapsed() < PATIENCE, "nobody says that the pot is not written");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert!(get(operate, "/readyz").ends_with("the room answers\n"));
    press(&own.target(1), 0.5).await;
    assert!(!terminate(&mut own.child), "a pot is lost");
    let mut log = String::new();
    own.child.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    assert!(log.contains("the lesson goes on") && !log.contains("panicked"), "{log}");
    assert!(log.ends_with("not everything was kept (1 pot): the log says why\n") && !log.contains('\x1b'), "{log}");
    assert!(fs::read(&file).unwrap() == kept, "the pot of before is as it was");
    assert_eq!(fs::read_dir(&data).unwrap().filter(|entry| !is_kept_for_good(entry.as_ref().unwrap())).count(), 0);
    fs::remove_dir_all(data).unwrap();
}

/// Not even who may do everything can make a file there.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_nothing_is_refused_at_the_start() {
    for (path, word) in [("/proc/self/task", "--data"), ("/etc/passwd", "no folder"), ("/proc/pots", "--data")] {
        let output = server(&["--listen", "127.0.0.1:0", "--no-announce", "--data", path], &[]);
        let sentence = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && sentence.contains(path) && sentence.contains(word), "{sentence}");
        assert_eq!(sentence.lines().count(), 1, "{sentence}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_second_server_on_a_folder_is_refused_and_the_first_goes_on() {
    let data = folder("taken");
    let kept = ServerConfig { data: Some(data.clone()), ..config() };
    let first = Server::start(kept.clone()).unwrap();
    let output = server(&["--listen", "127.0.0.1:0", "--no-announce", "--data", data.to_str().unwrap()], &[]);
    let sentence = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && sentence.contains("another server uses the folder"), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    press(&target(&first, 1), 0.5).await;
    first.stop().await;
    Server::start(kept).unwrap().stop().await;
    fs::remove_dir_all(data).unwrap();
}

/// Whether a file of a data folder is one of those that are meant to be there.
#[cfg(target_os = "linux")]
fn is_kept_for_good(entry: &fs::DirEntry) -> bool {
    let name = entry.file_name().into_string().unwrap();
    ["wheel-", "server-key", "server-certificate", "server.lock", "teacher-token"]
        .iter()
        .any(|begin| name.starts_with(begin))
}

/// What a page says, with its head.
fn get(address: SocketAddr, path: &str) -> String {
    request(address, &format!("GET {path} HTTP/1.1\r\nhost: pottery\r\n\r\n"))
}

fn request(address: SocketAddr, request: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn figure(page: &str, name: &str) -> f64 {
    let line = page.lines().find(|line| line.split(' ').next() == Some(name));
    line.unwrap_or_else(|| panic!("{name} in {page}")).rsplit(' ').next().unwrap().parse().unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn operators_are_answered_on_this_machine_and_nothing_else_is() {
    let operate = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
    let server = Server::start(ServerConfig { wheels: 3, operate, ..config() }).unwrap();
    let address = server.operated_at().unwrap();
    assert!(get(address, "/livez").starts_with("HTTP/1.1 200 OK"));
    assert!(get(address, "/readyz").ends_with("the room answers\n"));
    let own = endpoint().unwrap();
    let device = Box::new(ScriptedDevice::new(Arc::new(Stroke::parse("t_s,x_mm,y_mm,z_mm\n0,90,0,100\n").unwrap())));
    let potter = Potter::join(&own, &target(&server, 2), device, PotterOptions::default()).await.unwrap();
    let began = Instant::now();
    let page = loop {
        let page = get(address, "/metrics");
        let datagrams = figure(&page, "pottery_datagrams_total");
        let [ticks, wakes] = ["pottery_ticks_total", "pottery_wake_seconds_count"].map(|name| figure(&page, name));
        if datagrams > 0.0 && ticks > 100.0 && wakes > 10.0 {
            break page;
        }
        assert!(began.elapsed() < PATIENCE, "the room does hardly anything: {page}");
        tokio::time::sleep(Duration::from_millis(10)).await;
    };
    assert_eq!(figure(&page, "pottery_people"), 1.0);
    assert_eq!(figure(&page, "pottery_wheel_people{wheel=\"2\"}"), 1.0);
    assert_eq!(figure(&page, "pottery_wheel_people{wheel=\"3\"}"), 0.0);
    assert!(figure(&page, "pottery_datagrams_total") > 0.0 && figure(&page, "pottery_ticks_total") > 100.0);
    assert!(figure(&page, "pottery_wake_seconds_count") > 10.0);
    for (asked, answer) in [
        ("GET /people HTTP/1.1\r\nhost: pottery\r\n\r\n", "404"),
        ("POST /metrics HTTP/1.1\r\nhost: pottery\r\ncontent-length: 0\r\n\r\n", "405"),
        ("nonsense\r\n\r\n", "400"),
    ] {
        let said = request(address, asked);
        assert!(said.starts_with(&format!("HTTP/1.1 {answer}")), "{asked:?}: {said}");
    }
    potter.leave().await.unwrap();
    server.stop().await;
    assert!(TcpStream::connect(address).is_err(), "the port is free again");

    let outside = ServerConfig { operate: Some(SocketAddr::from(([192, 0, 2, 1], 4748))), ..config() };
    let error = Server::start(outside).unwrap_err().to_string();
    assert!(error.contains("this machine alone") && error.contains("192.0.2.1"), "{error}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_guesses_codes_is_kept_waiting_and_the_class_works_on() {
    let arrivals = Arrivals { burst: 20, per_s: 2, wrong_code_costs: 4, exempts_loopback: false };
    let server = Server::start(ServerConfig { arrivals, ..config() }).unwrap();
    let right = target(&server, 1);
    let own = endpoint().unwrap();
    let inside = Onlooker::join(&own, &right, 100_000).await.unwrap();
    let mut wrong = right.clone();
    wrong.code = "00000000".parse().unwrap();
    // as fast as they come, for a second, or until it was tried often enough: each guess is five arrivals
    let began = Instant::now();
    let mut guesses = Vec::new();
    while began.elapsed() < Duration::from_secs(1) || guesses.len() < 100 {
        for _ in 0..10 {
            let (own, wrong) = (own.clone(), wrong.clone());
            guesses.push(tokio::spawn(async move {
                tokio::time::timeout(Duration::from_secs(2), Onlooker::join(&own, &wrong, 1_000)).await
            }));
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let made = guesses.len();
    let mut answered = 0;
    for guess in guesses {
        match guess.await.unwrap() {
            Ok(Err(JoinError::Session(_))) => answered += 1,
            Ok(Err(_)) | Err(_) => {}
            Ok(Ok(_)) => panic!("a wrong code lets nobody in"),
        }
    }
    assert!(made >= 100 && answered <= 30, "{answered} of {made} guesses were answered");
    let standing = server.standing().await.unwrap();
    assert_eq!(standing.people, 1, "who was in is still in");
    // and somebody with the right code comes in from the same address once the guessing has stopped
    tokio::time::sleep(Duration::from_secs(6)).await;
    let late = tokio::time::timeout(PATIENCE, Onlooker::join(&own, &right, 100_000)).await.unwrap().unwrap();
    late.leave().await.unwrap();
    inside.leave().await.unwrap();
    server.stop().await;
}

/// A room for one person has 256 places for those who only knock, from wherever they come.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_only_knocks_takes_no_more_places_than_there_are_and_whoever_means_it_comes_in() {
    const PLACES: usize = 257;
    let server = Server::start(ServerConfig { people_max: 1, is_announced: false, ..config() }).unwrap();
    let knocking = endpoint().unwrap();
    let knock = || {
        let config = client_config(server.code()).unwrap();
        knocking.connect_with(config, server.address(), "pottery").unwrap()
    };
    let mut held = Vec::new();
    for number in 0..PLACES {
        held.push(knock().await.unwrap_or_else(|error| panic!("knock {number}: {error}")));
    }
    // they say nothing, and are held for ten seconds
    assert!(tokio::time::timeout(Duration::from_millis(500), knock()).await.is_err(), "there is a place more");
    for connection in held.drain(..) {
        connection.close(0_u32.into(), b"");
    }
    press(&target(&server, 1), 0.2).await;
    knocking.close(0_u32.into(), b"");
    server.stop().await;
}

fn server(arguments: &[&str], environment: &[(&str, &str)]) -> Output {
    let mut command = Command::new(program("pottery-server"));
    command.args(arguments).envs(environment.iter().copied()).output().unwrap()
}

fn said(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn settings_come_from_flags_then_environment_then_file_then_defaults_and_can_be_printed() {
    let out = folder("settings");
    let file = out.join("class.toml");
    fs::write(
        &file,
        "wheels = 4\npeople_max = 40\nclay = \"soft\"\n[arrivals]\nburst = 500\n[input]\nspare_people = 2\n",
    )
    .unwrap();
    let path = file.to_str().unwrap();
    let printed = |arguments: &[&str], environment: &[(&str, &str)]| {
        let arguments = [&["--print-config", "--config", path], arguments].concat();
        said(&server(&arguments, environment)).parse::<toml::Table>().unwrap()
    };
    let plain = printed(&[], &[]);
    assert_eq!((plain["wheels"].as_integer(), plain["people_max"].as_integer()), (Some(4), Some(40)));
    assert_eq!(plain["arrivals"]["burst"].as_integer(), Some(500));
    assert_eq!(plain["arrivals"]["per_s"].as_integer(), Some(i64::from(Arrivals::default().per_s)));
    assert_eq!(plain["input"]["spare_people"].as_integer(), Some(2));
    assert_eq!(plain["input"]["datagrams_per_s"].as_integer(), Some(i64::from(Input::default().datagrams_per_s)));
    assert_eq!(printed(&[], &[("POTTERY_WHEELS", "6")])["wheels"].as_integer(), Some(6));
    assert_eq!(printed(&["--wheels", "8"], &[("POTTERY_WHEELS", "6")])["wheels"].as_integer(), Some(8));
    // a flag stands before the environment also where both say what the clay is, and both before the file
    let wetness = |arguments: &[&str], environment: &[(&str, &str)]| {
        (printed(arguments, environment)["wetness"].as_float().unwrap() * 1e3).round()
    };
    assert_eq!(wetness(&["--wetness", "0.5"], &[("POTTERY_CLAY", "soft")]), 500.0);
    assert_eq!(wetness(&["--clay", "soft"], &[("POTTERY_WETNESS", "0.5")]), wetness(&[], &[]));
    assert_eq!(wetness(&[], &[("POTTERY_WETNESS", "0.5")]), 500.0);
    assert_eq!(printed(&[], &[("POTTERY_METHOD", "improved")])["method"].as_str(), Some("improved"));
    let coarse = printed(&[], &[("POTTERY_SMALLEST_TOOL_MM", "10")]);
    assert!(coarse["columns"].as_integer() < plain["columns"].as_integer());
    // what needs something else finds it in the file
    let needs = out.join("needs.toml");
    fs::write(&needs, "smallest_tool_mm = 4\ndata = \"pots\"\n").unwrap();
    let both = ["--print-config", "--fresh", "--finest-view-mm", "2", "--config", needs.to_str().unwrap()];
    let both = said(&server(&both, &[])).parse::<toml::Table>().unwrap();
    assert_eq!((both["columns"].as_integer(), both["rows"].as_integer()), (Some(189), Some(101)));
    // what is printed is a file of settings, and says the same when it is read
    let again = out.join("again.toml");
    fs::write(&again, toml::to_string(&plain).unwrap()).unwrap();
    let read = said(&server(&["--print-config", "--config", again.to_str().unwrap()], &[]));
    assert_eq!(read.parse::<toml::Table>().unwrap(), plain);

    for (text, word) in [
        ("wheel = 4\n", "wheel"),
        ("[arrivals]\nbrust = 4\n", "brust"),
        ("[arrivals]\nburst = 0\n", "burst"),
        ("[input]\nspare = 4\n", "spare"),
        ("[input]\ndatagrams_per_s = 20\n", "from 100 to"),
        ("operate = \"0.0.0.0:4748\"\n", "this machine alone"),
        ("data = \"\"\n", "'data' is empty"),
        ("code = \"K7QM-3XPD-1111-1111-1111-1111\"\n", "eight characters of the room alone"),
    ] {
        fs::write(&file, text).unwrap();
        let output = server(&["--config", path, "--print-config"], &[]);
        let sentence = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && sentence.contains(word), "{text}: {sentence}");
        assert!(!sentence.contains("panicked"), "{sentence}");
    }
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn a_flag_that_cannot_be_meant_is_refused_with_what_can() {
    for (arguments, word) in [
        (&["--fresh"][..], "--data"),
        (&["--finest-view-mm", "2"], "smallest_tool_mm"),
        (&["--code", "K7QM-3XPD-1111-1111-1111-1111"], "eight characters of the room alone"),
        (&["--clay", "soft", "--wetness", "0.5"], "--wetness"),
        (&["--listen", "localhost:5000"], "127.0.0.1:5000"),
        (&["--listen", "127.0.0.1"], "127.0.0.1:5000"),
        (&["--wheels", "1000000"], "from 1 to 1024"),
        (&["--people", "99999999999"], "from 1 to 4096"),
        (&["--smallest-tool-mm", "41"], "from 0.5 to 40 ("),
        (&["--listen", "192.0.2.1:5000"], "an address of this machine"),
        (&["console", "freeze", "-1"], "say 'freeze WHEEL'"),
    ] {
        let output = server(arguments, &[]);
        let sentence = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && sentence.contains(word), "{arguments:?}: {sentence}");
    }
    for (arguments, said) in [(&[][..], "'abc' for POTTERY_WHEELS in the"), (&["--wheels=0"], "'0' for '--wheels ")] {
        let output = server(arguments, &[("POTTERY_WHEELS", "abc")]);
        let sentence = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(sentence.contains(said) && sentence.contains("from 1 to 1024"), "{arguments:?}: {sentence}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_printed_is_said_in_a_sentence() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let printed = Command::new(program("pottery-server")).arg("--print-config").stdout(full).output().unwrap();
    let sentence = String::from_utf8(printed.stderr).unwrap();
    assert!(!printed.status.success() && sentence.contains("cannot be printed"), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
}

/// Ends a program as an operator's system does, and waits; whether it says that all is well.
fn terminate(server: &mut Child) -> bool {
    Command::new("kill").arg(server.id().to_string()).status().unwrap();
    let began = Instant::now();
    while server.try_wait().unwrap().is_none() {
        assert!(began.elapsed() < PATIENCE, "it does not end");
        std::thread::sleep(Duration::from_millis(20));
    }
    server.wait().unwrap().success()
}

#[test]
fn a_server_whose_words_nobody_reads_any_more_goes_on_and_ends_well() {
    let mut server = Command::new(program("pottery-server"))
        .args(["--listen", "127.0.0.1:0", "--figures", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut said = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut said).unwrap();
    assert!(said.starts_with("listening on"), "{said}");
    // the pipe is closed now; it has more to say of how it began, of every second, and at its end
    std::thread::sleep(Duration::from_millis(1500));
    assert!(server.try_wait().unwrap().is_none(), "it ended");
    assert!(terminate(&mut server));
}

#[test]
fn a_log_for_programs_is_an_object_a_line() {
    let mut server = Command::new(program("pottery-server"))
        .args(["--listen", "127.0.0.1:0", "--log", "json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(server.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("join code")));
    assert!(terminate(&mut server));
    let mut log = String::new();
    server.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    let entries: Vec<serde_json::Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let says = |what: &str| entries.iter().any(|entry| entry["fields"]["message"] == what);
    assert!(says("the studio is open") && says("the studio is closed"), "{log}");
}

/// A file of the folder that says how the server is run for others.
fn deployed(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy").join(name)).unwrap()
}

#[test]
fn what_is_deployed_uses_flags_and_variables_that_exist() {
    let help = said(&server(&["--help"], &[]));
    let unit = deployed("pottery-server.service");
    let start = unit.lines().find_map(|line| line.strip_prefix("ExecStart=")).unwrap();
    let flags: Vec<&str> = start.split(' ').filter(|word| word.starts_with("--")).collect();
    assert!(flags.len() >= 4, "{start}");
    let image = deployed("Containerfile");
    let page = deployed("README.md");
    let of_page = page.split(['`', ' ', '\n']).filter(|word| word.starts_with("--"));
    let of_others = [
        "--file",
        "--tag",
        "--rm",
        "--publish",
        "--volume",
        "--env",
        "--now",
        "--unit",
        "--output",
        "--release",
        "--package",
    ];
    for flag in flags.into_iter().chain(of_page).filter(|flag| !of_others.contains(flag)) {
        assert!(help.contains(flag), "{flag} is not known to the server");
    }
    for variable in image.lines().filter_map(|line| line.strip_prefix("ENV ")) {
        let name = variable.split('=').next().unwrap();
        assert!(help.contains(name), "{name} is not known to the server");
    }
    // what is built is taken in, and nothing else
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let workspace: toml::Table = fs::read_to_string(root.join("Cargo.toml")).unwrap().parse().unwrap();
    for member in workspace["workspace"]["members"].as_array().unwrap() {
        let folder = member.as_str().unwrap().split('/').next().unwrap();
        assert!(image.contains(&format!("\nCOPY {folder} {folder}\n")), "the image does not take {folder} in");
    }
    // the toolchain of the image is the project's
    let toolchain: toml::Table = fs::read_to_string(root.join("rust-toolchain.toml")).unwrap().parse().unwrap();
    let channel = toolchain["toolchain"]["channel"].as_str().unwrap();
    assert!(image.contains(&format!("rust:{channel}-alpine")), "the image is built with Rust {channel}");
    // what the system says of the unit, where it can be asked
    let unit = root.join("deploy/pottery-server.service");
    if let Ok(checked) = Command::new("systemd-analyze").arg("verify").arg(unit).output() {
        let trouble = String::from_utf8_lossy(&checked.stderr).into_owned();
        // a program that is not installed here is no fault of the unit's
        let faults =
            trouble.lines().filter(|line| !line.contains("is not executable") && line.contains("pottery-server"));
        assert_eq!(faults.collect::<Vec<_>>(), Vec::<&str>::new());
    }
}

/// Words of an instruction of the container image.
fn instruction<'a>(image: &'a str, name: &str) -> Vec<&'a str> {
    // what comes last counts: the stage before it only builds
    let from = image.rfind("FROM scratch").unwrap();
    image[from..].lines().filter_map(|line| line.strip_prefix(name)).map(str::trim).collect()
}

/// Copies what a program is linked with into a root, where it looks for it.
#[cfg(target_os = "linux")]
fn copy_libraries(program: &Path, root: &Path) {
    let said = Command::new("ldd").arg(program).output().unwrap();
    let said = String::from_utf8(said.stdout).unwrap();
    for library in said.split_whitespace().filter(|word| word.starts_with('/')) {
        let copy = root.join(&library[1..]);
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::copy(library, copy).unwrap();
    }
}

/// As a container has it: a root with nothing but the program, what the image sets, no user of a name, the first process there is.
/// The image's is linked with nothing, so that the libraries that are copied for this one are the only difference.
#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn in_a_root_with_nothing_else_the_image_s_server_keeps_pots_and_ends_well() {
    use std::os::unix::fs::{MetadataExt, chown};
    let image = deployed("Containerfile");
    let entry: Vec<String> = serde_json::from_str(instruction(&image, "ENTRYPOINT")[0]).unwrap();
    assert_eq!(entry, ["/pottery-server"]);
    let copied = instruction(&image, "COPY");
    assert!(
        copied.len() == 2 && copied[0].ends_with(" /pottery-server") && copied[1].ends_with(" /pots"),
        "{copied:?}"
    );
    assert_eq!(instruction(&image, "VOLUME"), ["/pots"]);
    let (user, group) = instruction(&image, "USER")[0].split_once(':').unwrap();
    let root = folder("image");
    fs::copy(program("pottery-server"), root.join("pottery-server")).unwrap();
    copy_libraries(&program("pottery-server"), &root);
    let pots = root.join("pots");
    fs::create_dir(&pots).unwrap();

    let mut command = Command::new("unshare");
    command.args(["--fork", "--pid", "--kill-child"]).arg("--root").arg(&root);
    if fs::metadata(&root).unwrap().uid() == 0 {
        chown(&pots, Some(user.parse().unwrap()), Some(group.parse().unwrap())).unwrap();
        command.args(["--setgid", group, "--setuid", user]);
    } else {
        // whoever is not root has that right in a space of names of their own alone
        command.arg("--map-root-user");
    }
    command.args(&entry).args(["--listen", "127.0.0.1:0"]).env_clear();
    for variable in instruction(&image, "ENV") {
        let (name, value) = variable.split_once('=').unwrap();
        command.env(name, value);
    }
    // unshare itself is looked for, and nothing else
    command.env("PATH", std::env::var_os("PATH").unwrap());
    let mut own = Own::new(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    press(&own.target(1), 1.6).await;
    // the signal that ends a container goes to its first process
    let id = own.child.id();
    let first = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap();
    Command::new("kill").arg(first.trim()).status().unwrap();
    let began = Instant::now();
    while own.child.try_wait().unwrap().is_none() {
        assert!(began.elapsed() < PATIENCE, "it does not end");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let mut log = String::new();
    own.child.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    assert!(own.child.wait().unwrap().success() && log.contains("the studio is closed"), "{log}");
    assert!(PotFile::read(&pots.join("wheel-1.pot")).is_ok(), "{log}");
    fs::remove_dir_all(root).unwrap();
}
