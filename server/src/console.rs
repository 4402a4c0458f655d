//! The terminal console: how the lesson stands, once a second, and orders in words, asked of a server on this machine.
//!
//! Owns the question and the layout; talks to the operators' port and to nothing else.
//! Invariant: where nobody looks at a terminal, it says everything once, in plain text.

use std::fmt::Write as _;
use std::io::{ErrorKind, IsTerminal as _, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use anyhow::{Context, anyhow, bail, ensure};
use clap::Args;
use pottery_server::{ORDERS, address, order_of};
use pottery_shared::protocol::TeacherToken;
use pottery_shared::units::Tick;
use serde_json::Value;

/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// A server that has not answered by then does not.
const PATIENCE: Duration = Duration::from_secs(3);

/// What stands below the flags.
fn orders() -> String {
    let mut said =
        String::from("The server has to be started with --operate. Orders, which need the teacher's token:\n");
    for (form, effect) in ORDERS {
        writeln!(said, "  {form:<22}{effect}").expect("a string takes everything");
    }
    said + "WHEEL and FROM are a wheel's number, from 1, PERSON is the number that somebody has here.\n\
        For admit and refuse PERSON may be all, and WHEEL where nobody is seated by it."
}

/// How the lesson on this machine's server stands, and what a teacher orders there.
#[derive(Args, Debug)]
#[command(after_help = orders(), allow_negative_numbers = true)]
pub(crate) struct ConsoleFlags {
    /// The operators' address of the server
    #[arg(long, value_name = "ADDRESS", value_parser = address, env = "POTTERY_OPERATE", default_value = "127.0.0.1:4748")]
    operate: SocketAddr,
    /// Say everything once and stop
    #[arg(long)]
    once: bool,
    /// The teacher's token, for orders
    #[arg(long, value_name = "TOKEN", env = "POTTERY_TEACHER_TOKEN", hide_env_values = true)]
    teacher_token: Option<TeacherToken>,
    /// An order, for example: freeze 2
    order: Vec<String>,
}

/// Looks, or orders.
pub(crate) fn run(flags: &ConsoleFlags) -> anyhow::Result<()> {
    if !flags.order.is_empty() {
        let words = flags.order.join(" ");
        // how long ago something was is the server's to say
        order_of(&words, Tick(0))?;
        let token = flags.teacher_token.context("an order needs the teacher's token: give --teacher-token")?;
        return crate::print(&order(flags.operate, &token, &words)?);
    }
    let stays = !flags.once && std::io::stdout().is_terminal();
    let mut before = Value::Null;
    loop {
        let lesson = look(flags.operate)?;
        let page = page(&lesson, &before);
        if !stays {
            return crate::print(&page);
        }
        // from the corner on, over what stood there
        crate::print(&format!("\x1b[H\x1b[2J{page}"))?;
        before = lesson;
        std::thread::sleep(LOOK_EVERY);
    }
}

fn look(address: SocketAddr) -> anyhow::Result<Value> {
    let body = ask(address, "GET /lesson HTTP/1.1\r\nhost: pottery\r\n\r\n")?;
    serde_json::from_str(&body).context("what answers there is no pottery server of this version")
}

fn order(address: SocketAddr, token: &TeacherToken, words: &str) -> anyhow::Result<String> {
    let length = words.len();
    ask(
        address,
        &format!(
            "POST /order HTTP/1.1\r\nhost: pottery\r\nauthorization: Bearer {token}\r\ncontent-length: {length}\r\n\r\n{words}"
        ),
    )
}

/// Asks, and returns what is said; a refusal is an error.
fn ask(address: SocketAddr, request: &str) -> anyhow::Result<String> {
    ensure!(address.ip().is_loopback(), "a console asks this machine alone: choose a loopback address, not {address}");
    let said = format!("no server answers operators at {address}; start it with --operate {address}");
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE).map_err(|error| unanswered(error, said))?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.write_all(request.as_bytes())?;
    let mut answer = String::new();
    let said = format!("the server did not answer within {} s; ask again", PATIENCE.as_secs());
    stream.read_to_string(&mut answer).map_err(|error| unanswered(error, said))?;
    let (head, body) = answer.split_once("\r\n\r\n").context("what answers there is no pottery server")?;
    match head.split(' ').nth(1) {
        Some("200") => Ok(body.to_owned()),
        _ => bail!("{}", body.trim_end()),
    }
}

/// That no answer came, and why where the system says more than that.
fn unanswered(error: std::io::Error, said: String) -> anyhow::Error {
    match error.kind() {
        ErrorKind::ConnectionRefused | ErrorKind::TimedOut | ErrorKind::WouldBlock => anyhow!(said),
        _ => anyhow::Error::new(error).context(said),
    }
}

/// What is shown; wake-ups, each with all ticks that were due, are those since the look `before`, where there was one.
fn page(lesson: &Value, before: &Value) -> String {
    let mut page = String::new();
    let mut line = |text: String| writeln!(page, "{text}").expect("a string takes everything");
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let (wheels, people) = (list(&lesson["wheels"]), list(&lesson["people"]));
    let state = match (lesson["locked"] == true, lesson["lobby"] == true) {
        (true, _) => "locked",
        (false, true) => "open, with a lobby",
        (false, false) => "open",
    };
    let [middle, high] = [50, 99].map(|percent| wake_us(&lesson["wake_us"], &before["wake_us"], percent));
    let some = |number, one, more| format!("{number} {}", if number == 1 { one } else { more });
    let (there, at) = (some(people.len(), "person", "people"), some(wheels.len(), "wheel", "wheels"));
    line(format!("{there}, {at}, door {state}"));
    line(format!("wake-up p50 {middle} us, p99 {high} us; {} late since the start", lesson["late"]));
    line(String::new());
    line(format!("{:<7}{:>7}{:>7}{:>10}  {}", "wheel", "people", "rpm", "delta ms", "state"));
    for (number, wheel) in (1..).zip(&wheels) {
        let age = wheel["age_ms"].as_u64().map_or_else(|| "-".into(), |age| age.to_string());
        let frozen = if wheel["frozen"] == true { "frozen" } else { "" };
        let closed = if wheel["open"] == true { "" } else { "closed" };
        let rpm = wheel["rpm"].as_f64().unwrap_or_default();
        // a value of JSON pays no heed to a width
        let there = wheel["people"].to_string();
        line(format!("{number:<7}{there:>7}{rpm:>7}{age:>10}  {frozen} {closed}").trim_end().to_owned());
    }
    line(String::new());
    line(format!("{:<7}{:<16}{:<9}{:>5}  {}", "number", "name", "role", "wheel", "state"));
    for person in &people {
        let text = |key: &str| person[key].as_str().unwrap_or("?").to_owned();
        let touching = if person["touching"] == true { "touching" } else { "" };
        let looks_on = if person["works"] == true { "" } else { "looks on" };
        let row = format!(
            "{:<7}{:<16}{:<9}{:>5}  {} {touching}{looks_on}",
            person["number"].to_string(),
            text("name"),
            text("role"),
            person["wheel"].to_string(),
            text("presence")
        );
        line(row.trim_end().to_owned());
    }
    page
}

/// Time below which so many percent of the wake-ups since `before` took, µs.
fn wake_us(now: &Value, before: &Value, percent: u64) -> u64 {
    let buckets = |value: &Value| -> Vec<(u64, u64)> {
        let pair = |bucket: &Value| Some((bucket[0].as_u64()?, bucket[1].as_u64()?));
        value.as_array().into_iter().flatten().filter_map(pair).collect()
    };
    let (now, before) = (buckets(now), buckets(before));
    let earlier = |us: u64| before.iter().find(|(at, _)| *at == us).map_or(0, |(_, count)| *count);
    let since: Vec<_> = now.iter().map(|(us, count)| (*us, count.saturating_sub(earlier(*us)))).collect();
    let wanted = since.iter().map(|(_, count)| count).sum::<u64>() * percent / 100;
    let mut seen = 0;
    let found = since.iter().find(|(_, count)| {
        seen += count;
        seen > wanted
    });
    found.map_or(0, |(us, _)| *us)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_said_of_a_person_stands_under_its_heading() {
        let person = |number: u16, wheel: u16| {
            json!({
                "number": number, "name": "otter", "role": "student", "wheel": wheel, "works": true, "presence": "here",
                "touching": true,
            })
        };
        let wheel = json!({ "open": true, "frozen": true, "people": 2, "rpm": 60.0, "age_ms": 12 });
        let lesson = json!({ "people": [person(3, 1), person(1204, 117)], "wheels": [wheel], "late": 0 });
        let page = page(&lesson, &Value::Null);
        let lines: Vec<_> = page.lines().collect();
        assert_eq!(lines[3..5], ["wheel   people    rpm  delta ms  state", "1            2     60        12  frozen"]);
        assert_eq!(
            lines[6..],
            [
                "number name            role     wheel  state",
                "3      otter           student      1  here touching",
                "1204   otter           student    117  here touching",
            ]
        );
    }
}
