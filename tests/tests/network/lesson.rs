//! A lesson over real sockets: seats that are kept, keys and tokens that are kept, studios that find one another, and the console.
//!
//! Real QUIC on loopback, real multicast on this machine, and the real binary; no figure here is judged by the clock.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::{Device, ScriptedDevice};
use pottery_client::stroke::Stroke;
use pottery_client::view::{Link, View};
use pottery_client::{JoinError, Onlooker, Potter, PotterOptions, Target, endpoint, find};
use pottery_server::{Certificate, Server, ServerConfig, ServerError};
use pottery_shared::haptics::DeviceSpecs;
use pottery_shared::protocol::{
    self, JoinCode, NoGuidance, NoOrder, NoTool, Order, Presence, Refusal, Role, TeacherToken,
};
use pottery_shared::session::ClientError;
use pottery_shared::tool::Tool;
use pottery_tests::programs::{folder, program};

const PATIENCE: Duration = Duration::from_secs(30);

fn config() -> ServerConfig {
    ServerConfig { listen: SocketAddr::from(([127, 0, 0, 1], 0)), wheels: 3, ..ServerConfig::default() }
}

fn target(server: &Server, wheel: u16) -> Target {
    Target::new(server.address().to_string(), server.code().clone(), wheel)
}

fn teachers(server: &Server) -> Target {
    Target { teacher: server.teacher_token().copied(), ..target(server, 1) }
}

async fn join(target: &Target) -> Result<(quinn::Endpoint, Potter), JoinError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/strokes/waist.csv");
    join_with(target, Box::new(ScriptedDevice::new(Arc::new(Stroke::read(&path).unwrap())))).await
}

async fn join_with(target: &Target, device: Box<dyn Device>) -> Result<(quinn::Endpoint, Potter), JoinError> {
    let own = endpoint().unwrap();
    let potter = Potter::join(&own, target, device, PotterOptions::default()).await?;
    Ok((own, potter))
}

/// A hand that rubs up and down, for ever.
#[derive(Debug)]
struct Rubbing;

impl Device for Rubbing {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        Some(Vec3::new(0.0705, 0.0, 0.1 + 0.03 * (seconds as f32).sin()))
    }

    fn tool(&self) -> Tool {
        Tool::default()
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }
}

async fn until(potter: &Potter, what: &str, is_so: impl Fn(&View) -> bool) -> Duration {
    let began = Instant::now();
    while !is_so(&potter.view().lock()) {
        assert!(began.elapsed() < PATIENCE, "{what}: {:?}", potter.view().lock().class);
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    began.elapsed()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_teacher_seats_a_student_who_goes_on_at_another_wheel() {
    let server = Server::start(config()).unwrap();
    let (_teachers_end, teacher) = join(&teachers(&server)).await.unwrap();
    let (_students_end, student) = join(&target(&server, 1)).await.unwrap();
    until(&teacher, "everybody is told of", |view| view.class.people().count() == 2 && view.class.class().is_some())
        .await;
    let place = teacher.view().lock().class.place().copied().unwrap();
    assert_eq!(place.role, Role::Teacher);
    let client = student.view().lock().number;
    let name = student.view().lock().class.place().unwrap().name;
    tokio::time::sleep(Duration::from_millis(700)).await;
    assert!(teacher.command(pottery_client::Command::Order(Order::Seat { client, wheel: 3, works: true })));
    let is_there = |view: &View| {
        view.link == Link::Open && view.class.place().is_some_and(|place| place.wheel == 3 && place.may_press)
    };
    println!("at the other wheel after {:?}", until(&student, "it is at wheel 3", is_there).await);
    let after = student.view().lock().class.place().copied().unwrap();
    assert_eq!((after.client, after.name), (client, name));
    // it presses there, and what it sees is what is there
    tokio::time::sleep(Duration::from_millis(1500)).await;
    let began = Instant::now();
    loop {
        let pots = server.standing().await.unwrap().pots;
        if pots[2].digest() != pots[1].digest() {
            break;
        }
        assert!(began.elapsed() < PATIENCE, "nothing is pressed at the other wheel");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(student.settle(PATIENCE).await);
    let standing = server.standing().await.unwrap();
    assert!(standing.pots[2].digest() != standing.pots[1].digest(), "the stroke goes on at the other wheel");
    assert_eq!(student.view().lock().digest, standing.digests[2]);
    // a frozen wheel lifts the tool
    assert!(teacher.command(pottery_client::Command::Order(Order::Freeze { wheel: 0, is_frozen: true })));
    until(&student, "it is told that the wheel is frozen", |view| !view.class.may_press()).await;
    assert!(student.status().is_held());
    // and the end sends it home
    assert!(teacher.command(pottery_client::Command::Order(Order::End)));
    until(&student, "it is sent home", |view| view.link == Link::Closed).await;
    assert_eq!(teacher.view().lock().link, Link::Open);
    let report = student.leave().await.unwrap();
    assert_eq!(report.network.mismatches, 0);
    teacher.leave().await.unwrap();
    server.stop().await;
}

fn refusal<T>(outcome: Result<T, JoinError>) -> Refusal {
    match outcome {
        Err(JoinError::Session(ClientError::Refused(refusal))) => refusal,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("let in"),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn token_and_key_outlast_the_server_and_the_token_is_shown_once() {
    let data = folder("kept");
    let kept = ServerConfig { data: Some(data.clone()), ..config() };
    let server = Server::start(kept.clone()).unwrap();
    let token = *server.teacher_token().unwrap();
    let print = *server.code().print().unwrap();
    server.stop().await;
    for entry in fs::read_dir(&data).unwrap() {
        let path = entry.unwrap().path();
        let bytes = fs::read(&path).unwrap();
        let shows = bytes.windows(32).any(|window| window == token.0);
        assert!(
            !shows && !String::from_utf8_lossy(&bytes).contains(&token.to_string()),
            "{} has the token",
            path.display()
        );
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(data.join("server-key.der")).unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0, "others can read the key");
    }
    let server = Server::start(kept.clone()).unwrap();
    assert!(server.teacher_token().is_none(), "it is shown once");
    assert_eq!(server.code().print(), Some(&print));
    let with = |token| Target { teacher: Some(token), ..target(&server, 2) };
    let (_end, teacher) = join(&with(token)).await.unwrap();
    assert_eq!(until(&teacher, "is told its role", |view| view.class.place().is_some()).await.as_secs() / 60, 0);
    assert_eq!(teacher.view().lock().class.place().unwrap().role, Role::Teacher);
    teacher.leave().await.unwrap();
    server.stop().await;

    let server = Server::start(ServerConfig { renews_teacher: true, ..kept.clone() }).unwrap();
    let new = *server.teacher_token().unwrap();
    assert!(new != token);
    let old = Target { teacher: Some(token), ..target(&server, 2) };
    assert_eq!(refusal(join(&old).await), Refusal::Token);
    server.stop().await;
    fs::write(data.join("teacher-token.sha256"), "otter").unwrap();
    let said = Server::start(kept).unwrap_err();
    assert!(matches!(said, ServerError::Teacher { .. }) && said.to_string().contains("--new-teacher-token"), "{said}");
    fs::remove_dir_all(data).unwrap();
}

/// A program that is killed where the test ends, however that is.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        // it may have ended by itself
        drop((self.0.kill(), self.0.wait()));
    }
}

/// A server as a program, on a folder and a port of its own, and its join code and, the first time, the teacher's token.
fn served(data: &Path, port: u16, also: &[&str]) -> (Served, JoinCode, Option<TeacherToken>) {
    let listen = format!("127.0.0.1:{port}");
    let server = Command::new(program("pottery-server"))
        .args(["--listen", &listen, "--no-announce", "--wheels", "3", "--data"])
        .arg(data)
        .args(also)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut server = Served(server.unwrap());
    let mut lines = BufReader::new(server.0.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut said = |name: &str| lines.find_map(|line| Some(line.strip_prefix(name)?.trim().to_owned())).unwrap();
    let (code, teacher) = (said("join code").parse().unwrap(), said("teacher"));
    (server, code, teacher.split(' ').next().unwrap().parse().ok())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_class_comes_back_to_its_seats_when_the_server_was_killed_and_one_that_was_closed_has_a_new_code() {
    let data = folder("killed");
    let file = data.join("class-register");
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let (server, code, token) = served(&data, port, &[]);
    let at = |wheel| Target::new(format!("127.0.0.1:{port}"), code.clone(), wheel);
    let (_teachers_end, teacher) = join(&Target { teacher: token, ..at(1) }).await.unwrap();
    let (_students_end, student) = join_with(&at(1), Box::new(Rubbing)).await.unwrap();
    until(&teacher, "everybody is told of", |view| view.class.people().count() == 2 && view.class.class().is_some())
        .await;
    let order = |order| assert!(teacher.command(pottery_client::Command::Order(order)));
    let client = student.view().lock().number;
    order(Order::Seat { client, wheel: 3, works: true });
    let sits = |at| move |view: &View| view.link == Link::Open && view.class.place().is_some_and(|own| own.wheel == at);
    until(&student, "it is at wheel 3", sits(3)).await;
    let place = |potter: &Potter| potter.view().lock().class.place().map(|own| (own.client, own.name)).unwrap();
    let before = [place(&teacher), place(&student)];
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o077, 0, "others can read the code");
    }
    let presses = |view: &View| view.class.people().any(|person| person.client == client && person.touching);
    until(&teacher, "the student presses", presses).await;
    // the code is another one than that with which both came, and a wheel is frozen
    order(Order::NewCode);
    order(Order::Freeze { wheel: 2, is_frozen: true });
    let is_told = |view: &View| {
        let class = view.class.class();
        class.is_some_and(|class| class.code != code.room() && class.wheels[1].is_frozen)
    };
    until(&teacher, "the teacher is told", is_told).await;
    let new = teacher.view().lock().class.class().unwrap().code.clone();
    // the file has it as it is spelt there
    let kept = || fs::read(&file).is_ok_and(|bytes| bytes.windows(new.len()).any(|window| window == new.as_bytes()));
    let began = Instant::now();
    while !kept() {
        assert!(began.elapsed() < PATIENCE, "the new code is not kept");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    // what came after the code is kept with the next look
    tokio::time::sleep(Duration::from_secs(1)).await;

    drop(server);
    let is_away = |view: &View| matches!(view.link, Link::ComingBack(_));
    for potter in [&teacher, &student] {
        until(potter, "it knows", is_away).await;
    }
    let (mut server, again, _) = served(&data, port, &[]);
    assert_eq!(again.room(), new, "nobody else can come");
    until(&teacher, "the teacher is back", sits(1)).await;
    until(&student, "and the student where it was", sits(3)).await;
    assert_eq!([place(&teacher), place(&student)], before, "they are who they were");
    until(&teacher, "the teacher teaches", |view| view.class.class().is_some_and(|class| class.wheels[1].is_frozen))
        .await;
    // what the hand had made by the clock of the server before is not in its way
    let began = Instant::now();
    until(&teacher, "the student presses on", presses).await;
    println!("pressed on {:?} after it was back", began.elapsed());
    until(&student, "what it presses is confirmed", |view| view.link == Link::Open && view.digest != 0).await;
    for potter in [teacher, student] {
        potter.leave().await.unwrap();
    }

    assert!(Command::new("kill").arg(server.0.id().to_string()).status().unwrap().success());
    assert!(server.0.wait().unwrap().success());
    assert!(!file.exists(), "a server that is closed leaves its register behind");
    let (server, fresh, _) = served(&data, port, &[]);
    assert_ne!(fresh.room(), new);
    drop(server);
    fs::remove_dir_all(data).unwrap();
}

/// Who comes back to a server that knows nobody any more waits at its door, once, for as long as the teacher likes.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_comes_back_to_a_lobby_waits_there_until_the_teacher_lets_them_in() {
    let data = folder("lobby");
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let (server, code, token) = served(&data, port, &["--code", "K7QM-3XPD"]);
    let at = |wheel| Target::new(format!("127.0.0.1:{port}"), code.clone(), wheel);
    let (_teachers_end, teacher) = join(&Target { teacher: token, ..at(1) }).await.unwrap();
    let (_students_end, student) = join(&at(2)).await.unwrap();
    until(&student, "it has a seat", |view| view.class.place().is_some()).await;
    drop(server);
    for potter in [&teacher, &student] {
        until(potter, "it knows", |view| matches!(view.link, Link::ComingBack(_))).await;
    }
    let (server, _, _) = served(&data, port, &["--code", "K7QM-3XPD", "--fresh", "--lobby"]);
    until(&teacher, "the teacher is back", |view| view.link == Link::Open && view.class.class().is_some()).await;
    until(&student, "it is told that it waits", |view| view.link == Link::Waiting).await;
    // longer than a knock is waited for, and than the next one
    tokio::time::sleep(Duration::from_secs(4)).await;
    let waiting = || {
        let view = teacher.view().lock();
        let people = view.class.people().filter(|person| person.presence == Presence::Waiting);
        people.map(|person| person.client).collect::<Vec<_>>()
    };
    until(&teacher, "one person waits", |view| view.class.people().count() == 2).await;
    let (first, is_waiting) = (waiting(), student.view().lock().link == Link::Waiting);
    tokio::time::sleep(Duration::from_secs(2)).await;
    assert!(
        is_waiting && first.len() == 1 && waiting() == first,
        "it knocks again and again: {first:?}, {:?}",
        waiting()
    );
    assert!(teacher.command(pottery_client::Command::Order(Order::Admit { client: 0, is_admitted: true })));
    until(&student, "it is in", |view| view.link == Link::Open && view.class.may_press()).await;
    for potter in [teacher, student] {
        potter.leave().await.unwrap();
    }
    drop(server);
    fs::remove_dir_all(data).unwrap();
}

/// What every choice of a message says: whatever is added to it is among them.
fn sentences(read: impl Fn(&[u8]) -> Option<String>) -> Vec<String> {
    let of = |number: u8| {
        // its fields, all of them 0, take so many bytes
        (0..8).find_map(|zeros| read(&[vec![number], vec![0; zeros]].concat()))
    };
    (0..).map_while(of).collect()
}

#[test]
fn whatever_is_refused_is_refused_in_one_sentence() {
    let said = [
        sentences(|bytes| Some(protocol::decode::<64, Refusal>(bytes).ok()?.to_string())),
        sentences(|bytes| Some(protocol::decode::<64, NoOrder>(bytes).ok()?.to_string())),
        sentences(|bytes| Some(protocol::decode::<64, NoGuidance>(bytes).ok()?.to_string())),
        sentences(|bytes| Some(protocol::decode::<64, NoTool>(bytes).ok()?.to_string())),
    ]
    .concat();
    assert!(said.len() >= 20, "{said:?}");
    for sentence in &said {
        assert!((20..160).contains(&sentence.len()) && sentence.contains(' '), "{sentence}");
        assert!(!sentence.contains(['\n', '{', '}', '_']) && !sentence.contains("Error"), "{sentence}");
        assert_eq!(said.iter().filter(|other| *other == sentence).count(), 1, "said of two things: {sentence}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_short_code_keeps_to_the_key_that_was_shown_first() {
    let code: JoinCode = "K7QM-3XPD".parse().unwrap();
    let server = Server::start(ServerConfig { code: Some(code.clone()), ..config() }).unwrap();
    let short = Target::new(server.address().to_string(), code.clone(), 1);
    let (_end, first) = join(&short).await.unwrap();
    let shown = first.view().lock().fingerprint.unwrap();
    first.leave().await.unwrap();
    let known = Target { known: Some(shown), ..short.clone() };
    join(&known).await.unwrap().1.leave().await.unwrap();
    let other = Target { known: Some(Certificate::fresh().unwrap().sha256()), ..short };
    let said = join(&other).await.err().unwrap();
    assert!(matches!(said, JoinError::NewKey { .. }) && said.to_string().contains("--trust-new-key"), "{said}");
    let own = endpoint().unwrap();
    assert!(matches!(Onlooker::join(&own, &other, 1000).await, Err(JoinError::NewKey { .. })));
    server.stop().await;
    // a studio that is hosted in a window shows the same the next evening
    let spare = std::env::temp_dir().join(format!("pottery-key-{}", std::process::id()));
    let mut shown = Vec::new();
    for _ in 0..2 {
        let hosted = ServerConfig { code: Some(code.clone()), spare: Some(spare.clone()), ..config() };
        let server = Server::start(hosted).unwrap();
        shown.push(server.code().print().copied().unwrap());
        server.stop().await;
    }
    assert_eq!(shown[0], shown[1]);
    std::fs::remove_dir_all(spare).unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_studio_is_found_on_the_network_and_gone_when_it_closes() {
    let listen = SocketAddr::from(([0, 0, 0, 0], 0));
    // longer than a label of DNS, as names of other alphabets soon are
    let class = format!("Töpfern {} гончарная мастерская", std::process::id());
    let announced = ServerConfig { listen, class: Some(class.clone()), ..config() };
    let server = Server::start(announced.clone()).unwrap();
    let silent =
        Server::start(ServerConfig { is_announced: false, class: Some(format!("{class} b")), ..announced.clone() });
    let silent = silent.unwrap();
    let local = Server::start(ServerConfig { listen: config().listen, class: Some(format!("{class} c")), ..announced });
    let local = local.unwrap();
    let listened = tokio::task::spawn_blocking(|| find(Duration::from_secs(4)).unwrap()).await.unwrap();
    let found: Vec<_> = listened.iter().filter(|found| found.class.starts_with(&class)).collect();
    println!("{listened:?}");
    assert_eq!(found.len(), 1, "one of the three announces itself: {listened:?}");
    assert_eq!((found[0].address.port(), found[0].wheels), (server.address().port(), Some(3)));
    assert!(found[0].is_of_this_version && found[0].class == class);
    // the address that was found leads there
    let there = Target::new(found[0].address.to_string(), server.code().clone(), 1);
    join(&there).await.unwrap().1.leave().await.unwrap();
    for server in [server, silent, local] {
        server.stop().await;
    }
    let later = tokio::task::spawn_blocking(|| find(Duration::from_secs(2)).unwrap()).await.unwrap();
    assert!(!later.iter().any(|found| found.class.starts_with(&class)), "{later:?}");
}

fn console(server: &Server, arguments: &[&str], token: Option<&str>) -> Output {
    let address = server.operated_at().unwrap().to_string();
    let mut command = Command::new(program("pottery-server"));
    command.args(["console", "--operate", &address]).args(arguments).env_remove("POTTERY_TEACHER_TOKEN");
    if let Some(token) = token {
        command.env("POTTERY_TEACHER_TOKEN", token);
    }
    command.output().unwrap()
}

fn get(address: SocketAddr, path: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nhost: pottery\r\n\r\n").unwrap();
    let mut said = String::new();
    stream.read_to_string(&mut said).unwrap();
    said
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_console_shows_the_lesson_and_orders_with_the_token_alone() {
    let operate = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
    let server = Server::start(ServerConfig { operate, ..config() }).unwrap();
    let (_end, student) = join(&target(&server, 2)).await.unwrap();
    until(&student, "is told its name", |view| view.class.place().is_some()).await;
    let name = student.view().lock().class.place().unwrap().name.to_string();
    tokio::time::sleep(Duration::from_millis(300)).await;
    let text = |output: &Output| {
        let said = [output.stdout.clone(), output.stderr.clone()].concat();
        String::from_utf8(said).unwrap()
    };
    let (said, token) = (console(&server, &["--once"], None), server.teacher_token().unwrap().to_string());
    let page = text(&said);
    println!("{page}");
    assert!(
        said.status.success()
            && page.contains(&name)
            && page.contains("student")
            && page.contains("1 person, 3 wheels"),
        "{page}"
    );
    let code = server.code().room();
    assert!(!page.contains(code) && !get(server.operated_at().unwrap(), "/lesson").contains(code));
    assert!(!page.contains('\x1b'), "plain text where nobody looks at a terminal");
    // without the token, with another, and with words that mean nothing
    let foreign = "0".repeat(52);
    for (words, token, word) in [
        (&["freeze", "2"][..], None, "--teacher-token"),
        (&["freeze", "2"], Some(foreign.as_str()), "not the teacher's token"),
        (&["freeze"], Some(token.as_str()), "wheel"),
        (&["freeze", "9"], Some(token.as_str()), "no wheel 9"),
        (&["seat", "999", "1"], Some(token.as_str()), "nobody here has the number 999"),
        (&["take-back", "1"], Some(token.as_str()), "nothing of yours to take back"),
        (&["dance"], Some(token.as_str()), "'dance' is not understood: say lock"),
    ] {
        let said = console(&server, words, token);
        assert!(!said.status.success() && text(&said).contains(word), "{words:?}: {}", text(&said));
        assert!(student.view().lock().class.may_press());
    }
    let said = console(&server, &["freeze", "2"], Some(&token));
    assert!(said.status.success(), "{}", text(&said));
    until(&student, "is told that the wheel is frozen", |view| !view.class.may_press()).await;
    assert!(text(&console(&server, &["--once"], None)).contains("frozen"));
    // pots, the speed and seats as from a teacher's panel
    let orders = async |words: &[&str]| {
        let said = console(&server, words, Some(&token));
        assert!(said.status.success(), "{words:?}: {}", text(&said));
        // a wheel's clay is put there by its next tick
        tokio::time::sleep(Duration::from_millis(300)).await;
        server.standing().await.unwrap().digests
    };
    let begun = orders(&["thaw", "1"]).await;
    let bowl = orders(&["pot", "1", "bowl"]).await;
    assert!(bowl[0] != begun[0] && bowl[1..] == begun[1..]);
    let copied = orders(&["copy", "all", "1"]).await;
    assert_eq!(copied, [bowl[0]; 3]);
    assert_eq!(orders(&["take-back", "3"]).await, [bowl[0], bowl[0], begun[2]]);
    assert_eq!(orders(&["pot", "2", "first"]).await, [bowl[0], begun[2], begun[2]], "as nobody has pressed it");
    orders(&["speed", "3", "-90"]).await;
    let number = student.view().lock().class.place().unwrap().client.to_string();
    orders(&["seat", &number, "3"]).await;
    let turns = |view: &View| view.conditions.wheel.speed(pottery_shared::units::Tick(u64::MAX)).0.round() == -90.0;
    until(&student, "comes to the third wheel, which turns as was said", |view| {
        view.class.place().is_some_and(|place| place.wheel == 3) && turns(view)
    })
    .await;
    let said = text(&console(&server, &["new-code"], Some(&token)));
    assert!(said.starts_with("done") && !said.contains(code), "{said}");
    let new: JoinCode = said.trim_end().rsplit(' ').next().unwrap().parse().unwrap();
    assert_eq!(new.print(), server.code().print(), "who types it comes to this server and no other: {said}");
    assert_eq!(refusal(join(&target(&server, 1)).await), Refusal::CodeGone);
    student.leave().await.unwrap();
    server.stop().await;
}
