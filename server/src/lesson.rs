//! How the lesson stands, for who looks at it on the server's own machine, and orders in words.
//!
//! Owns the page's form and the words; what an order does is the room's.
//! Invariant: the page holds neither the code nor a token.

use pottery_shared::protocol::{Order, PersonWire, Presence, WheelInfo};
use pottery_shared::room::Room;
use serde_json::json;

use crate::Figures;

/// One wheel.
#[derive(Debug)]
struct WheelNow {
    info: WheelInfo,
    people: usize,
    rpm: f32,
    /// Ticks since its newest snapshot, where somebody is.
    age: Option<u64>,
}

/// The lesson at a moment.
#[derive(Debug)]
pub(crate) struct Lesson {
    ticks: u64,
    people: Vec<PersonWire>,
    wheels: Vec<WheelNow>,
    is_locked: bool,
    has_lobby: bool,
}

impl Lesson {
    pub(crate) fn of(room: &Room) -> Self {
        let lesson = room.lesson();
        let wheels = lesson.wheels.into_iter().enumerate().map(|(wheel, info)| WheelNow {
            info,
            people: room.people_at(wheel),
            rpm: room.conditions(wheel).map_or(0.0, |conditions| conditions.wheel.speed(room.now()).0),
            age: room.snapshot_age(wheel),
        });
        Self {
            ticks: room.now().0,
            wheels: wheels.collect(),
            people: room.everybody(),
            is_locked: lesson.is_locked,
            has_lobby: lesson.has_lobby,
        }
    }

    /// As one JSON object, with how long the room's work took so far: `[µs, wake-ups that took so long]`.
    pub(crate) fn to_json(&self, figures: &Figures) -> String {
        let people = self.people.iter().map(|person| {
            let presence = match person.presence {
                Presence::Here => "here",
                Presence::Away => "away",
                Presence::Waiting => "waiting",
            };
            json!({
                "number": person.client, "name": person.name.to_string(), "role": person.role.name(),
                "wheel": person.wheel, "works": person.works, "presence": presence, "touching": person.touching,
            })
        });
        let wheels = self.wheels.iter().map(|WheelNow { info, people, rpm, age }| {
            json!({
                "open": info.is_open, "frozen": info.is_frozen, "people": people, "rpm": rpm.round(), "age_ms": age,
            })
        });
        let wake_us =
            figures.wake_us.iter_recorded().map(|bucket| (bucket.value_iterated_to(), bucket.count_at_value()));
        let page = json!({
            "ticks": self.ticks, "late": figures.late, "locked": self.is_locked, "lobby": self.has_lobby,
            "people": people.collect::<Vec<_>>(), "wheels": wheels.collect::<Vec<_>>(),
            "wake_us": wake_us.collect::<Vec<_>>(),
        });
        format!("{page}\n")
    }
}

/// Why words are no order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OrderError {
    /// A word that is none.
    #[error(
        "'{word}' is not understood: say lock, unlock, new-code, lobby, no-lobby, admit-all, end, or freeze, thaw, open or close and a wheel's number or all"
    )]
    Unknown {
        /// The word.
        word: String,
    },
    /// A wheel's number is missing or none.
    #[error("that order is about a wheel: say its number, from 1, or all")]
    Wheel,
}

/// The order that words mean.
///
/// ```
/// use pottery_server::order_of;
/// use pottery_shared::protocol::Order;
/// assert_eq!(order_of("freeze 2"), Ok(Order::Freeze { wheel: 2, is_frozen: true }));
/// assert_eq!(order_of("lock"), Ok(Order::Lock { is_locked: true }));
/// assert!(order_of("freeze").is_err() && order_of("dance").is_err());
/// ```
///
/// # Errors
/// [`OrderError`] saying what can be said.
pub fn order_of(words: &str) -> Result<Order, OrderError> {
    let mut words = words.split_whitespace();
    let (verb, which) = (words.next().unwrap_or_default(), words.next());
    let unknown = |word: &str| OrderError::Unknown { word: word.to_owned() };
    if let Some(word) = words.next() {
        return Err(unknown(word));
    }
    let wheel = || match which {
        Some("all") => Ok(0),
        Some(number) => number.parse().ok().filter(|wheel| *wheel > 0).ok_or(OrderError::Wheel),
        None => Err(OrderError::Wheel),
    };
    let order = match verb {
        "freeze" => Order::Freeze { wheel: wheel()?, is_frozen: true },
        "thaw" => Order::Freeze { wheel: wheel()?, is_frozen: false },
        "open" => Order::Open { wheel: wheel()?, is_open: true },
        "close" => Order::Open { wheel: wheel()?, is_open: false },
        "lock" => Order::Lock { is_locked: true },
        "unlock" => Order::Lock { is_locked: false },
        "new-code" => Order::NewCode,
        "lobby" => Order::Lobby { is_on: true },
        "no-lobby" => Order::Lobby { is_on: false },
        "admit-all" => Order::Admit { client: 0, is_admitted: true },
        "end" => Order::End,
        _ => return Err(unknown(verb)),
    };
    match which {
        Some(word) if !matches!(order, Order::Freeze { .. } | Order::Open { .. }) => Err(unknown(word)),
        _ => Ok(order),
    }
}
