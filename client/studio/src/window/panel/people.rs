//! Who is here, and what a teacher orders: wheels frozen, opened and given pots, people seated, the door, the end.
//!
//! Owns layout and what was asked for until it is sent; who may do what is the room's to say.
//! Invariant: what is shown is what the room told last; a button changes nothing here.

use std::time::{Duration, Instant};

use egui::RichText;
use pottery_client::Command;
use pottery_client::view::View;
use pottery_shared::clay::{Deviation, Form, Material, Target, Wetness};
use pottery_shared::protocol::{
    ClassWire, JoinCode, Nickname, NoOrder, Order, PersonWire, PlaceWire, PotOf, Presence, Role, WheelInfo,
};
use pottery_shared::session::ClassView;
use pottery_shared::units::Tick;

use super::{Person, colour_of, part, profiles};
use crate::words::Words;

/// How long a sentence stays.
const SAID_FOR: Duration = Duration::from_secs(6);
/// Size of the picture of a student's pot over what it is to become, points.
const PICTURE: egui::Vec2 = egui::vec2(44.0, 44.0);
/// How far a wheel is taken back, s.
const BACK_S: [u64; 4] = [10, 30, 60, 300];

/// What somebody is called in the window's language.
pub(in crate::window) fn nickname(words: &Words, name: Nickname) -> String {
    let all = words.say("nicknames");
    let word = all.split(", ").nth(name.word()).unwrap_or("?");
    if name.number() > 1 { format!("{word} {}", name.number()) } else { word.to_owned() }
}

/// Why an order was not carried out, in the window's language.
fn refused(words: &Words, reason: NoOrder, now: Tick) -> String {
    let with = |message, name, number: u64| words.say_with(message, &[(name, &number.to_string())]);
    match reason {
        NoOrder::NotTeacher => words.say("no-order-teacher"),
        NoOrder::Wheel { wheel } => with("no-order-wheel", "wheel", wheel.into()),
        NoOrder::Person { client } => with("no-order-person", "number", client.into()),
        NoOrder::CannotWork => words.say("no-order-cannot"),
        NoOrder::TooLongAgo { oldest } => {
            with("no-order-long-ago", "seconds", now.0.saturating_sub(oldest) / Tick::PER_SECOND)
        }
        NoOrder::NothingBack => words.say("no-order-nothing"),
    }
}

/// The people's part of the panel.
#[derive(Debug, Default)]
pub(in crate::window) struct People {
    class: ClassView,
    /// Which wheel the teacher's buttons are about; 0 for all.
    wheel: u16,
    /// Whether the end was asked for once.
    is_ending: bool,
    now: Tick,
    wishes: Vec<Command>,
    said: Option<(Instant, NoOrder)>,
}

impl People {
    /// Takes in what the room says; the room's time is about `now`.
    pub(in crate::window) fn hear(&mut self, view: &mut View, now: Tick) {
        if self.class != view.class {
            self.class.clone_from(&view.class);
        }
        self.now = now;
        if let Some(reason) = view.no_order.take() {
            self.said = Some((Instant::now(), reason));
        }
        self.said.take_if(|(at, _)| at.elapsed() > SAID_FOR);
    }

    /// What somebody at the wheel is called.
    pub(in crate::window) fn name_of(&self, client: u16) -> Option<Nickname> {
        self.class.people().find(|person| person.client == client).map(|person| person.name)
    }

    /// Whether anybody else is here.
    pub(in crate::window) fn has_others(&self) -> bool {
        let own = self.class.place().map(|own| own.client);
        self.class.people().any(|person| Some(person.client) != own && person.presence == Presence::Here)
    }

    /// The room's part of the join code, for who teaches.
    pub(in crate::window) fn code(&self) -> Option<&str> {
        self.class.class().map(|class| class.code.as_str())
    }

    /// Why what this person presses does not count, as the name of a sentence.
    pub(in crate::window) fn held(&self) -> Option<&'static str> {
        (!self.class.may_press()).then_some("class-held")
    }

    /// Whether this person may change what is on the wheel: on one that is held, a teacher may.
    pub(super) fn may_change(&self) -> bool {
        self.class.may_press() || self.class.place().is_some_and(|own| own.role == Role::Teacher)
    }

    /// What the person asked for, in order.
    pub(in crate::window) fn take_wishes(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.wishes)
    }

    fn order(&mut self, order: Order) {
        self.wishes.push(Command::Order(order));
    }

    /// Lays it out; `at_wheel` are those whose tools are seen, this window's person first.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, words: &Words, at_wheel: &[Person], wetness: f32, rpm: f32) {
        let own = self.class.place().copied();
        let people: Vec<_> = self.class.people().copied().collect();
        let class = self.class.class().cloned();
        let is_teacher = own.is_some_and(|own| own.role == Role::Teacher);
        for person in &people {
            let said = describe(words, person, own.as_ref());
            let seen = at_wheel.iter().find(|seen| match seen.number {
                Some(number) => number == person.client,
                None => own.is_some_and(|own| own.client == person.client),
            });
            let touching = seen.is_some_and(|seen| seen.touching) || person.touching;
            let said = if touching { words.say_with("person-touching", &[("name", &said)]) } else { said };
            let colour = colour_of(crate::window::app::colour(person.client));
            part(ui, ("person", person.client), |ui| {
                ui.horizontal(|ui| {
                    ui.colored_label(colour, said);
                    if is_teacher && let Some(class) = &class {
                        self.show_person(ui, words, person, class);
                    }
                });
            });
        }
        if is_teacher && let Some(class) = class {
            let header = egui::CollapsingHeader::new(words.say("class-lesson")).id_salt("class");
            part(ui, "class", |ui| header.show(ui, |ui| self.show_class(ui, words, &class, (wetness, rpm))));
        }
        if let Some((_, reason)) = self.said {
            ui.label(RichText::new(refused(words, reason, self.now)).small());
        }
    }

    /// How far each wheel's pot is from what it is to become, in a figure and a picture, with those who work there: for who teaches.
    pub(super) fn show_progress(&self, ui: &mut egui::Ui, words: &Words, target: &Target) {
        for (wheel, progress) in self.class.progress() {
            let works = |person: &&PersonWire| person.wheel == *wheel && person.works && person.role == Role::Student;
            let names: Vec<_> = self.class.people().filter(works).map(|person| nickname(words, person.name)).collect();
            if names.is_empty() {
                continue;
            }
            let mm = |metres: f32| words.number(f64::from(metres) * 1e3, 1);
            let Deviation { rms_m, most_m, .. } = progress.deviation;
            let (wheel, names) = (wheel.to_string(), names.join(", "));
            let figures = [("wheel", wheel), ("names", names), ("rms", mm(rms_m)), ("most", mm(most_m))];
            let said = words.say_with("class-progress", &figures.each_ref().map(|(name, said)| (*name, said.as_str())));
            ui.horizontal(|ui| {
                let (response, painter) = ui.allocate_painter(PICTURE, egui::Sense::hover());
                profiles::paint(&painter, response.rect, target, &progress.is);
                ui.add(egui::Label::new(RichText::new(said).small()).wrap());
            });
        }
    }

    /// What can be done with one person.
    fn show_person(&mut self, ui: &mut egui::Ui, words: &Words, person: &PersonWire, class: &ClassWire) {
        let client = person.client;
        if person.presence == Presence::Waiting {
            for (name, is_admitted) in [("class-admit", true), ("class-refuse", false)] {
                if ui.small_button(words.say(name)).clicked() {
                    self.order(Order::Admit { client, is_admitted });
                }
            }
        } else if person.role == Role::Student {
            ui.menu_button("…", |ui| {
                for wheel in 1..=class.wheels.len() as u16 {
                    let is_there = wheel == person.wheel && person.works;
                    let name = words.say_with("class-to-wheel", &[("wheel", &wheel.to_string())]);
                    if ui.add_enabled(!is_there, egui::Button::new(name)).clicked() {
                        self.order(Order::Seat { client, wheel, works: true });
                        ui.close();
                    }
                }
                if ui.add_enabled(person.works, egui::Button::new(words.say("class-looks-on"))).clicked() {
                    self.order(Order::Seat { client, wheel: person.wheel, works: false });
                    ui.close();
                }
            });
        }
    }

    fn show_class(&mut self, ui: &mut egui::Ui, words: &Words, class: &ClassWire, (wetness, rpm): (f32, f32)) {
        let wheels = class.wheels.len() as u16;
        let name = |wheel: u16| match wheel {
            0 => words.say("class-all-wheels"),
            wheel => words.say_with("class-wheel", &[("wheel", &wheel.to_string())]),
        };
        egui::ComboBox::from_id_salt("class-wheel").selected_text(name(self.wheel)).show_ui(ui, |ui| {
            for wheel in 0..=wheels {
                ui.selectable_value(&mut self.wheel, wheel, name(wheel));
            }
        });
        let wheel = self.wheel.min(wheels);
        let meant = || class.wheels.iter().enumerate().filter(|(at, _)| wheel == 0 || *at + 1 == usize::from(wheel));
        let all = |is: fn(&WheelInfo) -> bool| meant().all(|(_, info)| is(info));
        let (is_frozen, is_open) = (all(|info| info.is_frozen), all(|info| info.is_open));
        ui.horizontal(|ui| {
            if ui.button(words.say(if is_frozen { "class-thaw" } else { "class-freeze" })).clicked() {
                self.order(Order::Freeze { wheel, is_frozen: !is_frozen });
            }
            if ui.button(words.say(if is_open { "class-close" } else { "class-open" })).clicked() {
                self.order(Order::Open { wheel, is_open: !is_open });
            }
            if ui.button(words.say("class-settings")).on_hover_text(words.say("class-settings-hint")).clicked() {
                self.order(Order::WheelSpeed { wheel, rpm });
                let clay = Material::from_wetness(Wetness::nearest(wetness)).into();
                self.order(Order::Clay { wheel, clay });
            }
        });
        ui.horizontal(|ui| {
            ui.menu_button(words.say("class-pot"), |ui| {
                for from in 1..=wheels {
                    if ui.button(words.say_with("class-pot-of", &[("wheel", &from.to_string())])).clicked() {
                        self.order(Order::Pot { wheel, of: PotOf::Wheel(from) });
                        ui.close();
                    }
                }
                let forms = Form::ALL.map(|form| (form.number(), words.say(&format!("form-{}", form.name()))));
                for (number, name) in [(0, words.say("new-pot-again"))].into_iter().chain(forms) {
                    if ui.button(name).clicked() {
                        self.order(Order::Pot { wheel, of: PotOf::Form(number) });
                        ui.close();
                    }
                }
            });
            ui.menu_button(words.say("class-back"), |ui| {
                let oldest = meant().map(|(_, info)| info.oldest).max().unwrap_or(0);
                for seconds in BACK_S {
                    let to = self.now.0.saturating_sub(seconds * Tick::PER_SECOND);
                    let name = words.say_with("class-back-by", &[("seconds", &seconds.to_string())]);
                    if ui.add_enabled(to > oldest, egui::Button::new(name)).clicked() {
                        self.order(Order::GoBack { wheel, to });
                        ui.close();
                    }
                }
            });
            if ui.button(words.say("class-take-back")).clicked() {
                self.order(Order::TakeBack { wheel });
            }
        });
        self.show_door(ui, words, class);
    }

    fn show_door(&mut self, ui: &mut egui::Ui, words: &Words, class: &ClassWire) {
        // as it is written everywhere else
        let code = class.code.parse().map_or_else(|_| class.code.clone(), |code: JoinCode| code.to_string());
        ui.label(words.say_with("class-code", &[("code", &code)]));
        ui.horizontal(|ui| {
            let mut is_locked = class.is_locked;
            if ui.checkbox(&mut is_locked, words.say("class-locked")).clicked() {
                self.order(Order::Lock { is_locked });
            }
            let mut is_on = class.has_lobby;
            if ui.checkbox(&mut is_on, words.say("class-lobby")).clicked() {
                self.order(Order::Lobby { is_on });
            }
        });
        ui.horizontal_wrapped(|ui| {
            if ui.button(words.say("class-new-code")).clicked() {
                self.order(Order::NewCode);
            }
            if ui.button(words.say("class-admit-all")).clicked() {
                self.order(Order::Admit { client: 0, is_admitted: true });
            }
            let name = if self.is_ending { "class-end-surely" } else { "class-end" };
            if ui.button(words.say(name)).clicked() {
                if self.is_ending {
                    self.order(Order::End);
                }
                self.is_ending = !self.is_ending;
            }
        });
    }
}

/// Somebody in a line.
fn describe(words: &Words, person: &PersonWire, own: Option<&PlaceWire>) -> String {
    let is_own = own.is_some_and(|own| own.client == person.client);
    let mut said = nickname(words, person.name);
    if is_own {
        said = format!("{said} ({})", words.say("you"));
    }
    let role = match person.role {
        Role::Teacher => Some("class-teacher"),
        Role::Student => None,
        Role::Guest => Some("class-guest"),
    };
    let state = match (person.presence, person.works) {
        (Presence::Waiting, _) => Some("class-waits"),
        (Presence::Away, _) => Some("class-away"),
        (Presence::Here, false) if person.wheel > 0 => Some("class-looks-on"),
        (Presence::Here, _) => None,
    };
    if person.wheel > 0 && own.is_some_and(|own| is_own || own.role == Role::Teacher || own.wheel != person.wheel) {
        said = format!("{said} · {}", words.say_with("class-wheel", &[("wheel", &person.wheel.to_string())]));
    }
    for name in role.into_iter().chain(state) {
        said = format!("{said} · {}", words.say(name));
    }
    said
}
