//! Orders in words, for who teaches at a terminal.
//!
//! Owns the words; what an order does is the room's.
//! Invariant: whatever is not understood is answered with what can be said.

use pottery_shared::clay::{Form, Material, Preset, Wheel};
use pottery_shared::protocol::{Order, PotOf};
use pottery_shared::units::Tick;

/// Every order: how it is said, and what it does.
///
/// PERSON is the number that somebody has in the lesson, WHEEL a wheel's number, from 1; `all` stands for all of them, but not where somebody is seated.
pub const ORDERS: [(&str, &str); 20] = [
    ("lock", "let nobody else in"),
    ("unlock", "let people in again"),
    ("new-code", "make another code; the one before lets nobody in"),
    ("lobby", "let who comes wait for the teacher"),
    ("no-lobby", "let who comes in at once"),
    ("admit PERSON", "let in who waits"),
    ("refuse PERSON", "send away who waits"),
    ("end", "end the lesson: students are sent home"),
    ("seat PERSON WHEEL", "let somebody work at a wheel"),
    ("look-on PERSON WHEEL", "let somebody look on at a wheel"),
    ("freeze WHEEL", "let no press count at a wheel"),
    ("thaw WHEEL", "let them count again"),
    ("open WHEEL", "let people work at a wheel"),
    ("close WHEEL", "let nobody work there"),
    ("speed WHEEL RPM", "turn it so fast, the other way below zero"),
    ("clay WHEEL KIND", "stiff, throwing, soft or slip"),
    ("pot WHEEL FORM", "a new cylinder, bowl, bottle or ball; first: as the wheel began"),
    ("copy WHEEL FROM", "the pot that is on the wheel FROM"),
    ("back WHEEL SECONDS", "the pot that was there so long ago"),
    ("take-back WHEEL", "what was put there last from here is gone again"),
];

/// Why words are no order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OrderError {
    /// A word that is none.
    #[error("'{word}' is not understood: say {}", verbs())]
    Unknown {
        /// The word.
        word: String,
    },
    /// An order that is said otherwise.
    #[error("say '{form}'{}", explained(form))]
    Form {
        /// How.
        form: &'static str,
    },
}

/// The first words of all orders, in a row.
fn verbs() -> String {
    let verbs: Vec<_> = ORDERS.iter().map(|(form, _)| verb_of(form)).collect();
    let (last, others) = verbs.split_last().expect("there are orders");
    format!("{} or {last}", others.join(", "))
}

fn verb_of(form: &'static str) -> &'static str {
    form.split(' ').next().unwrap_or_default()
}

/// What the capital words of an order stand for.
fn explained(form: &str) -> String {
    let most = Wheel::RPM_MAX.0;
    let of = |word: &str| match word {
        "PERSON" if form.contains("WHEEL") => Some("PERSON is a number that the console shows".into()),
        "PERSON" => Some("PERSON is a number that the console shows, or all".into()),
        "WHEEL" if form.contains("PERSON") => Some("WHEEL is a wheel's number, from 1".into()),
        "WHEEL" => Some("WHEEL is a wheel's number, from 1, or all".into()),
        "FROM" => Some("FROM is a wheel's number, from 1".into()),
        "RPM" => Some(format!("RPM is from {} to {most}", -most)),
        "KIND" => Some(format!("KIND is {}", Preset::ALL.map(Preset::name).join(", "))),
        "FORM" => Some(format!("FORM is {} or first", Form::ALL.map(Form::name).join(", "))),
        "SECONDS" => Some("SECONDS is more than nothing".into()),
        _ => None,
    };
    let words: Vec<String> = form.split(' ').filter_map(of).collect();
    if words.is_empty() { " and nothing else".into() } else { format!(": {}", words.join("; ")) }
}

/// The order that words mean which are said at a tick.
///
/// ```
/// use pottery_server::order_of;
/// use pottery_shared::protocol::Order;
/// use pottery_shared::units::Tick;
/// let now = Tick(60_000);
/// assert_eq!(order_of("freeze 2", now), Ok(Order::Freeze { wheel: 2, is_frozen: true }));
/// assert_eq!(order_of("back all 20", now), Ok(Order::GoBack { wheel: 0, to: 40_000 }));
/// assert_eq!(order_of("lock", now), Ok(Order::Lock { is_locked: true }));
/// assert!(order_of("freeze", now).is_err() && order_of("dance", now).is_err());
/// ```
///
/// # Errors
/// [`OrderError`] saying what can be said.
pub fn order_of(words: &str, now: Tick) -> Result<Order, OrderError> {
    let words: Vec<_> = words.split_whitespace().collect();
    let verb = *words.first().unwrap_or(&"");
    let Some((form, _)) = ORDERS.iter().find(|(form, _)| verb_of(form) == verb) else {
        return Err(OrderError::Unknown { word: verb.to_owned() });
    };
    said(&words, now).ok_or(OrderError::Form { form })
}

/// The order, where every word is as it is to be.
fn said(words: &[&str], now: Tick) -> Option<Order> {
    let number = |word: &str| word.parse().ok().filter(|number: &u16| *number > 0);
    let any = |word: &str| if word == "all" { Some(0) } else { number(word) };
    let order = match *words {
        ["lock"] => Order::Lock { is_locked: true },
        ["unlock"] => Order::Lock { is_locked: false },
        ["new-code"] => Order::NewCode,
        ["lobby"] => Order::Lobby { is_on: true },
        ["no-lobby"] => Order::Lobby { is_on: false },
        ["admit", person] => Order::Admit { client: any(person)?, is_admitted: true },
        ["refuse", person] => Order::Admit { client: any(person)?, is_admitted: false },
        ["end"] => Order::End,
        ["seat", person, wheel] => Order::Seat { client: number(person)?, wheel: number(wheel)?, works: true },
        ["look-on", person, wheel] => Order::Seat { client: number(person)?, wheel: number(wheel)?, works: false },
        ["freeze", wheel] => Order::Freeze { wheel: any(wheel)?, is_frozen: true },
        ["thaw", wheel] => Order::Freeze { wheel: any(wheel)?, is_frozen: false },
        ["open", wheel] => Order::Open { wheel: any(wheel)?, is_open: true },
        ["close", wheel] => Order::Open { wheel: any(wheel)?, is_open: false },
        ["speed", wheel, rpm] => {
            let rpm = rpm.parse().ok().filter(|rpm: &f32| rpm.abs() <= Wheel::RPM_MAX.0)?;
            Order::WheelSpeed { wheel: any(wheel)?, rpm }
        }
        ["clay", wheel, kind] => {
            let clay = Material::from_wetness(Preset::from_name(kind)?.wetness());
            Order::Clay { wheel: any(wheel)?, clay: clay.into() }
        }
        ["pot", wheel, form] => {
            // no form has that number
            let form = if form == "first" { 0 } else { Form::from_name(form)?.number() };
            Order::Pot { wheel: any(wheel)?, of: PotOf::Form(form) }
        }
        ["copy", wheel, from] => Order::Pot { wheel: any(wheel)?, of: PotOf::Wheel(number(from)?) },
        ["back", wheel, seconds] => {
            let ticks = seconds.parse().ok().filter(|seconds: &f64| *seconds > 0.0)? * 1e3;
            Order::GoBack { wheel: any(wheel)?, to: now.0.saturating_sub(ticks as u64) }
        }
        ["take-back", wheel] => Order::TakeBack { wheel: any(wheel)? },
        _ => return None,
    };
    Some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Tick = Tick(100_000);

    #[test]
    fn every_order_is_understood_as_it_is_said_and_in_no_other_way() {
        for (form, _) in ORDERS {
            let filled = form
                .replace("PERSON", "3")
                .replace("WHEEL", "2")
                .replace("FROM", "1")
                .replace("RPM", "-90.5")
                .replace("KIND", "soft")
                .replace("FORM", "bowl")
                .replace("SECONDS", "2.5");
            assert!(order_of(&filled, NOW).is_ok(), "{filled}");
            assert_eq!(order_of(&format!("{filled} 1"), NOW), Err(OrderError::Form { form }));
            for (place, word) in filled.split(' ').enumerate().skip(1) {
                for wrong in ["", "0", "-1", "70000", "nan", "inf", "Bowl", "2,5"] {
                    // what counts otherwise may be one of them
                    if form.contains("RPM") && place == 2 && ["0", "-1"].contains(&wrong)
                        || form.contains("SECONDS") && place == 2 && ["70000", "inf"].contains(&wrong)
                    {
                        continue;
                    }
                    let said = filled.replacen(&format!(" {word}"), &format!(" {wrong}"), 1);
                    assert_eq!(order_of(&said, NOW), Err(OrderError::Form { form }), "{said}");
                }
            }
        }
    }

    #[test]
    fn who_is_not_understood_is_told_what_can_be_said() {
        let said = |words| order_of(words, NOW).unwrap_err().to_string();
        assert!(said("dance").starts_with("'dance' is not understood: say lock, unlock, "));
        assert!(said("").ends_with(" back or take-back"));
        assert_eq!(said("freeze"), "say 'freeze WHEEL': WHEEL is a wheel's number, from 1, or all");
        assert_eq!(said("lock 2"), "say 'lock' and nothing else");
        assert_eq!(
            said("speed 1 500"),
            "say 'speed WHEEL RPM': WHEEL is a wheel's number, from 1, or all; RPM is from -400 to 400"
        );
        assert_eq!(
            said("seat all 2"),
            "say 'seat PERSON WHEEL': PERSON is a number that the console shows; WHEEL is a wheel's number, from 1"
        );
    }

    #[test]
    fn what_was_long_ago_is_the_beginning_at_most() {
        assert_eq!(order_of("back 1 1e300", NOW), Ok(Order::GoBack { wheel: 1, to: 0 }));
        assert_eq!(order_of("back 1 2.5", NOW), Ok(Order::GoBack { wheel: 1, to: 97_500 }));
    }
}
