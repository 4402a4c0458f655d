//! How the lesson stands, for who looks at it on the server's own machine.
//!
//! Owns the page's form.
//! Invariant: the page holds neither the code nor a token.

use pottery_shared::protocol::{PersonWire, Presence, WheelInfo};
use pottery_shared::room::Room;
use pottery_shared::units::Tick;
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

    /// When it stood so.
    pub(crate) const fn now(&self) -> Tick {
        Tick(self.ticks)
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
