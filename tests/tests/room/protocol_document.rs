//! The description of the protocol: its vectors are what the core says today, and the program in it reads them.
//!
//! Invariant under test: nobody changes the wire without raising the version and writing the vectors anew.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use pottery_server::{CONTROL_BYTES, CONTROL_QUEUE, Input, KEYFRAME_BYTES};
use pottery_shared::protocol::{
    ALPN, Audience, Body, CONTROL_MAX, ClassWire, ClayWire, DATAGRAM_LONGEST, DATAGRAM_MAX, DATAGRAM_MEMORY_MAX,
    DetailWire, Fragment, FragmentOf, Greeting, GuidanceEnd, GuidanceWire, HandWire, Hello, Inputs, KEYFRAME_MAX,
    Keyframe, LeadWire, MeshWire, NewsOf, NewsWire, Nickname, NoGuidance, NoOrder, NoStep, NoTool, Notice, Order, Pass,
    PersonWire, PlaceWire, PotOf, PotWire, Presence, ProgressWire, Pulse, PulseHead, Purpose, Refusal, Request,
    ResumeToken, Retelling, Role, Run, ShapeWire, Sight, SightName, StepsWire, TargetWire, TeacherToken, ToolWire,
    Upload, VERSION, Welcome, WheelInfo, WheelWire, encode,
};
use pottery_shared::session::InputQueue;
use pottery_shared::snapshot::{Pressed, Transcript};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Tool, ToolSample};
use pottery_shared::units::Tick;
use pottery_tests::programs::folder;
use serde_json::{Value, json};

mod chains;

fn shared(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name)
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

const CLAY: ClayWire = ClayWire { viscosity_s: 0.125, youngs_pa: 2e6, yield_pa: 40_000.0 };
const SIGHT: SightName = SightName { wheel: 3, detail: DetailWire::Gallery };
const OWN: DetailWire = DetailWire::Own { quantum: 256, fold: 2, every: 6, first: 4, end: 255, tools: true };
const POT: PotWire =
    PotWire { columns: 360, rows: 400, height_m: 0.25, radius_m: 0.0625, wall_m: 0.0078125, support: 1 };
const TURNING: WheelWire = WheelWire { from: 70_000, phase: 0xdead_beef, rate: -71_583 };

fn clay() -> Value {
    json!([0.125, 2e6, 40_000.0])
}

fn sight() -> Value {
    json!({ "wheel": 3, "detail": "gallery" })
}

fn own() -> Value {
    let detail = json!({ "own": { "quantum": 256, "fold": 2, "every": 6, "first": 4, "end": 255, "tools": true } });
    json!({ "wheel": 300, "detail": detail })
}

fn pot() -> Value {
    json!({ "columns": 360, "rows": 400, "measures": [0.25, 0.0625, 0.0078125], "support": 1 })
}

fn turning() -> Value {
    json!({ "from": 70_000, "phase": 0xdead_beef_u32, "rate": -71_583 })
}

fn mesh() -> (MeshWire, Value) {
    let corners = [[0.0, 0.0, 0.0078125], [0.015625, 0.0, 0.0], [0.0, 0.015625, 0.0], [-0.5, -0.25, -0.125]];
    let facets = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [300, 2, 1]];
    let mesh = MeshWire { corners_m: corners.to_vec(), facets: facets.to_vec() };
    (mesh, json!({ "corners": corners, "facets": facets }))
}

/// A message with what a reader should find in it.
fn vector(kind: &str, bytes: &[u8], value: Value) -> Value {
    json!({ "kind": kind, "hex": hex(bytes), "value": value })
}

fn greetings() -> Vec<Value> {
    let greeting = |hello: &Hello, value: Value| {
        let greeting = Greeting { magic: Greeting::MAGIC, version: VERSION.to_le_bytes(), hello: encode(hello) };
        let value = json!({ "magic": "POTS", "version": VERSION, "hello": value });
        vector("greeting", &encode(&greeting), value)
    };
    vec![
        greeting(
            &Hello { code: "K7QM3XPD".into(), wheel: 2, purpose: Purpose::Works { retells: false }, pass: Pass::None },
            json!({ "code": "K7QM3XPD", "wheel": 2, "purpose": { "works": false }, "pass": "none" }),
        ),
        greeting(
            &Hello {
                code: String::new(),
                wheel: 1,
                purpose: Purpose::Works { retells: true },
                pass: Pass::Teacher(TeacherToken([0x5a; 32])),
            },
            json!({ "code": "", "wheel": 1, "purpose": { "works": true }, "pass": { "teacher": "5a".repeat(32) } }),
        ),
        greeting(
            &Hello {
                code: "K7QM3XPD".into(),
                wheel: 1,
                purpose: Purpose::Works { retells: true },
                pass: Pass::Resume(ResumeToken([0xc3; 16])),
            },
            json!({
                "code": "K7QM3XPD", "wheel": 1, "purpose": { "works": true }, "pass": { "resume": "c3".repeat(16) }
            }),
        ),
        greeting(
            &Hello {
                code: "K7QM3XPD".into(),
                wheel: 1,
                purpose: Purpose::Works { retells: true },
                pass: Pass::Return(ResumeToken([0xc3; 16]), TeacherToken([0x5a; 32])),
            },
            json!({
                "code": "K7QM3XPD", "wheel": 1, "purpose": { "works": true },
                "pass": { "return": ["c3".repeat(16), "5a".repeat(32)] }
            }),
        ),
        greeting(
            &Hello {
                code: "00000000".into(),
                wheel: 0,
                purpose: Purpose::Watches { bytes_per_s: 100_000 },
                pass: Pass::None,
            },
            json!({ "code": "00000000", "wheel": 0, "purpose": { "watches": 100_000 }, "pass": "none" }),
        ),
    ]
}

fn requests() -> Vec<Value> {
    let (mesh, mesh_value) = mesh();
    let all = [
        (Request::WheelSpeed { rpm: -62.5 }, json!({ "speed": -62.5 })),
        (Request::Clay { clay: CLAY }, json!({ "clay": clay() })),
        (Request::Tool { mesh }, json!({ "tool": mesh_value })),
        (Request::Again { have: 250 }, json!({ "again": 250 })),
        (Request::Resync { have: 251 }, json!({ "resync": 251 })),
        (Request::Watch { sight: SIGHT, have: 65_536 }, json!({ "watch": { "sight": sight(), "have": 65_536 } })),
        (
            Request::Watch { sight: SightName { wheel: 300, detail: OWN }, have: 0 },
            json!({ "watch": { "sight": own(), "have": 0 } }),
        ),
        (Request::Unwatch { sight: SIGHT }, json!({ "unwatch": sight() })),
        (Request::Retell { retells: true }, json!({ "retell": true })),
        (Request::Leave, json!("leave")),
        (Request::Mend { have: 250, tiles: vec![0, 171, 255] }, json!({ "mend": { "have": 250, "tiles": "00abff" } })),
        (
            Request::MendSight { sight: SIGHT, have: 250, tiles: vec![0, 171, 255] },
            json!({ "mend_sight": { "sight": sight(), "have": 250, "tiles": "00abff" } }),
        ),
        (Request::Undo { held: 1 << 20 }, json!({ "undo": 1 << 20 })),
        (Request::Redo { held: 250 }, json!({ "redo": 250 })),
        (Request::NewPot { held: 251, form: 3 }, json!({ "new_pot": { "held": 251, "form": 3 } })),
        (Request::Guide { student: 300, guidance: GUIDANCE }, json!({ "guide": [300, 2, 50] })),
        (Request::EndGuidance, json!("end_guidance")),
        (Request::Target(Some(target())), json!({ "target": target_value() })),
        (Request::Target(None), json!({ "target": null })),
        (
            Request::Pot { held: 70_000, piece: 14, bytes: vec![0, 171, 255] },
            json!({ "pot": { "held": 70_000, "piece": 14, "bytes": "00abff" } }),
        ),
    ];
    let orders = orders().into_iter().map(|(order, value)| (Request::Order(order), json!({ "order": value })));
    all.into_iter().chain(orders).map(|(request, value)| vector("request", &encode(&request), value)).collect()
}

fn orders() -> [(Order, Value); 14] {
    [
        (Order::Freeze { wheel: 0, is_frozen: true }, json!({ "freeze": [0, true] })),
        (Order::Open { wheel: 2, is_open: false }, json!({ "open": [2, false] })),
        (Order::WheelSpeed { wheel: 2, rpm: 80.0 }, json!({ "speed": [2, 80.0] })),
        (Order::Clay { wheel: 2, clay: CLAY }, json!({ "clay": [2, clay()] })),
        (Order::Seat { client: 300, wheel: 2, works: true }, json!({ "seat": [300, 2, true] })),
        (Order::Pot { wheel: 0, of: PotOf::Form(2) }, json!({ "pot": [0, { "form": 2 }] })),
        (Order::Pot { wheel: 0, of: PotOf::Wheel(3) }, json!({ "pot": [0, { "wheel": 3 }] })),
        (Order::GoBack { wheel: 2, to: 70_000 }, json!({ "go_back": [2, 70_000] })),
        (Order::TakeBack { wheel: 2 }, json!({ "take_back": 2 })),
        (Order::Lock { is_locked: true }, json!({ "lock": true })),
        (Order::NewCode, json!("new_code")),
        (Order::Lobby { is_on: true }, json!({ "lobby": true })),
        (Order::Admit { client: 7, is_admitted: false }, json!({ "admit": [7, false] })),
        (Order::End, json!("end")),
    ]
}

fn lesson() -> Vec<(Notice, Value)> {
    let name = Nickname(65);
    let place = |resume| PlaceWire { client: 7, role: Role::Student, name, wheel: 2, may_press: false, resume };
    let person = PersonWire {
        client: 300,
        role: Role::Teacher,
        name,
        wheel: 2,
        works: true,
        presence: Presence::Away,
        touching: false,
    };
    let said = json!({ "client": 7, "role": "student", "name": 65, "wheel": 2, "may_press": false, "resume": null });
    let mut first = said.clone();
    first["resume"] = json!("c3".repeat(16));
    let class = ClassWire {
        code: "K7QM3XPD".into(),
        expires: Some(90_000_000),
        is_locked: false,
        has_lobby: true,
        wheels: vec![WheelInfo { is_open: true, is_frozen: true, oldest: 70_000 }],
    };
    vec![
        (Notice::Refused(Refusal::CodeGone), json!({ "refused": "code_gone" })),
        (Notice::Refused(Refusal::Locked), json!({ "refused": "locked" })),
        (Notice::Refused(Refusal::Token), json!({ "refused": "token" })),
        (Notice::Refused(Refusal::WheelClosed { wheel: 2 }), json!({ "refused": { "wheel_closed": 2 } })),
        (Notice::Refused(Refusal::NotAdmitted), json!({ "refused": "not_admitted" })),
        (Notice::Waiting, json!("waiting")),
        (Notice::Place(place(Some(ResumeToken([0xc3; 16])))), json!({ "place": first })),
        (Notice::Place(place(None)), json!({ "place": said })),
        (
            Notice::People { people: vec![person], gone: vec![9, 251] },
            json!({ "people": { "people": [{
                "client": 300, "role": "teacher", "name": 65, "wheel": 2, "works": true, "presence": "away",
                "touching": false,
            }], "gone": [9, 251] } }),
        ),
        (
            Notice::Class(class),
            json!({ "class": {
                "code": "K7QM3XPD", "expires": 90_000_000, "locked": false, "lobby": true,
                "wheels": [[true, true, 70_000]],
            } }),
        ),
        (Notice::Come { wheel: 3 }, json!({ "come": 3 })),
        (Notice::NoOrder(NoOrder::NotTeacher), json!({ "no_order": "not_teacher" })),
        (Notice::NoOrder(NoOrder::Wheel { wheel: 9 }), json!({ "no_order": { "wheel": 9 } })),
        (Notice::NoOrder(NoOrder::Person { client: 9 }), json!({ "no_order": { "person": 9 } })),
        (Notice::NoOrder(NoOrder::CannotWork), json!({ "no_order": "cannot_work" })),
        (Notice::NoOrder(NoOrder::TooLongAgo { oldest: 7 }), json!({ "no_order": { "too_long_ago": 7 } })),
        (Notice::NoOrder(NoOrder::NothingBack), json!({ "no_order": "nothing_back" })),
    ]
}

const GUIDANCE: GuidanceWire = GuidanceWire { mode: 2, strength: 50 };

fn target() -> TargetWire {
    TargetWire { height_m: 0.25, radii: (0..65).map(|row| 15_000 + 10 * row).collect() }
}

fn target_value() -> Value {
    json!({ "height": 0.25, "radii": target().radii })
}

fn hand() -> (HandWire, Value) {
    let tool = ShapeWire::Sphere { radius_um: 12_000 };
    let hand = HandWire { tick: 16_600, centre: [6500, -1, 9000], tool, force_mn: 1500, draws: true, inside: true };
    let tool = json!({ "sphere": 12_000 });
    (
        hand,
        json!({ "tick": 16_600, "centre": [6500, -1, 9000], "tool": tool, "force": 1500, "draws": true, "inside": true }),
    )
}

fn guidance() -> Vec<(Notice, Value)> {
    let ends = [GuidanceEnd::Teacher, GuidanceEnd::Student, GuidanceEnd::Gone, GuidanceEnd::Replaced];
    let ends = ends.into_iter().zip(["teacher", "student", "gone", "replaced"]);
    let refused = [
        (NoGuidance::NotTeacher, "not_teacher"),
        (NoGuidance::Nobody, "nobody"),
        (NoGuidance::Oneself, "oneself"),
        (NoGuidance::NoHand, "no_hand"),
        (NoGuidance::Unknown, "unknown"),
    ];
    let lead = LeadWire { teacher: 1, student: 300, guidance: GUIDANCE };
    let mut all = vec![(Notice::Guidance(lead), json!({ "guidance": [1, 300, 2, 50] }))];
    all.extend(ends.map(|(why, value)| (Notice::GuidanceEnded(why), json!({ "guidance_ended": value }))));
    all.extend(refused.map(|(why, value)| (Notice::NoGuidance(why), json!({ "no_guidance": value }))));
    all.push((Notice::Target(Some(target())), json!({ "target": target_value() })));
    all.push((Notice::Target(None), json!({ "target": null })));
    let progress = ProgressWire { wheel: 300, is: target(), rms_m: 0.0078125, most_m: 0.015625, most_at_m: 0.125 };
    let off = json!([0.0078125, 0.015625, 0.125]);
    let value = json!({ "progress": [{ "wheel": 300, "is": target_value(), "off": off }] });
    all.push((Notice::Progress(vec![progress]), value));
    all.push((Notice::Progress(vec![]), json!({ "progress": [] })));
    all.push((Notice::NoSight(SightName { wheel: 300, detail: OWN }), json!({ "no_sight": own() })));
    all
}

fn news(mesh: &MeshWire, mesh_value: &Value) -> [(Notice, Value); 4] {
    let standing = NewsOf::Standing { wheel: vec![TURNING], clay: vec![(0, CLAY)] };
    let news = |told, of| Notice::News(NewsWire { wheel: 3, told, of });
    let value = |told, of: Value| json!({ "news": { "wheel": 3, "told": told, "of": of } });
    [
        (news(250, standing), value(250, json!({ "standing": { "wheel": [turning()], "clay": [[0, clay()]] } }))),
        (news(251, NewsOf::Wheel { from: 70_000, rate: -5 }), value(251, json!({ "wheel": [70_000, -5] }))),
        (news(252, NewsOf::Clay { from: 1 << 33, clay: CLAY }), value(252, json!({ "clay": [1_u64 << 33, clay()] }))),
        (news(253, NewsOf::Tool { shape: 4, mesh: mesh.clone() }), value(253, json!({ "tool": [4, mesh_value] }))),
    ]
}

fn notices() -> Vec<Value> {
    let (mesh, mesh_value) = mesh();
    let news = news(&mesh, &mesh_value);
    let welcome = Welcome {
        client: 7,
        now: 1 << 33,
        pot: POT,
        wheel: vec![TURNING, TURNING],
        clay: vec![(0, CLAY), (90_000, CLAY)],
        method: 2,
        told: 5,
        ahead: 8,
    };
    let all = [
        (
            Notice::Welcome(welcome),
            json!({ "welcome": {
                "client": 7, "now": 1_u64 << 33, "pot": pot(), "wheel": [turning(), turning()],
                "clay": [[0, clay()], [90_000, clay()]], "method": 2, "told": 5, "ahead": 8,
            } }),
        ),
        (
            Notice::Audience(Audience { now: 12, wheels: 8, pot: POT, method: 0 }),
            json!({ "audience": { "now": 12, "wheels": 8, "pot": pot(), "method": 0 } }),
        ),
        (Notice::Refused(Refusal::Version { server: 7, client: 300 }), json!({ "refused": { "version": [7, 300] } })),
        (Notice::Refused(Refusal::Code), json!({ "refused": "code" })),
        (Notice::Refused(Refusal::Wheel { wheel: 9, wheels: 8 }), json!({ "refused": { "wheel": [9, 8] } })),
        (Notice::Refused(Refusal::Full { people: 64 }), json!({ "refused": { "full": 64 } })),
        (Notice::Refused(Refusal::Greeting), json!({ "refused": "greeting" })),
        (Notice::Wheel { from: 5000, rate: 71_583 }, json!({ "wheel": [5000, 71_583] })),
        (Notice::Clay { from: 5000, clay: CLAY }, json!({ "clay": [5000, clay()] })),
        (Notice::Tool { shape: 4, mesh }, json!({ "tool": [4, mesh_value] })),
        (Notice::NoTool(NoTool::Full { brought: 12 }), json!({ "no_tool": { "full": 12 } })),
        (Notice::NoTool(NoTool::Unsound), json!({ "no_tool": "unsound" })),
        (Notice::Closing, json!("closing")),
        (Notice::Steps(StepsWire { back: 300, forth: 2, is_remaking: true }), json!({ "steps": [300, 2, true] })),
        (Notice::NoStep(NoStep::NothingBack), json!({ "no_step": "back" })),
        (Notice::NoStep(NoStep::NothingForth), json!({ "no_step": "forth" })),
        (Notice::NoStep(NoStep::NoPot), json!({ "no_step": "no_pot" })),
    ];
    all.into_iter()
        .chain(lesson())
        .chain(guidance())
        .chain(news)
        .map(|(notice, value)| vector("notice", &encode(&notice), value))
        .collect()
}

fn uploads() -> Vec<Value> {
    // steps as of a hand, one that takes sixteen bits, and none
    let hand: Vec<[i16; 3]> = (0..20).map(|tick| [tick % 3 - 1, 4 - tick / 4, -7]).collect();
    let wild = vec![[i16::MIN, i16::MAX, 0], [i16::MAX, 0, -1], [0, 1, 2]];
    let run = |tool, inside, steps: &Vec<[i16; 3]>, turns: &Vec<[i16; 3]>| Run {
        first_tick: 51_234,
        tool,
        inside,
        start: [-6500, 0, 10_000],
        steps: steps.clone(),
        turns: turns.clone(),
    };
    let value = |tool: Value, inside: bool, steps: &Vec<[i16; 3]>, turns: &Vec<[i16; 3]>| json!({ "tick": 51_234, "tool": tool, "inside": inside, "start": [-6500, 0, 10_000], "steps": steps, "turns": turns });
    let (sphere, rib) =
        (ShapeWire::Sphere { radius_um: 12_000 }, ShapeWire::Convex { shape: 0, orientation: [16_384, -300, 0] });
    let (sphere_value, rib_value) =
        (json!({ "sphere": 12_000 }), json!({ "convex": { "shape": 0, "turned": [16_384, -300, 0] } }));
    let none = Vec::new();
    let runs = vec![run(sphere, false, &hand, &none), run(rib, true, &wild, &wild), run(sphere, true, &none, &none)];
    let values = [
        value(sphere_value.clone(), false, &hand, &none),
        value(rib_value, true, &wild, &wild),
        value(sphere_value, true, &none, &none),
    ];
    let (first, (hand, hand_value)) = (u16::MAX - 1, self::hand());
    let quiet = Upload { inputs: Inputs { first, runs, rests: false }, hand: None, again: Some(251) };
    let guiding = Upload { inputs: Inputs { first: 7, runs: Vec::new(), rests: true }, hand: Some(hand), again: None };
    let inputs = json!({ "first": first, "runs": values, "rests": false });
    vec![
        vector("upload", &encode(&quiet), json!({ "inputs": inputs, "hand": null, "again": 251 })),
        vector(
            "upload",
            &encode(&guiding),
            json!({ "inputs": { "first": 7, "runs": [], "rests": true }, "hand": hand_value, "again": null }),
        ),
    ]
}

fn datagrams() -> Vec<Value> {
    let (centre, shape) = ([6500, -1, 9000], ShapeWire::Sphere { radius_um: 500 });
    let tool = ToolWire { client: 2, centre, tool: shape, touching: true, inside: false };
    let fragment = Fragment { version: 1001, of: FragmentOf::Delta, index: 1, count: 2, bytes: vec![1, 2, 250, 255] };
    let first = Body {
        tick: 16_666,
        latest: 1001,
        digest: Some(u64::MAX),
        tools: Some(vec![tool]),
        fragments: vec![fragment.clone()],
    };
    let next = Body {
        digest: None,
        tools: None,
        fragments: vec![Fragment { of: FragmentOf::Transcript, ..fragment }],
        ..first.clone()
    };
    let piece = |of| json!([{ "version": 1001, "of": of, "index": 1, "count": 2, "bytes": "0102faff" }]);
    let first_value = json!({
        "tick": 16_666, "latest": 1001, "digest": u64::MAX,
        "tools": [{
            "client": 2, "centre": [6500, -1, 9000], "tool": { "sphere": 500 }, "touching": true, "inside": false,
        }],
        "fragments": piece("delta"),
    });
    let next_value =
        json!({ "tick": 16_666, "latest": 1001, "digest": null, "tools": null, "fragments": piece("transcript") });
    let (hand, hand_value) = hand();
    let head = PulseHead { acknowledged: 400, slack: Some(-6), teacher: Some(hand) };
    let quiet = PulseHead { acknowledged: 0, slack: None, teacher: None };
    vec![
        vector(
            "pulse",
            &encode(&Pulse { head, body: first.clone() }),
            json!({ "acknowledged": 400, "slack": -6, "teacher": hand_value, "body": first_value }),
        ),
        vector(
            "pulse",
            &encode(&Pulse { head: quiet, body: next.clone() }),
            json!({ "acknowledged": 0, "slack": null, "teacher": null, "body": next_value }),
        ),
        vector(
            "seen",
            &encode(&Sight { name: SIGHT, turning: Some(TURNING), body: first }),
            json!({ "name": sight(), "turning": turning(), "body": first_value }),
        ),
        vector(
            "seen",
            &encode(&Sight { name: SIGHT, turning: None, body: next }),
            json!({ "name": sight(), "turning": null, "body": next_value }),
        ),
    ]
}

fn keyframes() -> Vec<Value> {
    let keyframe = |sight_name, value: Value, mended, goes_on| {
        let keyframe = Keyframe {
            version: 900,
            since: 0,
            tick: 15_000,
            acknowledged: 77,
            sight: sight_name,
            mended,
            goes_on,
            bytes: vec![0, 128, 255],
        };
        vector(
            "keyframe",
            &encode(&keyframe),
            json!({
                "version": 900, "since": 0, "tick": 15_000, "acknowledged": 77, "sight": value,
                "mended": mended, "goes_on": goes_on, "bytes": "0080ff",
            }),
        )
    };
    vec![keyframe(None, Value::Null, 300, true), keyframe(Some(SIGHT), sight(), 0, false)]
}

fn sample_value(sample: &ToolSample) -> Value {
    let (kind, tool): (&str, Value) = match sample.tool {
        Tool::Sphere(sphere) => ("sphere", sphere.micrometres().into()),
        Tool::Convex(shape) => ("convex", shape.0.into()),
    };
    let turned = sample.tool.shape().map(|_| sample.orientation.0);
    let (tick, centre) = (sample.tick.0, sample.centre.0);
    json!({ "tick": tick, kind: tool, "turned": turned, "inside": sample.side == Side::Inside, "centre": centre })
}

/// Three hands, as they press for a while: a sphere that shakes, a rib that turns on the inner side and pauses, and one that
/// comes late and starts anew elsewhere.
fn transcripts() -> Vec<Value> {
    let since = Tick(70_000);
    let rib = Tool::Convex(Shape(0));
    let hand = |client: u16, tick: u64| {
        let (along, shake) = (tick as i32 * 7, (tick * tick % 11) as i32 - 5);
        let (tool, side, turned) = match client {
            2 => (rib, Side::Inside, [300 - 40 * tick as i16, i16::MIN, 9]),
            _ => (Tool::default(), Side::Outside, [0; 3]),
        };
        let centre =
            [6500 - along + shake, 10 * i32::from(client), 9000 + if client == 300 { along * along / 40 } else { 0 }];
        ToolSample {
            tick: since.offset(tick as i64 + 1),
            tool,
            orientation: Orientation(turned),
            centre: Position(centre),
            side,
        }
    };
    let mut transcript = Transcript::default();
    let mut last: BTreeMap<u16, ToolSample> = BTreeMap::new();
    let mut sub_steps = Vec::new();
    // one has come from before the snapshot
    last.insert(1, ToolSample { tick: since, ..hand(1, 0) });
    for tick in 0..17 {
        let presses = |client: &u16| match client {
            2 => tick != 6 && tick != 7,
            300 => tick == 5 || tick > 11,
            _ => tick < 15,
        };
        let told: Vec<_> = [1, 2, 300]
            .into_iter()
            .filter(presses)
            .map(|client| {
                let sample = hand(client, tick);
                let before = last.insert(client, sample).filter(|before| sample.follows(before));
                Pressed { client, sample, before }
            })
            .collect();
        assert!(transcript.add(told.iter().copied()));
        let value = |pressed: &Pressed| {
            let before = pressed.before.as_ref().map(sample_value);
            json!({ "client": pressed.client, "sample": sample_value(&pressed.sample), "before": before })
        };
        sub_steps.push(told.iter().map(value).collect::<Vec<_>>());
    }
    let bytes = transcript.encode(since);
    assert_eq!(Transcript::decode(&bytes, since), Some(transcript));
    let nothing = Transcript::default().encode(since);
    vec![
        json!({ "since": since.0, "hex": hex(&bytes), "sub_steps": sub_steps }),
        json!({ "since": since.0, "hex": hex(&nothing), "sub_steps": [] }),
    ]
}

fn retelling() -> Value {
    let retelling = Retelling { since: [0x70, 0x11], told: [5, 0], digest: [0xcd, 0xab], transcript: vec![1, 0, 255] };
    let value = json!({ "since": 0x1170, "told": 5, "digest": 0xabcd, "transcript": "0100ff" });
    vector("retelling", &encode(&retelling), value)
}

fn vectors() -> Value {
    let messages =
        [greetings(), requests(), notices(), uploads(), vec![retelling()], datagrams(), keyframes()].concat();
    json!({ "version": VERSION, "messages": messages, "chains": chains::all(), "transcripts": transcripts() })
}

#[test]
fn vectors_are_what_is_said_today() {
    let path = shared("protocol-vectors.json");
    let today = format!("{:#}\n", vectors());
    if std::env::var_os("POTTERY_WRITE_VECTORS").is_some() {
        fs::write(&path, &today).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap();
    let first = kept.lines().zip(today.lines()).find(|(kept, today)| kept != today);
    assert!(
        kept == today,
        "the wire is no longer what shared/protocol-vectors.json says ({first:?}): raise VERSION, tell it in \
         shared/PROTOCOL.md, and write the vectors anew with POTTERY_WRITE_VECTORS=1"
    );
}

#[test]
fn program_in_the_description_reads_every_vector() {
    let text = fs::read_to_string(shared("PROTOCOL.md")).unwrap();
    let program = text.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let folder = folder("protocol");
    let script = folder.join("reader.py");
    fs::write(&script, program).unwrap();
    let output = Command::new("python3").arg(&script).arg(shared("protocol-vectors.json")).output();
    let output = output.expect("python3 reads the vectors: install it");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    let expected = format!("read {} messages and ", vectors()["messages"].as_array().unwrap().len());
    assert!(said.starts_with(&expected), "{said}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn description_names_version_and_limits() {
    let text = fs::read_to_string(shared("PROTOCOL.md")).unwrap();
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.starts_with(&format!("# The protocol, version {VERSION} ")), "another version");
    let alpn = std::str::from_utf8(ALPN).unwrap();
    let thousands = |number: i64| format!("{},{:03}", number / 1000, number % 1000);
    let input = Input::default();
    assert_eq!(KEYFRAME_MAX, 1 << 24);
    let said = [
        alpn.to_owned(),
        format!(
            "of up to {DATAGRAM_MAX} bytes of payload; where QUIC finds that the path takes more, a server sends up to {DATAGRAM_LONGEST}."
        ),
        format!("without themselves), at most {}. A", thousands(CONTROL_MAX as i64)),
        format!(
            "one message of at most {DATAGRAM_MAX} bytes, or down {DATAGRAM_LONGEST}; a keyframe stream is one message of at most 2²⁴ bytes"
        ),
        format!("than {} KiB of memory", DATAGRAM_MEMORY_MAX / 1024),
        format!(
            "{} datagrams and {} KiB of them a second, {} requests and {} KiB of them",
            input.datagrams_per_s,
            input.datagram_bytes_per_s / 1024,
            input.requests_per_s,
            input.request_bytes_per_s / 1024
        ),
        format!("moves faster than {} m/s", ToolSample::SPEED_MAX_M_S),
        format!("comes more than {} ticks late", thousands(InputQueue::PAST_MAX)),
        format!("late or more than {} early", thousands(InputQueue::FUTURE_MAX)),
        format!("at most {} sub-steps and {} samples", Transcript::SUB_STEPS_MAX, Transcript::PRESSED_MAX),
        format!(
            "who does not read, {} frames or {} MiB of them wait, and then it is let go; of keyframes {} KiB",
            CONTROL_QUEUE,
            CONTROL_BYTES >> 20,
            KEYFRAME_BYTES / 1024
        ),
    ];
    for named in said {
        assert!(text.contains(&named), "{named:?} is not said");
    }
}
