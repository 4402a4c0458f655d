//! The window's events: what the person does, turned into tool, wheel and view; and when to draw.
//!
//! Owns no clay: reads the potter's view, asks through commands.
//! Invariant: nothing is drawn while nothing changes.

mod fitting;
mod held;
mod input;
mod shown;
mod timing;
mod visiting;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec2;
use pottery_client::device::Pointer;
use pottery_client::pot_file::PotFile;
use pottery_client::render::{Camera, Deflection, GpuAhead, Scene, ToolView, Water};
use pottery_client::view::Link;
use pottery_client::{Command, Potter, sentence};
use pottery_shared::clay::{Material, Phase, Preset, Target, Wetness};
use pottery_shared::units::Rpm;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::ModifiersState;
use winit::window::WindowId;

use self::input::Pointed;
use self::shown::Shown;
use self::timing::Timing;
use super::depth::to_clay_m;
use super::files::Files;
use super::fingers::Fingers;
use super::ghost;
use super::hand::Hand;
use super::holding::Holding;
use super::labels;
use super::lesson::{Lesson, Seen};
use super::looker::tool_view;
use super::overlay::{self, Call, Overlay};
use super::panel::{self, Guidance, History, Invitation, PanelState, People, Person, WETNESS, Wanted};
use super::stage::{Pace, Picture, Stage};
use crate::preferences::Keeper;
use crate::tool_choice::ToolChoice;

pub(super) use self::held::{Held, Rates};
pub(crate) use self::timing::begin as begin_timing;
pub(super) use self::timing::join as time_join;

/// Time between looks at the panel when nothing moves, and after which its figures are read again all the same.
const LOOK_IDLE: Duration = Duration::from_millis(500);
const FIGURES_IDLE: Duration = Duration::from_secs(10);
/// People's colours, linear RGB, in the order of their joining.
const COLOURS: [[f32; 3]; 8] = [
    [0.05, 0.45, 0.75],
    [0.85, 0.55, 0.05],
    [0.20, 0.60, 0.15],
    [0.70, 0.10, 0.35],
    [0.35, 0.20, 0.75],
    [0.05, 0.60, 0.50],
    [0.80, 0.25, 0.05],
    [0.50, 0.50, 0.50],
];

/// Largest share of the window's width beside which a pot is shown.
const COVERS_MAX: f32 = 0.6;
/// What clay loses of its wetness in a minute where it dries, and how often that is done: what is soft is stiff after half an hour, as in a
/// warm room.
const DRYING_PER_MINUTE: f32 = 0.01;
const DRY_EVERY: Duration = Duration::from_secs(15);
/// How wide the hand is that holds a tool of facets, m.
const WET_HAND_M: f32 = 0.012;
/// How long a sentence stays that says why something was not done.
const REFUSED_FOR: Duration = Duration::from_secs(10);
/// How long nothing may come from the server before it is said.
const SILENCE_MAX: Duration = Duration::from_secs(2);
/// Time between two requests: a slider that is dragged asks for where it is, not for everywhere it was.
const ASK_EVERY: Duration = Duration::from_millis(150);
/// Time after which the answer to a request has surely come.
const HEARD_WITHIN: Duration = Duration::from_secs(1);

/// What everybody at the wheel shares and anybody may set.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Settings {
    rpm: f32,
    wetness: f32,
}

impl Settings {
    fn of(panel: &PanelState) -> Self {
        Self { rpm: panel.rpm, wetness: panel.wetness }
    }
}

/// What a window begins with, besides the wheel.
pub(super) struct Begin {
    pub(super) held: Held,
    pub(super) invitation: Option<Invitation>,
    pub(super) files: Files,
    pub(super) keeper: Keeper,
    pub(super) graphics: Option<GpuAhead>,
    pub(super) proxy: EventLoopProxy<Call>,
}

/// The window's state.
pub(super) struct App {
    potter: Potter,
    asked: triple_buffer::Input<Pointer>,
    held: Held,
    invitation: Option<Invitation>,
    keeper: Keeper,
    /// Until the window is there.
    graphics: Option<GpuAhead>,
    proxy: EventLoopProxy<Call>,
    stage: Option<Stage>,
    overlay: Option<Overlay>,
    camera: Camera,
    hand: Hand,
    /// Why the tool that was brought does not hang in the rack, why one works on, or whom leaving would send home, and since when that is said.
    refusal: Option<(Instant, String)>,
    /// Whether it is to be taken in hand when it does.
    takes_brought: bool,
    /// Whether the sphere's size is the command line's for this time.
    is_sized: bool,
    panel: PanelState,
    files: Files,
    modifiers: ModifiersState,
    cursor: Vec2,
    /// Where the pointer, a finger or keys point in the picture.
    pointed: Option<Pointed>,
    turning_view: bool,
    rpm_before_stop: f32,
    last_frame: Instant,
    next_frame: Instant,
    /// The water on the clay, and when the clay itself was last made drier.
    water: Water,
    dried_at: Instant,
    /// How far the wall has given way under the tools.
    deflection: Deflection,
    /// Whether the pot is shown cut open.
    is_cut: bool,
    drawn_phase: Phase,
    /// The panel and the water as they were drawn, and when the figures were read.
    drawn_panel: u64,
    drawn_water: u64,
    figures_at: Instant,
    /// A look was asked for that need not come to a picture.
    only_looks: bool,
    timing: Timing,
    shown: Shown,
    fingers: Fingers,
    /// Whether a button of a device that is being fitted was down.
    device_was_pressed: bool,
    is_dirty: bool,
    /// What the wheel and the clay are set to, as far as this window has asked for it or heard of it.
    settings: Settings,
    asked_at: Instant,
    failure: Option<anyhow::Error>,
}

/// How wet clay of a liquidity index looks, 0 to 1: clay for throwing shines under its slip, stiff clay is dull.
fn film(wetness: f32) -> f32 {
    let (driest, wettest) = WETNESS;
    let throwing = Preset::Throwing.wetness().liquidity_index();
    if wetness < throwing {
        0.8 * (wetness - driest) / (throwing - driest)
    } else {
        0.8 + 0.2 * (wetness - throwing) / (wettest - throwing)
    }
}

/// Somebody's colour.
pub(super) fn colour(client: u16) -> [f32; 3] {
    COLOURS[usize::from(client.wrapping_sub(1)) % COLOURS.len()]
}

impl App {
    pub(super) fn new(potter: Potter, asked: triple_buffer::Input<Pointer>, begin: Begin, tool: &ToolChoice) -> Self {
        let Begin { held, invitation, files, keeper, graphics, proxy } = begin;
        if let Some(brought) = &tool.brought {
            // a worker that does not hear has ended, which the window will say
            potter.command(Command::Bring(Arc::clone(brought)));
        }
        let view = potter.view().lock();
        let (hand, camera) = (Hand::new(&view.pot), Camera::on(&view.pot));
        let liking = keeper.liking().clone();
        let panel = PanelState {
            words: keeper.words(),
            lesson: (!liking.knows_lesson).then(Lesson::default),
            rpm: view.conditions.wheel.speed(potter.tick()).0,
            holding: match tool.is_sized {
                true => tool.holding.clone(),
                false => Holding { sphere_mm: liking.sphere_mm, ..tool.holding.clone() },
            },
            side: hand.side(),
            changes_side: false,
            rack: view.rack.len(),
            wetness: view.conditions.material.at(potter.tick()).wetness().liquidity_index(),
            dries: invitation.is_some().then_some(false),
            pushed_mm: 0.0,
            force_n: 0.0,
            is_touching: false,
            is_force_off: potter.status().is_force_off(),
            is_heard: liking.sound && !held.is_muted,
            no_sound: None,
            people: Vec::new(),
            class: People::default(),
            history: History::default(),
            guidance: Guidance::default(),
            is_in: true,
            round_trip_ms: Some(0.0),
            late_percent: 0.0,
            frames_per_s: 0.0,
            adapter: String::new(),
            peak_n: held.peak_n,
            feel: held.feel,
            device: held.said(&keeper.words()),
            pace: held.pace(&keeper.words(), potter.granted()),
            notice: None,
            shows_help: false,
            looks_on: None,
            fitting: None,
            fitting_answer: None,
            can_be_fitted: held.monitor.is_some(),
            is_open: None,
            covers: 0.0,
            liking,
        };
        drop(view);
        let settings = Settings::of(&panel);
        Self {
            rpm_before_stop: panel.rpm.max(30.0),
            potter,
            asked,
            held,
            invitation,
            keeper,
            graphics,
            proxy,
            stage: None,
            overlay: None,
            camera,
            hand,
            refusal: None,
            takes_brought: tool.takes_brought,
            is_sized: tool.is_sized,
            panel,
            files,
            modifiers: ModifiersState::empty(),
            cursor: Vec2::ZERO,
            pointed: None,
            turning_view: false,
            last_frame: Instant::now(),
            next_frame: Instant::now(),
            water: Water::default(),
            dried_at: Instant::now(),
            deflection: Deflection::default(),
            is_cut: false,
            drawn_phase: Phase::default(),
            drawn_panel: 0,
            drawn_water: 0,
            figures_at: Instant::now(),
            only_looks: false,
            timing: Timing::default(),
            shown: Shown::default(),
            fingers: Fingers::default(),
            device_was_pressed: false,
            is_dirty: true,
            settings,
            asked_at: Instant::now(),
            failure: None,
        }
    }

    /// The potter, to leave with, and what went wrong.
    pub(super) fn finish(self) -> (Potter, Option<anyhow::Error>) {
        (self.potter, self.failure)
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: anyhow::Error) {
        self.failure = Some(error);
        event_loop.exit();
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> anyhow::Result<()> {
        let graphics = self.graphics.take();
        let (stage, overlay) = overlay::open(event_loop, self.proxy.clone(), "Pottery studio", |window| {
            let view = self.potter.view().lock();
            Stage::new(window, event_loop.owned_display_handle(), graphics, &view.pot)
        })?;
        self.panel.adapter = stage.gpu().name().to_owned();
        self.overlay = Some(overlay);
        self.stage = Some(stage);
        Ok(())
    }

    /// Sends what was changed in the panel or by keys, not more often than a server listens.
    fn ask(&mut self) {
        let class = self.panel.class.take_wishes();
        let put = self.files.take_opened().map(Command::Put);
        for command in self.panel.history.take_wishes().into_iter().chain(class).chain(put) {
            self.command(command);
        }
        self.ask_for_guidance();
        self.dry();
        let wanted = Settings::of(&self.panel);
        if wanted == self.settings || self.asked_at.elapsed() < ASK_EVERY {
            return;
        }
        self.asked_at = Instant::now();
        if wanted.rpm != self.settings.rpm {
            self.command(Command::WheelSpeed(Rpm(wanted.rpm)));
        }
        if wanted.wetness != self.settings.wetness {
            self.command(Command::Clay(Material::from_wetness(Wetness::nearest(wanted.wetness))));
        }
        self.settings = wanted;
    }

    /// Makes the clay a little drier, where this window is the one that says so.
    fn dry(&mut self) {
        if self.panel.dries != Some(true) {
            self.dried_at = Instant::now();
        } else if self.dried_at.elapsed() >= DRY_EVERY {
            self.dried_at = Instant::now();
            let step = DRYING_PER_MINUTE * DRY_EVERY.as_secs_f32() / 60.0;
            self.panel.wetness = (self.panel.wetness - step).max(WETNESS.0);
        }
    }

    /// Does what the panel asks for of guidance; who lets go of a teacher's hand waits for nobody.
    fn ask_for_guidance(&mut self) {
        if self.panel.guidance.take_release() {
            self.potter.status().end_guidance();
        }
        match self.panel.guidance.take_wanted() {
            Some(Wanted::Pot) => self.panel.guidance.aim_at(Target::of(&self.potter.view().lock().pot)),
            Some(Wanted::File) => match PotFile::read(&self.files.path()) {
                Ok(file) => self.panel.guidance.aim_at(Target::of(&file.pot().pot())),
                Err(error) => self.panel.guidance.say(sentence(&error)),
            },
            None => {}
        }
        for command in self.panel.guidance.take_wishes() {
            self.command(Command::Guide(command));
        }
    }

    fn command(&mut self, command: Command) {
        if !self.potter.command(command) {
            self.refusal = Some((Instant::now(), self.panel.words.say("not-heard")));
        }
    }

    /// Tells the hand where the tool should be.
    fn guide(&mut self, seconds: f32) {
        let Some(stage) = &self.stage else { return };
        self.hand.pass(seconds);
        let view = self.potter.view().lock();
        if self.hand.is_free() {
            self.hand.look_at(&view.pot);
        }
        let holding = &self.panel.holding;
        let (tool, orientation) = (holding.tool(&view.rack), holding.orientation());
        let target_m = self.hand.target_m(&self.camera, stage.aspect(), &holding.reach(&view.rack));
        drop(view);
        self.asked.write(Pointer { target_m, tool, orientation });
    }

    /// The tools to draw: everybody else's as heard of, the own one as it is.
    fn tools(&mut self) -> Vec<ToolView> {
        let view = self.potter.view().lock();
        let status = self.potter.status();
        let own = view.number;
        let is_touching = status.elements() > 0;
        self.panel.people.clear();
        self.panel.people.push(Person { number: None, name: None, colour: colour(own), touching: is_touching });
        let mut tools = Vec::new();
        for tool in view.tools.iter().filter(|tool| tool.client != own) {
            let colour = colour(tool.client);
            let (number, name) = (Some(tool.client), self.panel.class.name_of(tool.client));
            self.panel.people.push(Person { number, name, colour, touching: tool.touching });
            tools.push(tool_view(tool));
        }
        // the teacher's hand, at whichever wheel it is; and one's own demonstration
        let ghost_m = status.teacher_m().or(view.guidance.hand.map(|hand| hand.tool.centre.point_m()));
        if let (Some(hand), Some(centre_m)) = (view.guidance.hand, ghost_m) {
            let (turn, colour) =
                (hand.tool.orientation.at(centre_m), colour(hand.tool.client).map(|part| 0.5 + 0.5 * part));
            tools.push(ToolView { turn, centre_m, colour, touching: false, ..tool_view(&hand.tool) });
        }
        self.shown.note(status.tool_m(), &view);
        if let Some(centre_m) = self.shown.own_m {
            let holding = &self.panel.holding;
            // a teacher who has taken over presses with another tool than the own one
            let taken = view.guidance.pair.is_some_and(|pair| pair.student == own).then(|| status.grip()).flatten();
            let taken =
                taken.filter(|(tool, _)| tool.shape().is_none_or(|shape| usize::from(shape.0) < view.rack.len()));
            let (tool, orientation) = taken.unwrap_or_else(|| (holding.tool(&view.rack), holding.orientation()));
            let turn = orientation.at(centre_m);
            let clay_m =
                (!is_touching).then(|| to_clay_m(&view.pot, view.conditions.phase(self.potter.tick()), centre_m));
            let (colour, side) = (colour(own), status.side());
            tools.push(ToolView { tool, turn, centre_m, colour, touching: is_touching, side, clay_m });
        }
        let touching = tools.iter().filter(|tool| tool.touching);
        let hands =
            touching.map(|tool| (tool.centre_m, tool.tool.sphere().map_or(WET_HAND_M, |sphere| sphere.radius().0)));
        let height_m = view.pot.surfaces()[0].height_m();
        self.water.pass(self.potter.tick(), &view.conditions, height_m, hands);
        let touching = tools.iter().filter(|tool| tool.touching);
        self.deflection.follow(&view.pot, (&view.conditions, self.potter.tick()), &view.rack, touching);
        tools
    }

    fn read_figures(&mut self, seconds: f32, has_cause: bool) {
        let status = self.potter.status();
        self.panel.force_n = status.force_n();
        self.panel.is_touching = status.elements() > 0;
        self.panel.no_sound = self.held.sound.trouble().map(|trouble| trouble.to_string());
        self.panel.pushed_mm = self.hand.pushed_m() * 1e3;
        if std::mem::take(&mut self.panel.changes_side) {
            self.hand.change_side();
        }
        self.panel.side = self.hand.side();
        if let Some(lesson) = &mut self.panel.lesson {
            let height_m = self.shown.own_m.map_or(0.0, |tool_m| tool_m.z);
            let (rpm, is_touching, side) = (self.panel.rpm, self.panel.is_touching, self.panel.side);
            self.is_dirty |= lesson.pass(seconds, &Seen { rpm, is_touching, side, height_m });
        }
        let late_percent = 100.0 * status.late_ticks() as f32 / status.ticks().max(1) as f32;
        let mut view = self.potter.view().lock();
        self.panel.rack = view.rack.len();
        self.panel.history.hear(&mut view);
        self.panel.guidance.hear(&mut view, status, &self.panel.words);
        self.panel.class.hear(&mut view, self.potter.tick());
        if let (Some(invitation), Some(code)) = (&mut self.invitation, self.panel.class.code()) {
            invitation.follow(code);
        }
        match view.brought.take() {
            Some(Ok(shape)) if self.takes_brought => self.panel.holding.shape = Some(shape),
            Some(Ok(_)) | None => {}
            Some(Err(reason)) => self.refusal = Some((Instant::now(), reason)),
        }
        self.refusal.take_if(|(at, _)| at.elapsed() > REFUSED_FOR);
        self.panel.is_in = view.link == Link::Open;
        let is_heard = self.panel.is_in && view.silence < SILENCE_MAX;
        let round_trip_ms = is_heard.then(|| view.round_trip.as_secs_f32() * 1e3);
        if (has_cause || self.figures_at.elapsed() >= FIGURES_IDLE) && self.held.count(status.ticks()) {
            self.panel.device = self.held.said(&self.panel.words);
            self.panel.pace = self.held.pace(&self.panel.words, self.potter.granted());
        }
        if has_cause {
            self.figures_at = Instant::now();
            self.panel.frames_per_s += (1.0 / seconds.max(1e-3) - self.panel.frames_per_s) * 0.1;
            (self.panel.late_percent, self.panel.round_trip_ms) = (late_percent, round_trip_ms);
        } else if self.figures_at.elapsed() >= FIGURES_IDLE {
            // a picture that only told of its own rate, or of a figure that is much the same, would have no cause
            self.figures_at = Instant::now();
            self.panel.frames_per_s = 0.0;
            panel::renew(&mut self.panel.late_percent, late_percent, 0.2);
            if let (Some(shown), Some(round_trip_ms)) = (&mut self.panel.round_trip_ms, round_trip_ms) {
                panel::renew(shown, round_trip_ms, 5.0);
            }
        }
        if self.panel.round_trip_ms.is_some() != round_trip_ms.is_some() {
            self.panel.round_trip_ms = round_trip_ms;
        }
        let monitor = self.held.monitor.as_ref();
        self.panel.feel = self.held.feel();
        self.panel.notice = match (&view.link, status.fault()) {
            (Link::Closed, _) => Some(self.panel.words.say("closed")),
            (Link::ComingBack(_), _) => Some(self.panel.words.say("coming-back")),
            (Link::Waiting, _) => Some(self.panel.words.say("waiting")),
            (Link::Lost(reason), _) => Some(reason.clone()),
            (Link::Open, _) if !is_heard => Some(self.panel.words.say("silence")),
            (Link::Open, fault) => monitor
                .and_then(|monitor| monitor.notice())
                .or_else(|| fault.map(|fault| fault.to_string()))
                .or_else(|| self.panel.is_force_off.then(|| self.panel.words.say("force-is-off")))
                .or_else(|| self.panel.class.held().map(|held| self.panel.words.say(held)))
                .or_else(|| self.panel.guided())
                .or_else(|| self.refusal.as_ref().map(|(_, reason)| reason.clone()))
                .or_else(|| self.keeper.trouble(&self.panel.words)),
        };
        // what somebody else set shows here, unless the own wish is still on its way
        let soon = self.potter.tick().offset(1000);
        let rpm = view.conditions.wheel.speed(soon).0;
        let wetness = view.conditions.material.at(soon).wetness().liquidity_index();
        drop(view);
        let is_waiting = Settings::of(&self.panel) != self.settings || self.asked_at.elapsed() < HEARD_WITHIN;
        if !is_waiting {
            self.panel.rpm = rpm;
            self.panel.wetness = wetness;
            self.settings = Settings::of(&self.panel);
        }
    }

    /// Another device in the place of one that was lost: it begins with the clay as it is drawn.
    fn renew_stage(&mut self) -> anyhow::Result<()> {
        if let (Some(stage), Some(overlay)) = (&mut self.stage, &self.overlay)
            && stage.is_lost()
        {
            stage.renew(self.potter.view().lock().picture.drawn(), overlay.letters())?;
            stage.gpu().name().clone_into(&mut self.panel.adapter);
            self.is_dirty = true;
        }
        Ok(())
    }

    fn draw(&mut self) -> anyhow::Result<()> {
        self.renew_stage()?;
        // a panel that moves by itself is no cause to draw the pot less sharply
        let pace = if self.scene_is_moving() { Pace::Moving } else { Pace::Still };
        let has_cause = !std::mem::take(&mut self.only_looks) || self.is_moving();
        let now = Instant::now();
        let seconds = (now - self.last_frame).as_secs_f32().min(0.2);
        self.last_frame = now;
        self.guide(seconds);
        self.fit();
        self.read_figures(seconds, has_cause);
        let tools = self.tools();
        let rack = Arc::clone(&self.potter.view().lock().rack);
        let (Some(stage), Some(overlay)) = (&mut self.stage, &mut self.overlay) else { return Ok(()) };
        {
            let mut view = self.potter.view().lock();
            let view = &mut *view;
            if !view.changed.is_empty() {
                stage.upload(view.picture.drawn(), &view.changed);
                view.changed.clear();
            }
            self.drawn_phase = view.conditions.phase(self.potter.tick());
        }
        let shapes = overlay.lay_out(&stage.window, |ui| {
            let others = self.panel.people.get(1..).unwrap_or_default();
            labels::show(ui.ctx(), &self.panel.words, &self.camera, others, &tools);
            {
                let view = self.potter.view().lock();
                ghost::show(ui.ctx(), &self.camera, &view.guidance, (&view.pot, self.drawn_phase), self.is_cut);
            }
            panel::show(ui.ctx(), &mut self.panel, self.invitation.as_ref(), &mut self.files);
        });
        overlay.enlarge(&stage.window, f32::from(self.panel.liking.text_percent) / 100.0);
        self.files.pass(|| {
            let view = self.potter.view().lock();
            PotFile::of(&view.pot, &view.conditions, self.potter.tick())
        });
        // in the middle of what the panel leaves free, unless that is too little for a pot
        self.camera.aside_ndc = if self.panel.covers < COVERS_MAX { self.panel.covers } else { 0.0 };
        let scene = Scene {
            camera: self.camera,
            phase: self.drawn_phase,
            tools: &tools,
            rack: &rack,
            wetness: film(self.panel.wetness),
            water: Some(&self.water),
            deflection: Some(&self.deflection),
            finish: self.panel.liking.finish,
            is_cut: self.is_cut,
        };
        let (panel, water) = (shapes.digest(), self.water.stamp());
        if has_cause || panel != self.drawn_panel || water != self.drawn_water || stage.is_coarse() {
            self.is_dirty = !stage.draw(&Picture::Pot(&scene), shapes, pace)?;
            (self.drawn_panel, self.drawn_water) = (panel, water);
            self.timing.drawn(self.shown.own_m);
        } else {
            self.is_dirty = false;
            stage.leave(shapes);
        }
        // only now is it known what lies under a pointer that has moved
        self.is_dirty |= self.point();
        self.potter.status().switch_force_off(self.panel.is_force_off);
        self.held.sound.mute(!self.panel.is_heard);
        self.keep();
        self.ask();
        Ok(())
    }

    /// Keeps what the person likes, once nothing is held down any more.
    fn keep(&mut self) {
        if !self.held.is_muted {
            self.panel.liking.sound = self.panel.is_heard;
        }
        if !self.is_sized {
            self.panel.liking.sphere_mm = self.panel.holding.sphere_mm;
        }
        if self.overlay.as_ref().is_some_and(|overlay| !overlay.is_held()) {
            self.keeper.keep(&self.panel.liking);
        }
    }

    /// Whether a picture now would look different from the last one.
    fn is_moving(&self) -> bool {
        self.scene_is_moving() || self.is_fitting() || self.overlay.as_ref().is_some_and(Overlay::is_moving)
    }

    /// Whether it would by what a person did, or by what is on the wheel.
    fn scene_is_moving(&self) -> bool {
        let view = self.potter.view().lock();
        self.is_dirty
            || self.hand.is_on_its_way()
            || !view.changed.is_empty()
            || view.conditions.phase(self.potter.tick()) != self.drawn_phase
            || view.guidance.pair.is_some()
            || self.shown.is_elsewhere(self.potter.status().tool_m(), &view)
    }
}

impl ApplicationHandler<Call> for App {
    fn user_event(&mut self, _: &ActiveEventLoop, call: Call) {
        if let Some(overlay) = &mut self.overlay {
            overlay.take_call(call);
            self.is_dirty = true;
        }
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.stage.is_none()
            && let Err(error) = self.open(event_loop)
        {
            self.fail(event_loop, error);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let is_panels = overlay::take_event(self.stage.as_mut(), self.overlay.as_mut(), &event);
        if !matches!(event, WindowEvent::RedrawRequested) {
            self.is_dirty = true;
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.fail(event_loop, error);
                }
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            // a key that was down already when the window came to the front was pressed for another one
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if event.state == ElementState::Pressed => {
                self.press_key(event_loop, &event, is_panels);
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.moved(Vec2::new(position.x as f32, position.y as f32));
            }
            WindowEvent::CursorLeft { .. } => {
                self.pointed = None;
                self.point();
            }
            WindowEvent::Touch(touch) => self.touched(&touch, is_panels),
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                self.hand.press_button(state == ElementState::Pressed && !is_panels);
            }
            WindowEvent::MouseInput { state, button: MouseButton::Right, .. } => {
                self.turning_view = state == ElementState::Pressed && !is_panels;
            }
            WindowEvent::MouseWheel { delta, .. } if !is_panels => self.scrolled(match delta {
                // some systems turn the wheel's direction while Shift is down
                MouseScrollDelta::LineDelta(aside, lines) => {
                    if lines == 0.0 {
                        aside
                    } else {
                        lines
                    }
                }
                MouseScrollDelta::PixelDelta(pixels) => {
                    (if pixels.y == 0.0 { pixels.x } else { pixels.y }) as f32 / 40.0
                }
            }),
            WindowEvent::Focused(false) => {
                self.hand.press_button(false);
                self.turning_view = false;
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(stage) = &self.stage else { return };
        let frame = super::frame(stage.gpu());
        let since = self.last_frame.elapsed();
        let is_moving = self.is_moving();
        let due = if is_moving { frame } else { LOOK_IDLE };
        if since >= due {
            self.only_looks = !is_moving;
            stage.window.request_redraw();
        }
        self.next_frame = Instant::now() + if since >= due { frame } else { frame.min(due - since) };
        event_loop.set_control_flow(ControlFlow::WaitUntil(self.next_frame));
    }
}
