//! What an operator asks a running server: whether it lives, whether the room answers, how the lesson stands, and what it has counted.
//!
//! Owns the loopback port and its pages; knows the room only through the figures that it gives.
//! Invariant: nothing is changed here without the teacher's token, nobody outside this machine can ask, and the code is told to who has it,
//! and no page holds an address or a name that somebody chose.

use std::fmt::Write as _;
use std::net::SocketAddr;
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use pottery_shared::protocol::{JoinCode, NoOrder};
use tokio::net::TcpListener;
use tokio::sync::{mpsc, oneshot};

use crate::event::Event;
use crate::lesson::Lesson;
use crate::orders::order_of;
use crate::{Figures, ServerError};

/// The room answers within this, or it does not take people in.
const READY_WITHIN: Duration = Duration::from_millis(500);
/// Who has asked nothing by then is let go.
const ASKS_WITHIN: Duration = Duration::from_secs(5);
/// What is said where it does not.
const SILENT_ROOM: &str = "the room does not answer\n";
/// Longest order, bytes.
const ORDER_MAX: usize = 256;
/// Upper ends of the classes of a tick's time, µs; a snapshot's period is 16,667.
const CLASSES_US: [u64; 10] = [100, 250, 500, 1_000, 2_000, 4_000, 8_000, 16_667, 33_333, 100_000];

/// Answers whoever asks, until the server ends.
pub(crate) async fn serve(listener: TcpListener, events: mpsc::Sender<Event>, fingerprint: [u8; 32]) {
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                tracing::debug!(%error, "nobody can ask how the server is");
                tokio::time::sleep(Duration::from_secs(1)).await;
                continue;
            }
        };
        let events = events.clone();
        tokio::spawn(async move {
            let answers = service_fn(|request| answer(request, events.clone(), fingerprint));
            let mut http = hyper::server::conn::http1::Builder::new();
            let served = http
                .timer(TokioTimer::new())
                .header_read_timeout(ASKS_WITHIN)
                .keep_alive(false)
                .serve_connection(TokioIo::new(stream), answers)
                .await;
            if let Err(error) = served {
                tracing::debug!(%error, "a question was not heard to its end");
            }
        });
    }
}

async fn answer(
    request: Request<Incoming>,
    events: mpsc::Sender<Event>,
    fingerprint: [u8; 32],
) -> Result<Response<Full<Bytes>>, std::convert::Infallible> {
    let path = request.uri().path().to_owned();
    let (status, text) = if request.method() == Method::GET {
        match path.as_str() {
            "/livez" => (StatusCode::OK, "lives\n".to_owned()),
            "/readyz" => match figures(&events).await {
                Some(_) => (StatusCode::OK, "the room answers\n".to_owned()),
                None => (StatusCode::SERVICE_UNAVAILABLE, SILENT_ROOM.to_owned()),
            },
            "/metrics" => match figures(&events).await {
                Some(figures) => (StatusCode::OK, page(&figures)),
                None => (StatusCode::SERVICE_UNAVAILABLE, SILENT_ROOM.to_owned()),
            },
            "/lesson" => match lesson(&events).await {
                Some((lesson, figures)) => (StatusCode::OK, lesson.to_json(&figures)),
                None => (StatusCode::SERVICE_UNAVAILABLE, SILENT_ROOM.to_owned()),
            },
            _ => (StatusCode::NOT_FOUND, "ask for /livez, /readyz, /metrics or /lesson\n".to_owned()),
        }
    } else if request.method() == Method::POST && path == "/order" {
        order(request, &events, &fingerprint).await
    } else {
        (StatusCode::METHOD_NOT_ALLOWED, "nothing can be changed here but by POST /order\n".to_owned())
    };
    let mut response = Response::new(Full::new(Bytes::from(text)));
    *response.status_mut() = status;
    let kind = match (path.as_str(), status) {
        ("/metrics", StatusCode::OK) => "text/plain; version=0.0.4; charset=utf-8",
        ("/lesson", StatusCode::OK) => "application/json",
        _ => "text/plain; charset=utf-8",
    };
    response.headers_mut().insert(hyper::header::CONTENT_TYPE, hyper::header::HeaderValue::from_static(kind));
    Ok(response)
}

/// Carries out an order: its words are the body, and the teacher's token stands in the head. The code is told with the fingerprint of the
/// certificate that is served.
async fn order(
    request: Request<Incoming>,
    events: &mpsc::Sender<Event>,
    fingerprint: &[u8; 32],
) -> (StatusCode, String) {
    let head = request.headers().get(hyper::header::AUTHORIZATION).and_then(|head| head.to_str().ok());
    let Some(Ok(token)) = head.and_then(|head| head.strip_prefix("Bearer ")).map(str::parse) else {
        return (StatusCode::UNAUTHORIZED, "an order needs the teacher's token\n".to_owned());
    };
    let body = Limited::new(request.into_body(), ORDER_MAX).collect();
    let Ok(Ok(body)) = tokio::time::timeout(ASKS_WITHIN, body).await else {
        return (StatusCode::BAD_REQUEST, "that is no order\n".to_owned());
    };
    let body = body.to_bytes();
    let Some((lesson, _)) = lesson(events).await else {
        return (StatusCode::SERVICE_UNAVAILABLE, SILENT_ROOM.to_owned());
    };
    let order = match order_of(&String::from_utf8_lossy(&body), lesson.now()) {
        Ok(order) => order,
        Err(error) => return (StatusCode::BAD_REQUEST, format!("{error}\n")),
    };
    let (answer, answered) = oneshot::channel();
    let asked = async {
        events.send(Event::Order(token, order, answer)).await.ok()?;
        answered.await.ok()
    };
    match tokio::time::timeout(READY_WITHIN, asked).await {
        Ok(Some(Ok(room))) => {
            let code = room.parse::<JoinCode>().map_or(room, |code| code.on_server(fingerprint).to_string());
            (StatusCode::OK, format!("done; the code is {code}\n"))
        }
        Ok(Some(Err(NoOrder::NotTeacher))) => {
            // who guesses tokens guesses slowly
            tokio::time::sleep(READY_WITHIN).await;
            (StatusCode::FORBIDDEN, "that is not the teacher's token\n".to_owned())
        }
        Ok(Some(Err(NoOrder::TooLongAgo { oldest }))) => {
            let seconds = lesson.now().0.saturating_sub(oldest) / 1000;
            (StatusCode::CONFLICT, format!("the wheel remembers {seconds} s and no more\n"))
        }
        Ok(Some(Err(reason))) => (StatusCode::CONFLICT, format!("{reason}\n")),
        Ok(None) | Err(_) => (StatusCode::SERVICE_UNAVAILABLE, SILENT_ROOM.to_owned()),
    }
}

async fn lesson(events: &mpsc::Sender<Event>) -> Option<(Lesson, Figures)> {
    let (answer, answered) = oneshot::channel();
    let asked = async {
        events.send(Event::Lesson(answer)).await.ok()?;
        answered.await.ok()
    };
    let lesson = tokio::time::timeout(READY_WITHIN, asked).await.ok()??;
    Some((lesson, figures(events).await?))
}

async fn figures(events: &mpsc::Sender<Event>) -> Option<Figures> {
    let (answer, answered) = oneshot::channel();
    let asked = async {
        events.send(Event::Figures(answer)).await.ok()?;
        answered.await.ok()
    };
    tokio::time::timeout(READY_WITHIN, asked).await.ok()?
}

/// The figures in the text format that Prometheus reads (version 0.0.4).
fn page(figures: &Figures) -> String {
    let mut page = String::new();
    let mut one = |name: &str, kind: &str, help: &str, value: u64| {
        writeln!(page, "# HELP pottery_{name} {help}\n# TYPE pottery_{name} {kind}\npottery_{name} {value}")
            .expect("a string takes everything");
    };
    let counts = &figures.counts;
    one("ticks_total", "counter", "Milliseconds of the studio's time that were done.", figures.ticks);
    one("late_total", "counter", "Times the room woke up later than it was to by more than 15 ms.", figures.late);
    one("people", "gauge", "People who are in, those who look on included.", figures.people as u64);
    one("joined_total", "counter", "People let in.", counts.joined);
    one("refused_total", "counter", "Connections refused by the room.", counts.refused);
    one(
        "turned_away_total",
        "counter",
        "Connections not taken, since their address knocks too often.",
        figures.turned_away,
    );
    one(
        "datagrams_unheard_total",
        "counter",
        "Datagrams that were not heard, since their address sends too much.",
        figures.input.unheard,
    );
    one("requests_held_total", "counter", "Requests that had to wait for the same reason.", figures.input.held);
    one("datagrams_total", "counter", "Datagrams handed to connections.", figures.datagrams);
    one("datagram_bytes_total", "counter", "Their bytes, without UDP, IP and QUIC.", figures.datagram_bytes);
    one("datagrams_dropped_total", "counter", "Datagrams that a connection could not take.", figures.dropped_datagrams);
    one("repeats_total", "counter", "Requests to say again what was lost.", counts.repeats);
    one("resyncs_total", "counter", "Requests for keyframes.", counts.resyncs);
    one(
        "never_were_total",
        "counter",
        "Requests of both kinds for a snapshot that never was, refused.",
        counts.never_were,
    );
    one("samples_refused_total", "counter", "Samples of tools that were refused.", counts.refusals.total());
    one("pots_written_total", "counter", "Pots written to the data folder.", figures.store.written);
    one("pots_unwritten", "gauge", "Pots in a row that could not be written.", figures.store.failures);
    page.push_str("# HELP pottery_wheel_people People who work at a wheel.\n# TYPE pottery_wheel_people gauge\n");
    for (wheel, people) in (1..).zip(&figures.people_at) {
        writeln!(page, "pottery_wheel_people{{wheel=\"{wheel}\"}} {people}").expect("a string takes everything");
    }
    page.push_str(
        "# HELP pottery_wake_seconds Time of the room's work from one wake-up on, with all that is sent.\n\
         # TYPE pottery_wake_seconds histogram\n",
    );
    let (mut sum_us, mut seen) = (0, 0);
    let mut below = [0; CLASSES_US.len()];
    for bucket in figures.wake_us.iter_recorded() {
        let (us, count) = (bucket.value_iterated_to(), bucket.count_at_value());
        sum_us += us * count;
        seen += count;
        for (below, _) in below.iter_mut().zip(CLASSES_US).filter(|(_, class)| us <= *class) {
            *below += count;
        }
    }
    for (below, class_us) in below.iter().zip(CLASSES_US) {
        writeln!(page, "pottery_wake_seconds_bucket{{le=\"{}\"}} {below}", class_us as f64 / 1e6)
            .expect("a string takes everything");
    }
    writeln!(
        page,
        "pottery_wake_seconds_bucket{{le=\"+Inf\"}} {seen}\npottery_wake_seconds_sum {}\npottery_wake_seconds_count {seen}",
        sum_us as f64 * 1e-6
    )
    .expect("a string takes everything");
    page
}

/// The port for it; call it within a runtime.
///
/// # Errors
/// [`ServerError::Operate`] when it cannot be had.
pub(crate) fn listen(address: SocketAddr) -> Result<TcpListener, ServerError> {
    let bound = std::net::TcpListener::bind(address).and_then(|listener| {
        listener.set_nonblocking(true)?;
        TcpListener::from_std(listener)
    });
    bound.map_err(|source| ServerError::Operate { address, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_adds_up_and_every_figure_says_what_it_is() {
        let mut figures = Figures { people_at: vec![2, 0], ..Figures::default() };
        for us in [50, 150, 900, 20_000, 3_000_000] {
            figures.note_wake(Duration::from_micros(us));
        }
        let page = page(&figures);
        for line in [
            "pottery_wheel_people{wheel=\"1\"} 2",
            "pottery_wheel_people{wheel=\"2\"} 0",
            "pottery_wake_seconds_bucket{le=\"0.0001\"} 1",
            "pottery_wake_seconds_bucket{le=\"0.001\"} 3",
            "pottery_wake_seconds_bucket{le=\"0.033333\"} 4",
            "pottery_wake_seconds_bucket{le=\"+Inf\"} 5",
            "pottery_wake_seconds_count 5",
        ] {
            assert!(page.lines().any(|said| said == line), "{line} in {page}");
        }
        for line in page.lines().filter(|line| !line.starts_with('#')) {
            let name = line.split(['{', ' ']).next().unwrap_or_default();
            let family = ["_bucket", "_sum", "_count"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name);
            assert!(page.contains(&format!("# TYPE {family} ")), "{line}");
        }
    }
}
