//! Guidance in the panel: a teacher's hand on a student's, what was recorded to be shown, and what the pot is to become.
//!
//! Owns what the person asks for until it is sent, and the figures; who may guide is the room's to say.
//! Invariant: who is guided always sees how to let go; a sentence stays for [`SAID_FOR`] and no longer.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use egui::RichText;
use pottery_client::boundary::{GuidedFigures, Status};
use pottery_client::guiding::{GuidanceShown, GuideCommand, SPEEDS};
use pottery_client::view::View;
use pottery_shared::clay::{Deviation, Form, PotSpec, Target};
use pottery_shared::haptics::{Guidance as How, GuidanceMode};
use pottery_shared::protocol::{GuidanceEnd, Nickname, NoGuidance, Role};
use pottery_shared::snapshot::PotRecord;

use super::{People, WIDTH, nickname, part, profiles};
use crate::words::Words;

/// How long a sentence stays.
const SAID_FOR: Duration = Duration::from_secs(5);
/// Time between two looks at how far the pot is from what it is to become.
const COMPARE_EVERY: Duration = Duration::from_millis(250);
/// Height of the picture of both profiles, points.
const PICTURE: f32 = 130.0;

/// Whose hand guides whom, from this window's side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Part {
    #[default]
    None,
    Teacher,
    Student,
}

/// How a pot is compared with what it is to become.
#[derive(Clone, Debug)]
struct Comparison {
    target: Target,
    is: Target,
    deviation: Deviation,
}

/// Where a target is taken from, besides the forms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::window) enum Wanted {
    /// What is on the own wheel.
    Pot,
    /// The pot file whose name stands in the panel.
    File,
}

/// Guidance of one window.
#[derive(Debug)]
pub(in crate::window) struct Guidance {
    part: Part,
    teaches: bool,
    /// Those who can be guided, and what everybody is called.
    students: Vec<u16>,
    names: BTreeMap<u16, Nickname>,
    student: Option<u16>,
    /// What the own wheel's pot was made from.
    spec: PotSpec,
    mode: GuidanceMode,
    percent: u8,
    speed: f64,
    shown: GuidanceShown,
    figures: Option<GuidedFigures>,
    compared: Option<(Instant, Comparison)>,
    said: Option<(Instant, String)>,
    wishes: Vec<GuideCommand>,
    wanted: Option<Wanted>,
    lets_go: bool,
    /// Whether somebody was to be guided where there is nobody.
    lacks_student: bool,
}

impl Default for Guidance {
    fn default() -> Self {
        Self {
            part: Part::None,
            teaches: false,
            students: Vec::new(),
            names: BTreeMap::new(),
            student: None,
            spec: PotSpec::default(),
            mode: GuidanceMode::Lead,
            percent: 50,
            speed: 1.0,
            shown: GuidanceShown::default(),
            figures: None,
            compared: None,
            said: None,
            wishes: Vec::new(),
            wanted: None,
            lets_go: false,
            lacks_student: false,
        }
    }
}

impl Guidance {
    /// Takes in what is known of guidance.
    pub(in crate::window) fn hear(&mut self, view: &mut View, status: &Status, words: &Words) {
        self.shown = view.guidance.clone();
        self.spec = *view.pot.spec();
        self.figures = status.guided();
        self.teaches = view.class.place().is_some_and(|place| place.role == Role::Teacher);
        let part_before = self.part;
        self.part = match self.shown.pair {
            None => Part::None,
            Some(pair) if pair.student == view.number => Part::Student,
            Some(_) => Part::Teacher,
        };
        self.names = view.class.people().map(|person| (person.client, person.name)).collect();
        let others = view.class.people().filter(|person| person.role == Role::Student && person.works);
        self.students = others.map(|person| person.client).collect();
        self.student = self.student.filter(|student| self.students.contains(student));
        let ended = view.guidance.ended.take().map(|why| words.say(ended(why, part_before)));
        let refused = view.guidance.refused.take().map(|why| words.say(refused(why)));
        let lacking = std::mem::take(&mut self.lacks_student).then(|| words.say("no-guidance-student"));
        if let Some(sentence) = ended.or(refused).or(lacking) {
            self.said = Some((Instant::now(), sentence));
        }
        self.said.take_if(|(at, _)| at.elapsed() > SAID_FOR);
        let Some(target) = &self.shown.target else {
            self.compared = None;
            return;
        };
        let is_due = |(at, known): &(Instant, Comparison)| at.elapsed() > COMPARE_EVERY || known.target != *target;
        if self.compared.as_ref().is_none_or(is_due) {
            let (is, deviation) = (Target::of(&view.pot), target.deviation(&view.pot));
            self.compared = Some((Instant::now(), Comparison { target: target.clone(), is, deviation }));
        }
    }

    /// What the person asked for, in order.
    pub(in crate::window) fn take_wishes(&mut self) -> Vec<GuideCommand> {
        std::mem::take(&mut self.wishes)
    }

    /// Whether the own hand is to be free in the next tick.
    pub(in crate::window) fn take_release(&mut self) -> bool {
        std::mem::take(&mut self.lets_go)
    }

    /// Where the target is to be taken from, if one was asked for.
    pub(in crate::window) fn take_wanted(&mut self) -> Option<Wanted> {
        self.wanted.take()
    }

    /// Makes a profile the target of everybody.
    pub(in crate::window) fn aim_at(&mut self, target: Target) {
        self.wishes.push(GuideCommand::Target(Some(Box::new(target))));
    }

    /// Says a sentence for a while.
    pub(in crate::window) fn say(&mut self, sentence: String) {
        self.said = Some((Instant::now(), sentence));
    }

    /// The key that always ends it; a teacher who guides nobody takes over with it.
    pub(in crate::window) fn take_over_or_let_go(&mut self) {
        match self.part {
            Part::None => self.guide(How::TAKE_OVER),
            Part::Student | Part::Teacher => self.let_go(),
        }
    }

    /// Guides the chosen student in the chosen way, or lets go.
    pub(in crate::window) fn switch(&mut self) {
        match self.part {
            Part::None => self.guide(How::new(self.mode, f32::from(self.percent) / 100.0)),
            Part::Student | Part::Teacher => self.let_go(),
        }
    }

    /// Whether what is recorded is a line of the panel, without which nobody would see that something is.
    fn shows_record(&self) -> bool {
        self.teaches && self.part != Part::Student
    }

    /// Begins to record the own hand, or keeps what was recorded.
    pub(in crate::window) fn record(&mut self) {
        if !self.shows_record() {
            return;
        }
        self.wishes.push(if self.shown.is_recording { GuideCommand::Keep } else { GuideCommand::Record });
    }

    /// Shows what was recorded, or the own hand again.
    pub(in crate::window) fn play(&mut self) {
        if !self.shows_record() {
            return;
        }
        let plays = self.shown.played_s.is_some();
        self.wishes.push(if plays { GuideCommand::Halt } else { GuideCommand::Play(self.speed) });
    }

    fn let_go(&mut self) {
        self.lets_go = self.part == Part::Student;
        self.wishes.push(GuideCommand::End);
    }

    fn guide(&mut self, guidance: How) {
        if !self.teaches {
            return;
        }
        self.student = self.student.or(self.students.first().copied());
        match self.student {
            Some(student) => self.wishes.push(GuideCommand::Guide { student, guidance }),
            None => self.lacks_student = true,
        }
    }

    /// Lays the controls out; `people` are those of the lesson.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, words: &Words, people: &People) {
        let is_shown = self.teaches || self.part != Part::None || self.compared.is_some() || self.said.is_some();
        if !is_shown {
            return;
        }
        let title = RichText::new(words.say("guidance")).strong();
        if self.shows_record() {
            // folded as long as there is nobody to guide
            let is_alone = self.students.is_empty();
            let header = egui::CollapsingHeader::new(title).id_salt(("guidance", is_alone)).default_open(!is_alone);
            part(ui, "guidance", |ui| header.show(ui, |ui| self.show_teacher(ui, words)));
        } else {
            ui.label(title);
            if self.part == Part::Student {
                self.show_student(ui, words);
            }
        }
        if let Some((_, sentence)) = &self.said {
            ui.label(RichText::new(sentence).small());
        }
        if let Some((_, comparison)) = &self.compared {
            show_comparison(ui, words, comparison);
            people.show_progress(ui, words, &comparison.target);
        }
        ui.separator();
    }

    /// Who guides this hand and how, where somebody does.
    fn guided_by(&self, words: &Words) -> Option<String> {
        let pair = self.shown.pair.filter(|_| self.part == Part::Student)?;
        let (name, mode) =
            (name_in(&self.names, words, pair.teacher), words.say(&format!("guide-{}", pair.guidance.mode().name())));
        let percent = words.number(f64::from(pair.guidance.strength() * 100.0), 0);
        Some(if pair.guidance == How::TAKE_OVER {
            words.say_with("taken-over-by", &[("name", &name)])
        } else {
            words.say_with("guided-by", &[("name", &name), ("mode", &mode), ("percent", &percent)])
        })
    }

    /// The same, and how to let go, for who does not see the controls.
    pub(in crate::window) fn notice(&self, words: &Words) -> Option<String> {
        Some(format!("{} · {}", self.guided_by(words)?, words.say("let-go")))
    }

    fn show_student(&mut self, ui: &mut egui::Ui, words: &Words) {
        let (Some(pair), Some(said)) = (self.shown.pair, self.guided_by(words)) else { return };
        ui.label(said);
        if let Some(figures) = self.figures {
            let (apart, late) = (f64::from(figures.error_m) * 1e3, f64::from(figures.late_s) * 1e3);
            let (apart, late) = (words.number(apart, 1), words.number(late, 0));
            ui.label(words.say_with("guided-apart", &[("apart", &apart), ("late", &late)]));
            if pair.guidance.mode() == GuidanceMode::Lead {
                ui.add(egui::ProgressBar::new(figures.assistance).desired_width(WIDTH).text(words.say("guided-help")));
            }
        }
        if let Some(hand) = self.shown.hand {
            let force = words.number(f64::from(hand.force_n), 2);
            let bar = egui::ProgressBar::new((hand.force_n / 3.3).clamp(0.0, 1.0)).desired_width(WIDTH);
            ui.add(bar.text(words.say_with("guided-force", &[("force", &force)])));
        }
        if ui.button(RichText::new(words.say("let-go")).strong()).clicked() {
            self.let_go();
        }
    }

    fn show_teacher(&mut self, ui: &mut egui::Ui, words: &Words) {
        let names = self.names.clone();
        let named = |student: u16| name_in(&names, words, student);
        let chosen = self.student.map_or_else(|| words.say("guide-nobody"), named);
        egui::ComboBox::from_id_salt("student").selected_text(chosen).show_ui(ui, |ui| {
            for student in &self.students {
                ui.selectable_value(&mut self.student, Some(*student), named(*student));
            }
        });
        let before = (self.mode, self.percent);
        ui.horizontal_wrapped(|ui| {
            for mode in GuidanceMode::ALL {
                let name = words.say(&format!("guide-{}", mode.name()));
                ui.selectable_value(&mut self.mode, mode, name)
                    .on_hover_text(words.say(&format!("guide-{}-hint", mode.name())));
            }
        });
        ui.add(egui::Slider::new(&mut self.percent, 0..=100).suffix(" %").text(words.say("guide-strength")));
        if self.part == Part::Teacher && before != (self.mode, self.percent) {
            self.guide(How::new(self.mode, f32::from(self.percent) / 100.0));
        }
        ui.horizontal(|ui| {
            let guides = self.part == Part::Teacher;
            if ui.button(words.say(if guides { "let-go" } else { "guide" })).clicked() {
                self.switch();
            }
            if ui.add_enabled(!guides, egui::Button::new(words.say("take-over"))).clicked() {
                self.guide(How::TAKE_OVER);
            }
            if ui.add_enabled(!self.shown.lines.is_empty(), egui::Button::new(words.say("wipe"))).clicked() {
                self.wishes.push(GuideCommand::Wipe);
            }
        });
        ui.horizontal(|ui| {
            let record = if self.shown.is_recording { "record-keep" } else { "record" };
            if ui.button(words.say(record)).clicked() {
                self.record();
            }
            let can_play = self.shown.recorded_s > 0.0;
            let play = if self.shown.played_s.is_some() { "play-halt" } else { "play" };
            if ui.add_enabled(can_play, egui::Button::new(words.say(play))).clicked() {
                self.play();
            }
            ui.label(format!("{} s", words.number(self.shown.played_s.unwrap_or(self.shown.recorded_s), 1)));
        });
        let mut percent = self.speed * 100.0;
        let slider = egui::Slider::new(&mut percent, SPEEDS.0 * 100.0..=SPEEDS.1 * 100.0).suffix(" %").integer();
        ui.add(slider.text(words.say("play-speed")));
        self.speed = percent / 100.0;
        self.show_targets(ui, words);
    }

    fn show_targets(&mut self, ui: &mut egui::Ui, words: &Words) {
        ui.menu_button(words.say("target"), |ui| {
            for (name, wanted) in [("target-pot", Wanted::Pot), ("target-file", Wanted::File)] {
                if ui.button(words.say(name)).clicked() {
                    self.wanted = Some(wanted);
                    ui.close();
                }
            }
            for form in Form::ALL {
                if ui.button(words.say(&format!("form-{}", form.name()))).clicked() {
                    match form.of_clay_of(self.spec) {
                        // as high as the same clay gets in that form
                        Ok(pot) => self.aim_at(Target::of(&PotRecord::of(&pot).pot())),
                        Err(error) => self.say(error.to_string()),
                    }
                    ui.close();
                }
            }
            if ui.button(words.say("target-none")).clicked() {
                self.wishes.push(GuideCommand::Target(None));
                ui.close();
            }
        });
    }
}

/// What somebody is called, by the number as long as the name was not told.
fn name_in(names: &BTreeMap<u16, Nickname>, words: &Words, client: u16) -> String {
    let number = || words.say_with("potter", &[("number", &client.to_string())]);
    names.get(&client).map_or_else(number, |name| nickname(words, *name))
}

/// What is said of an end to who had that part.
const fn ended(why: GuidanceEnd, part: Part) -> &'static str {
    match (why, part) {
        (GuidanceEnd::Teacher, Part::Teacher) | (GuidanceEnd::Student, Part::Student) => "ended-own",
        (GuidanceEnd::Teacher, _) => "ended-teacher",
        (GuidanceEnd::Student, _) => "ended-student",
        (GuidanceEnd::Gone, _) => "ended-gone",
        (GuidanceEnd::Replaced, _) => "ended-replaced",
    }
}

const fn refused(why: NoGuidance) -> &'static str {
    match why {
        NoGuidance::NotTeacher => "no-guidance-teacher",
        NoGuidance::Nobody | NoGuidance::Oneself => "no-guidance-nobody",
        NoGuidance::NoHand => "no-guidance-hand",
        NoGuidance::Unknown => "no-guidance-unknown",
    }
}

/// The figure and the picture of how far the pot is from what it is to become.
fn show_comparison(ui: &mut egui::Ui, words: &Words, comparison: &Comparison) {
    let Deviation { rms_m, most_m, most_at_m, higher_m } = comparison.deviation;
    let mm = |metres: f32, decimals| words.number(f64::from(metres) * 1e3, decimals);
    let figures =
        [("rms", &mm(rms_m, 1)), ("most", &mm(most_m, 1)), ("at", &mm(most_at_m, 0)), ("higher", &mm(higher_m, 0))];
    ui.label(words.say_with("target-figures", &figures.map(|(name, figure)| (name, figure.as_str()))));
    let (response, painter) = ui.allocate_painter(egui::vec2(WIDTH, PICTURE), egui::Sense::hover());
    profiles::paint(&painter, response.rect, &comparison.target, &comparison.is);
}
