//! The load test as it is run: against a server of its own, for a few seconds.
//!
//! Nothing here says how quick anything is; what is held is that the figures mean what they say, whatever the machine does.
//! Invariant under test: a late generator makes a run invalid, a late server shows in the figures, and never the other way round.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::{BufRead, BufReader, Read};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

use pottery_server::{Certificate, Helpers, server_config};
use pottery_shared::protocol::{self, Notice, Refusal, VERSION};
use pottery_shared::room::Alone;
use pottery_tests::load::cores::Apart;
use pottery_tests::load::host::Host;
use pottery_tests::load::knee::Climb;
use pottery_tests::load::law::Law;
use pottery_tests::load::plan::Plan;
use pottery_tests::load::result::{RunResult, SCHEMA, Verdict};
use pottery_tests::load::soak;
use pottery_tests::load::virtual_room::VirtualRoom;
use pottery_tests::programs::{folder, program};

/// On a busy machine the generator is late through no fault of its own; the tests that are about that say how late it may be.
const PATIENT: [&str; 2] = ["--lag-max-ms", "3000"];

fn load_test(arguments: &[&str]) -> Command {
    let mut command = Command::new(program("load-test"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn output(arguments: &[&str]) -> Output {
    load_test(arguments).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn result(path: &Path) -> RunResult {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn smoke_run_ends_with_equal_clay_and_whole_figures() {
    let folder = folder("load-smoke");
    let (json, html) = (folder.join("run.json"), folder.join("run.html"));
    let paths = [json.to_str().unwrap(), html.to_str().unwrap()];
    let mut arguments = vec!["--spawn", "--scenario", "smoke", "--json", paths[0], "--html", paths[1]];
    arguments.extend(PATIENT);
    arguments.extend(["--threshold", "input_delta_ms:p50<60000", "--threshold", "server_late_ticks<100000"]);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let run = result(&json);
    assert_eq!((run.schema, run.verdict, run.compared), (SCHEMA, Verdict::Pass, 8));
    assert!(run.diverged.is_empty() && run.unlike == 0, "{:?}", run.diverged);
    for name in ["join_ms", "input_delta_ms", "delta_age_ms", "schedule_lag_ms", "correction_mm", "server_wake_ms"] {
        assert!(run.quantiles(name).unwrap().count > 0, "nothing was counted for {name}");
    }
    let (us, room) = (run.server_us_per_datagram().unwrap(), run.room_percent().unwrap());
    assert!(us > 0.0 && room > 0.0 && room < 100.0, "{us} us a datagram, {room} %");
    assert_eq!(run.server.as_ref().unwrap().unheard, 0, "honest people behind one address");
    // what was sent cannot be older than what was due
    assert!(run.input_delta_ms.mean >= run.input_delta_uncorrected_ms.mean);
    assert!(run.down_bytes > run.up_bytes && run.up_bytes > 0);
    let second = run.seconds.last().unwrap();
    assert_eq!((second.people, second.is_measured), (8, true));
    let page = std::fs::read_to_string(&html).unwrap();
    assert!(page.contains("<svg") && page.contains("</html>"));
    assert!(!page.contains("http") && !page.contains("<script"), "the page asks for something outside of it");
}

#[cfg(target_os = "linux")]
#[test]
fn a_spawned_server_has_as_many_threads_as_it_is_asked_to_have() {
    let named = |host: &Host| -> Vec<String> {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", host.process())).unwrap();
        tasks.filter_map(|task| std::fs::read_to_string(task.unwrap().path().join("comm")).ok()).collect()
    };
    let workers = |threads: u8| {
        let host = Host::spawn(&program("pottery-server"), Some(threads), &Plan::default()).unwrap();
        let begun = Instant::now();
        // a thread goes by the name of the one that made it until it runs, which on a busy machine takes a while
        loop {
            let names = named(&host);
            let are_all_named = names.iter().filter(|name| name.starts_with("pottery-server")).count() == 1;
            let workers = names.iter().filter(|name| name.starts_with("tokio-rt-worker")).count();
            if (are_all_named && workers == usize::from(threads)) || begun.elapsed() > Duration::from_secs(30) {
                break workers;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    assert_eq!((workers(1), workers(3)), (1, 3));
}

#[cfg(target_os = "linux")]
#[test]
fn a_spawned_server_keeps_to_its_own_cores_and_the_generator_to_the_others() {
    let allowed = std::thread::available_parallelism().unwrap().get();
    let json = folder("cores").join("run.json");
    let mut arguments = vec!["--spawn", "--potters", "1", "--full-potters", "0", "--duration", "1", "--warmup", "0.2"];
    arguments.extend(PATIENT);
    arguments.extend(["--ramp", "0", "--json", json.to_str().unwrap(), "--server-cores"]);
    let done = output(&[&arguments[..], &[&allowed.to_string()]].concat());
    assert_eq!(done.status.code(), Some(2), "{}", told(&done));
    assert!(told(&done).contains("at least one is the server's, and one the generator's"), "{}", told(&done));
    let Ok(apart) = Apart::new(1) else {
        assert_eq!(allowed, 1, "of two cores one can be the server's");
        return;
    };
    let host = {
        let _kept = apart.keep_to_server().unwrap();
        Host::spawn(&program("pottery-server"), None, &Plan::default()).unwrap()
    };
    let tasks = std::fs::read_dir(format!("/proc/{}/task", host.process())).unwrap();
    let mut cores: Vec<String> = tasks
        .map(|task| std::fs::read_to_string(task.unwrap().path().join("status")).unwrap())
        .map(|status| status.lines().find(|line| line.starts_with("Cpus_allowed_list")).unwrap().to_owned())
        .collect();
    cores.dedup();
    let [core] = &cores[..] else { panic!("threads of one server are on {cores:?}") };
    assert!(!core.contains([',', '-']), "more than one core: {core}");
    let done = output(&[&arguments[..], &["1"]].concat());
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let run = result(&json);
    assert_eq!((run.host.server_cores, run.host.cores), (Some(1), allowed - 1));
    assert!(told(&done).contains(&format!("cores of their own, 1 and {}", allowed - 1)), "{}", told(&done));
}

#[test]
fn broken_threshold_has_an_exit_code_of_its_own_and_can_end_the_run() {
    let mut arguments = vec!["--spawn", "--potters", "1", "--duration", "3000", "--warmup", "0.2", "--ramp", "0"];
    arguments.extend(PATIENT);
    arguments.extend(["--threshold", "input_delta_ms:p50<0.0001", "--abort-on-fail"]);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(99), "{}", told(&done));
    let said = told(&done);
    assert!(said.contains("threshold input_delta_ms:p50<0.0001 is broken") && said.contains("aborted after"), "{said}");
}

/// Starts a run of two potters and waits until it is measured; the run, what it says further, and its server's process.
fn begun(further: &[&str]) -> (Child, BufReader<ChildStderr>, String) {
    let mut child =
        load_test(&["--spawn", "--potters", "2", "--full-potters", "0", "--ramp", "0.2", "--warmup", "0.5"])
            .args(further)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let server = read_until(&mut lines, |line| line.starts_with("server "));
    let server = server.split("process ").nth(1).unwrap().trim_end_matches([')', '\n']).to_owned();
    // a row without a star is measured
    read_until(&mut lines, |line| line.contains('%') && !line.contains('*'));
    (child, lines, server)
}

/// Starts a run of a few seconds, and once it is measured stops a process for a while: the server's or the generator's own.
fn stopped(json: &Path, lag_max_ms: &str, picks_server: bool, stop: Duration) -> (Option<i32>, RunResult) {
    let (mut child, mut lines, server) =
        begun(&["--duration", "4", "--lag-max-ms", lag_max_ms, "--json", json.to_str().unwrap()]);
    let process = if picks_server { server } else { child.id().to_string() };
    signal("-STOP", &process);
    std::thread::sleep(stop);
    signal("-CONT", &process);
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    (ended(&mut child), result(json))
}

fn ended(child: &mut Child) -> Option<i32> {
    child.wait().unwrap().code()
}

fn read_until(lines: &mut impl BufRead, is_it: impl Fn(&str) -> bool) -> String {
    loop {
        let mut line = String::new();
        assert!(lines.read_line(&mut line).unwrap() > 0, "the program ended too early");
        if is_it(&line) {
            return line;
        }
    }
}

fn signal(which: &str, process: &str) {
    assert!(Command::new("kill").args([which, process]).status().unwrap().success());
}

#[cfg(unix)]
#[test]
fn server_that_stalls_shows_in_the_figures_and_not_in_the_generator() {
    let folder = folder("load-stall");
    let (code, run) = stopped(&folder.join("run.json"), "3000", true, Duration::from_millis(500));
    assert_eq!((code, run.verdict), (Some(0), Verdict::Pass), "{:?}", run.said);
    // of 400 inputs a hand, those due in the first 200 ms of the stall waited for 300 ms or more: 5 %
    assert!(run.input_delta_ms.p99 >= 300.0, "{:?}", run.input_delta_ms);
    assert!(run.delta_age_ms.max >= 300.0, "{:?}", run.delta_age_ms);
}

#[cfg(unix)]
#[test]
fn generator_that_starves_is_reported_and_not_taken_for_a_good_server() {
    let folder = folder("load-starved");
    let (code, run) = stopped(&folder.join("run.json"), "100", false, Duration::from_millis(1500));
    assert_eq!((code, run.verdict), (Some(98), Verdict::Invalid), "{:?}", run.said);
    assert!(run.said[0].contains("invalid"), "{:?}", run.said);
    // inputs that were due in the first 500 ms were sent 1 s late or later, and say so
    assert!(run.input_delta_ms.p99 >= 1000.0 && run.schedule_lag_ms.p99 >= 1000.0, "{:?}", run.schedule_lag_ms);
    assert!(run.input_delta_uncorrected_ms.p50 <= run.input_delta_ms.p50);
    assert!(run.dropped_sends > 0);
}

#[cfg(target_os = "linux")]
#[test]
fn whoever_ends_a_run_ends_its_server_too() {
    for which in ["-TERM", "-INT"] {
        let (mut child, mut lines, server) = begun(&[&["--duration", "3000"][..], &PATIENT].concat());
        signal(which, &child.id().to_string());
        let mut said = String::new();
        lines.read_to_string(&mut said).unwrap();
        assert_eq!(ended(&mut child), Some(1), "{which}: {said}");
        assert!(said.contains("interrupted"), "{which}: {said}");
        assert!(!Path::new("/proc").join(&server).exists(), "{which}: the server goes on");
    }
}

#[cfg(unix)]
#[test]
fn a_run_that_waits_for_a_server_that_hangs_can_be_ended() {
    let (mut child, mut lines, server) = begun(&[&["--duration", "2"][..], &PATIENT].concat());
    signal("-STOP", &server);
    // from here on it waits for what was pressed last, and for everybody's clay
    read_until(&mut lines, |line| line.starts_with("100%"));
    signal("-INT", &child.id().to_string());
    let mut said = String::new();
    lines.read_to_string(&mut said).unwrap();
    assert!(ended(&mut child) == Some(1) && said.contains("interrupted"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn what_a_run_cost_that_is_measured_from_its_beginning_is_what_its_seconds_cost() {
    let json = folder("load-at-once").join("run.json");
    let mut arguments = vec!["--spawn", "--potters", "2", "--full-potters", "0", "--ramp", "0", "--warmup", "0"];
    arguments.extend(["--duration", "3", "--quiet", "--json", json.to_str().unwrap()]);
    arguments.extend(PATIENT);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let run = result(&json);
    let mut from_s = 0.0;
    let [mut server, mut generator] = [0.0; 2];
    for second in &run.seconds {
        let length_s = second.at_s - from_s;
        server += second.server_cpu_percent.unwrap() * length_s;
        generator += second.generator_cpu_percent.unwrap() * length_s;
        from_s = second.at_s;
    }
    assert_eq!(from_s, run.measured_s);
    // sums of the same figures
    assert!((server / from_s - run.server_cpu_percent.unwrap()).abs() < 1e-6, "{server} in {from_s} s");
    assert!((generator / from_s - run.generator_cpu_percent.unwrap()).abs() < 1e-6, "{generator} in {from_s} s");
    let late: u64 = run.seconds.iter().filter_map(|second| second.late_ticks).sum();
    let figures = run.server.unwrap();
    assert!(figures.late_ticks_alone <= late && late <= figures.late_ticks, "{late}: {figures:?}");
}

#[test]
fn soak_of_a_server_whose_memory_nobody_can_read_is_not_passed() {
    let host = Host::spawn(&program("pottery-server"), None, &Plan::default()).unwrap();
    let (address, code) = (host.address.to_string(), host.code.to_string());
    let mut arguments = vec!["soak", "--server", &address, "--code", &code, "--potters", "1", "--spectators", "0"];
    arguments.extend(["--ramp", "0.2", "--warmup", "0.3", "--duration", "2", "--quiet"]);
    arguments.extend(PATIENT);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(99), "{}", told(&done));
    for words in ["memory of the server not measured", "its late ticks not told", "--spawn"] {
        assert!(told(&done).contains(words), "{words}: {}", told(&done));
    }
}

#[test]
fn everybody_comes_again_after_the_network_was_away() {
    let folder = folder("load-storm");
    let json = folder.join("run.json");
    let mut arguments = vec!["--spawn", "--scenario", "join-storm", "--potters", "2", "--spectators", "10"];
    arguments.extend(["--wheels", "2", "--duration", "11", "--ramp", "0.5", "--warmup", "0.5", "--quiet"]);
    arguments.extend(["--json", json.to_str().unwrap()]);
    arguments.extend(PATIENT);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let run = result(&json);
    assert_eq!((run.reconnects, run.compared, run.broken), (12, 12, 0), "{:?}", run.said);
}

#[test]
fn strangers_who_try_codes_are_counted_and_the_class_works_on() {
    let folder = folder("load-strangers");
    let json = folder.join("run.json");
    let mut arguments =
        vec!["--spawn", "--scenario", "strangers", "--potters", "2", "--spectators", "4", "--wheels", "2"];
    arguments.extend(["--strangers", "50", "--duration", "6", "--ramp", "0.5", "--warmup", "0.5", "--quiet"]);
    arguments.extend(["--json", json.to_str().unwrap()]);
    arguments.extend(PATIENT);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let run = result(&json);
    let strangers = run.strangers.as_ref().expect("they came");
    assert!(strangers.knocks_per_s > 10.0, "{strangers:?}");
    // the first, before the doorkeeper lets the others wait
    assert!(strangers.answered_per_s > 0.0 && strangers.answered_per_s <= strangers.knocks_per_s, "{strangers:?}");
    assert!(strangers.quiet_age_ms.count > 0 && strangers.besieged_age_ms.count > 0, "{strangers:?}");
    assert_eq!((run.compared, run.broken, run.failed_joins), (6, 0, 0), "{:?}", run.said);
}

#[test]
fn climb_ends_at_the_load_that_breaks_a_threshold_and_draws_it() {
    let folder = folder("load-knee");
    let (json, html) = (folder.join("knee.json"), folder.join("knee.html"));
    let mut arguments = vec!["knee", "--spawn", "--potters", "1", "--full-potters", "0", "--from", "2", "--to", "8"];
    arguments.extend([
        "--factor",
        "2",
        "--halvings",
        "0",
        "--ramp",
        "0.2",
        "--warmup",
        "0.3",
        "--duration",
        "1",
        "--quiet",
    ]);
    arguments.extend(["--json", json.to_str().unwrap(), "--html", html.to_str().unwrap()]);
    arguments.extend(PATIENT);
    // two joins more than the potter's are two too many
    arguments.extend(["--threshold", "join_ms:count<4"]);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let climb: Climb = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let loads: Vec<_> = climb.steps.iter().map(|step| (step.people, step.verdict)).collect();
    assert_eq!(loads, [(2, Verdict::Pass), (4, Verdict::Breach)]);
    assert_eq!((climb.knee, climb.broke.map(|(people, _)| people)), (Some(2), Some(4)));
    assert!(std::fs::read_to_string(&html).unwrap().contains(">knee<"));
}

#[cfg(unix)]
#[test]
fn climb_that_somebody_ends_tells_and_writes_the_loads_that_were_gone_through() {
    let json = folder("load-knee-interrupted").join("knee.json");
    let climb =
        ["knee", "--spawn", "--potters", "1", "--full-potters", "0", "--from", "1", "--to", "999", "--factor", "1.01"];
    let threshold = ["--threshold", "input_delta_ms:p50<60000"];
    let each = ["--ramp", "0.2", "--warmup", "0.3", "--duration", "1", "--quiet", "--json", json.to_str().unwrap()];
    let mut command = load_test(&[&climb[..], &each, &threshold, &PATIENT].concat());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    read_until(&mut lines, |line| line.contains("pass"));
    read_until(&mut lines, |line| line.starts_with("server "));
    signal("-INT", &child.id().to_string());
    let done = child.wait_with_output().unwrap();
    let told = told(&done);
    assert!(done.status.code() == Some(98) && told.contains("with 2 the climb ended: it was interrupted"), "{told}");
    let climb: Climb = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!((climb.steps.len(), climb.knee, climb.verdict()), (1, Some(1), Verdict::Invalid));
}

#[test]
fn law_is_fitted_to_loads_of_its_own_and_says_what_each_costs() {
    let folder = folder("load-law");
    let (json, html) = (folder.join("law.json"), folder.join("law.html"));
    let mut arguments = vec!["law", "--spawn", "--turns", "1", "--most", "8", "--ramp", "0.2", "--warmup", "0.3"];
    arguments.extend([
        "--duration",
        "1",
        "--quiet",
        "--json",
        json.to_str().unwrap(),
        "--html",
        html.to_str().unwrap(),
    ]);
    arguments.extend(PATIENT);
    let refused = output(&[&arguments[..], &["--potters", "3"]].concat());
    assert_eq!(refused.status.code(), Some(2), "{}", told(&refused));
    assert!(told(&refused).contains("leave --potters out"), "{}", told(&refused));
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let law: Law = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!((law.loads.len(), law.held()), (12, 12), "{}", told(&done));
    // what comes down to each is the one cost that a busy machine does not change much
    let [.., full, spectator, gallery] = law.fits[2].each;
    assert!(full > 0.0 && spectator > 0.0 && gallery > 0.0 && gallery < spectator, "{}", told(&done));
    assert!(law.fits.iter().all(|fit| fit.residual.is_finite() && fit.error.iter().all(|error| error.is_finite())));
    assert!(told(&done).contains("12 of 12 loads are in the law"), "{}", told(&done));
    let page = std::fs::read_to_string(&html).unwrap();
    assert!(page.contains("by the law") && page.contains("</html>"));
}

#[test]
fn short_soak_holds_its_clay_and_its_memory() {
    let mut arguments =
        vec!["soak", "--spawn", "--potters", "2", "--spectators", "4", "--wheels", "2", "--ramp", "0.5"];
    arguments.extend(["--warmup", "1", "--duration", "5", "--growth-max-mb", "16", "--quiet"]);
    arguments.extend(PATIENT);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    assert!(told(&done).contains("memory of the server"), "{}", told(&done));
    assert!(told(&done).contains("a thread with nothing to do was late"), "{}", told(&done));
}

#[test]
fn soak_in_virtual_time_repeats_from_its_seed() {
    let plan = Plan { potters: 2, ..Plan::default() };
    let (one, other) = (soak::in_virtual_time(&plan, 4).unwrap(), soak::in_virtual_time(&plan, 4).unwrap());
    assert!(one.is_current && one.refused == 0 && one.snapshots > 100, "{one:?}");
    assert_eq!(one.snapshots, other.snapshots);
}

#[test]
fn wheels_that_many_hands_do_are_told_as_those_that_one_does() {
    let plan = Plan { wheels: 5, potters: 12, ..Plan::default() };
    let helpers = Helpers::new(3).unwrap();
    let [mut alone, mut helped] = [(); 2].map(|()| VirtualRoom::open(&plan).unwrap());
    for millisecond in 1..=1500 {
        let (mut one, mut other) = (Vec::new(), Vec::new());
        alone.pass(millisecond, &Alone, |transmit| one.push(transmit.clone()));
        helped.pass(millisecond, &helpers, |transmit| other.push(transmit.clone()));
        assert_eq!(one, other, "in millisecond {millisecond}");
    }
    assert_eq!(alone.digests(), helped.digests());
    assert!(alone.snapshots() > 12 * 50 && alone.is_current() && alone.refused() == 0);
}

#[test]
fn every_scenario_is_one() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/load");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let plan = Plan::read(path.to_str().unwrap()).unwrap().checked().unwrap();
        assert_eq!(plan.name, path.file_stem().unwrap().to_str().unwrap());
        assert!(plan.about.len() > 20, "{} does not say what it stands for", plan.name);
        seen += 1;
    }
    assert!(seen >= 8);
}

#[test]
fn climb_ends_with_a_run_that_is_invalid_and_finds_no_knee_in_it() {
    let mut arguments = vec!["knee", "--spawn", "--potters", "1", "--full-potters", "0", "--from", "2", "--to", "4"];
    arguments.extend(["--ramp", "0.2", "--warmup", "0.3", "--duration", "1", "--quiet"]);
    // nobody is as punctual as that
    arguments.extend(["--lag-max-ms", "0.0001", "--threshold", "join_ms:count<1000"]);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(98), "{}", told(&done));
    let said = told(&done);
    assert!(said.contains("with 2 the climb ended: this run is invalid"), "{said}");
}

#[test]
fn what_makes_no_sense_is_refused_in_a_sentence() {
    let bounded = ["knee", "--spawn", "--threshold", "join_ms:count<4"];
    let knee = |flags: [&'static str; 2]| [&bounded[..], &flags].concat();
    for (arguments, said) in [
        (&["knee", "--spawn"][..], "say which with --threshold"),
        (&knee(["--factor", "nan"]), "from 1.001 to 100"),
        (&knee(["--factor", "1"]), "from 1.001 to 100"),
        (&knee(["--to", "49"]), "--from 50 is above --to 49"),
        (&["soak", "--virtual-s", "0"], "--virtual-s"),
        (&["soak", "--virtual-s", "1", "--growth-max-mb", "nan"], "from 0 to 1000000"),
        (&["--spawn", "--duration", "long"], "from 1 to 86400"),
        (&["--spawn", "--potters", "2", "--full-potters", "3"], "more than all 2 who press"),
        (&["--spawn", "--threshold", "input_delta_ms:p99<-1"], "never less than nothing"),
        (&["--server", "127.0.0.1:9", "--code", "K7QM-3XPD", "--server-threads", "2"], "--server-threads"),
        (&["--server", "127.0.0.1:99999", "--code", "K7QM-3XPD"], "a port is a number up to 65535"),
        (&["--spawn", "--json", "/nowhere/run.json"], "/nowhere/run.json cannot be written"),
        (&["--spawn", "--html", "/nowhere/run.html"], "/nowhere/run.html cannot be written"),
        (&["soak", "--virtual-s", "1", "--json", "/nowhere/run.json"], "/nowhere/run.json cannot be written"),
        (&["soak", "--virtual-s", "1", "--html", "run.html"], "leave --html out"),
        (&["soak", "--virtual-s", "1", "--spawn"], "leave --spawn out"),
        (&["--spawn", "--scenario", "nowhere"][..], "class-arrives"),
        (&["--spawn", "--potters", "100000"], "from 0 to 512"),
        (&["--server", "192.168.1.20:4747", "--code", "K7QM-3XPD"], "--beyond-loopback"),
        (
            &["--server", "192.0.2.1:4747", "--code", "K7QM-3XPD", "--scenario", "strangers", "--beyond-loopback"],
            "strangers knock at servers on this machine alone",
        ),
        (&["--spawn", "--threshold", "input_delta<5"], "there is no figure"),
        (&["--potters", "1"], "--spawn"),
    ] {
        let done = output(arguments);
        assert!(done.status.code() == Some(2) && told(&done).contains(said), "{arguments:?}: {}", told(&done));
    }
    let done = output(&["--spawn", "--program", "/nowhere/pottery-server"]);
    assert!(done.status.code() == Some(1) && told(&done).contains("cannot be started"), "{}", told(&done));
    let help = told(&output(&["--help"]));
    for word in ["Examples:", "Exit codes:", "invalid", "knee", "soak", "schedule_lag_ms"] {
        assert!(help.contains(word), "--help does not say {word}");
    }
    for scenario in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/load")).unwrap() {
        let name = scenario.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned();
        assert!(help.contains(&name), "--help does not name the scenario {name}");
    }
}

#[test]
fn who_never_comes_in_is_not_passed_over() {
    let room = Plan { potters: 2, ..Plan::default() };
    let host = Host::spawn(&program("pottery-server"), None, &room).unwrap();
    let (address, code) = (host.address.to_string(), host.code.to_string());
    let json = folder("load-outside").join("run.json");
    let mut arguments = vec!["--server", &address, "--code", &code, "--potters", "4", "--full-potters", "0", "--quiet"];
    arguments.extend(["--ramp", "0.2", "--warmup", "0.3", "--duration", "2", "--json", json.to_str().unwrap()]);
    arguments.extend(PATIENT);
    let done = output(&arguments);
    assert_eq!(done.status.code(), Some(99), "{}", told(&done));
    let words = ["2 of 4 people never came in", "the studio is full (2 people)", "not everybody who was planned"];
    assert!(words.iter().all(|words| told(&done).contains(words)), "{}", told(&done));
    let run = result(&json);
    // they come in when the others have gone, which is after what was measured
    assert_eq!((run.verdict, run.outside, run.join_ms.count), (Verdict::Breach, 2, 2), "{:?}", run.said);
}

#[cfg(unix)]
#[test]
fn what_was_measured_until_somebody_ended_the_run_is_written() {
    let json = folder("load-interrupted").join("run.json");
    let further = ["--duration", "3000", "--json", json.to_str().unwrap()];
    let (mut child, mut lines, _) = begun(&[&further[..], &PATIENT].concat());
    signal("-INT", &child.id().to_string());
    let mut said = String::new();
    lines.read_to_string(&mut said).unwrap();
    assert_eq!(ended(&mut child), Some(1), "{said}");
    let run = result(&json);
    assert!(run.is_interrupted && run.verdict == Verdict::Invalid && run.compared == 0, "{:?}", run.said);
    assert!(run.said[0].contains("interrupted after"), "{:?}", run.said);
    assert!(run.measured_s >= 1.0 && run.seconds.last().unwrap().is_measured, "{} s", run.measured_s);
    assert!(run.sends > 0 && run.input_delta_ms.count > 0, "{:?}", run.input_delta_ms);
}

/// A server that answers every greeting with a refusal.
fn refusing(refusal: Refusal) -> (SocketAddr, tokio::runtime::Runtime) {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    let listening = runtime.block_on(async {
        let config = server_config(Certificate::fresh().unwrap()).unwrap();
        quinn::Endpoint::server(config, "127.0.0.1:0".parse().unwrap()).unwrap()
    });
    let address = listening.local_addr().unwrap();
    runtime.spawn(async move {
        while let Some(incoming) = listening.accept().await {
            let refusal = refusal.clone();
            tokio::spawn(async move {
                let Ok(connection) = incoming.await else { return };
                let Ok((mut answer, _greeting)) = connection.accept_bi().await else { return };
                let notice = protocol::frame(&protocol::encode(&Notice::Refused(refusal)));
                answer.write_all(&notice).await.unwrap();
                connection.closed().await;
            });
        }
    });
    (address, runtime)
}

#[test]
fn who_is_refused_for_one_reason_is_told_it_and_does_not_wait_for_the_end_of_the_run() {
    let version = Refusal::Version { server: VERSION + 1, client: VERSION };
    let newer = vec![format!("version {}", VERSION + 1), format!("this program version {VERSION}"), "update".into()];
    let tell = |refusal, words: Vec<String>| {
        let (address, _serving) = refusing(refusal);
        let address = address.to_string();
        let arguments = ["--server", &address, "--code", "K7QM-3XPD", "--potters", "3", "--duration", "3000"];
        let done = output(&arguments);
        let said = told(&done);
        assert!(!done.status.success() && done.status.code() != Some(99), "{said}");
        let line = said.lines().find(|line| line.contains("nobody could come in")).unwrap_or_else(|| panic!("{said}"));
        assert!(words.iter().all(|word| line.contains(word.as_str())), "{line}");
    };
    // each of them waits for most of its time, and so they do at once
    std::thread::scope(|threads| {
        threads.spawn(|| tell(version, newer));
        threads.spawn(|| tell(Refusal::Locked, vec!["locked".into()]));
        threads.spawn(|| tell(Refusal::Code, vec!["not the code".into()]));
    });
}
