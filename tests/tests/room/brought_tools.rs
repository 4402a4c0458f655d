//! Tools that people bring to a wheel: everybody has the same under the same number before anybody presses with it, late
//! joiners too, and what makes no tool, or one too many, is refused with a reason.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{GridShape, Material, MethodKind, PotSpec};
use pottery_shared::protocol::{self, CONTROL_MAX, FrameReader, MeshWire, NoTool, Request};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{BROUGHT_MAX, BROUGHT_TRIANGLES_MAX, BringError, Client, ClientEvent, mesh_of, tool_of};
use pottery_shared::tool::{ConvexError, ConvexTool, Orientation, Position, Shape, Side, Tool, ToolSample, rack};
use pottery_shared::units::{Metres, Rpm, Tick};

fn ball(subdivisions: u32, radius_mm: f32) -> ConvexTool {
    rack::ball(subdivisions, Metres::from_mm(radius_mm)).unwrap()
}

/// A room and clients that hear everything at once.
struct Studio {
    room: Room,
    clients: Vec<(Client, Vec<ClientEvent>)>,
    now: u64,
}

impl Studio {
    fn open() -> Self {
        let room = Room::new(RoomConfig {
            code: "CLAY".into(),
            wheels: 1,
            people_max: 4,
            pot: PotSpec { shape: GridShape::new(180, 200).unwrap(), ..PotSpec::default() },
            method: MethodKind::Plastic,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        });
        Self { room: room.unwrap(), clients: Vec::new(), now: 0 }
    }

    fn join(&mut self) -> usize {
        let peer = PeerId(self.clients.len() as u64);
        self.control(peer, &Client::greeting("CLAY", 1, true));
        let Lane::Control(welcome) = self.room.poll_transmit().unwrap().lane else { panic!("no welcome") };
        let client = Client::open(&frame_of(&welcome), self.now, Duration::from_millis(1)).unwrap();
        self.clients.push((client, Vec::new()));
        self.deliver();
        self.clients.len() - 1
    }

    fn control(&mut self, peer: PeerId, framed: &[u8]) {
        self.room.handle_control(peer, &frame_of(framed));
    }

    fn deliver(&mut self) {
        let time = Duration::from_millis(self.now);
        while let Some(transmit) = self.room.poll_transmit() {
            let (client, _) = &mut self.clients[transmit.to.0 as usize];
            match transmit.lane {
                Lane::Control(framed) => client.handle_control(&frame_of(&framed)).unwrap(),
                Lane::Datagram(bytes) => assert!(client.handle_datagram(&bytes, time)),
                Lane::Keyframe(bytes) => assert!(client.handle_keyframe(&bytes, time)),
                Lane::Close => panic!("{:?} was let go", transmit.to),
            }
        }
    }

    /// One tick; `held` says what a client holds where.
    fn step(&mut self, held: impl Fn(usize, u64) -> Option<(Tool, Vec3)>) {
        let time = Duration::from_millis(self.now);
        self.room.advance(Tick(self.now));
        self.deliver();
        for number in 0..self.clients.len() {
            let (client, events) = &mut self.clients[number];
            let tick = Tick(0).offset(self.now as i64 + client.tick_offset());
            if let Some((tool, place)) = held(number, self.now) {
                let orientation = Orientation::nearest([0.4, 0.1, self.now as f32 * 1e-3]).unwrap();
                let centre = Position::nearest(place).unwrap();
                client.handle_sample(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
            }
            client.rebase();
            events.extend(std::iter::from_fn(|| client.poll_event()));
            let frames: Vec<_> = std::iter::from_fn(|| client.poll_control()).collect();
            let datagrams: Vec<_> = std::iter::from_fn(|| client.poll_datagram(time)).collect();
            let peer = PeerId(number as u64);
            for framed in frames {
                self.control(peer, &framed);
            }
            for bytes in datagrams {
                self.room.handle_datagram(peer, &bytes);
            }
        }
        self.now += 1;
    }

    fn idle(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.step(|_, _| None);
        }
    }

    fn answers(&self, number: usize) -> Vec<ClientEvent> {
        let of_tools = |event: &&ClientEvent| matches!(event, ClientEvent::Brought(_) | ClientEvent::NotBrought(_));
        self.clients[number].1.iter().filter(of_tools).cloned().collect()
    }
}

fn frame_of(framed: &[u8]) -> Vec<u8> {
    let mut reader = FrameReader::default();
    reader.push(framed);
    reader.next_frame().unwrap().unwrap()
}

/// The mesh of a tool, to tell whether two are the same to the bit.
fn bits(tool: &ConvexTool) -> MeshWire {
    mesh_of(tool).unwrap()
}

#[test]
fn a_mesh_makes_the_same_tool_at_every_end_and_fits_a_frame() {
    for tool in rack::standard().iter().chain([&ball(0, 5.0), &ball(3, 12.0)]) {
        let mesh = mesh_of(tool).unwrap();
        let encoded = protocol::encode(&Request::Tool { mesh: mesh.clone() });
        println!("{} triangles in {} bytes", mesh.facets.len(), encoded.len());
        assert!(encoded.len() <= CONTROL_MAX, "{} bytes", encoded.len());
        let decoded: Request = protocol::decode::<CONTROL_MAX, _>(&encoded).unwrap();
        assert_eq!(decoded, Request::Tool { mesh: mesh.clone() });
        let (one, other) = (tool_of(&mesh).unwrap(), tool_of(&mesh).unwrap());
        assert_eq!(bits(&one), bits(&other));
        // it is the tool that was sent: its corners are not moved by more than an f32's rounding at 150 mm
        assert!(
            (one.radius().0 - tool.radius().0).abs() < 1e-7 && (one.volume_m3() / tool.volume_m3() - 1.0).abs() < 1e-5
        );
    }
}

#[test]
fn what_makes_no_tool_is_refused_with_its_reason() {
    assert_eq!(
        mesh_of(&ball(4, 12.0)).unwrap_err(),
        BringError::TooFine { triangles: 5120, max: BROUGHT_TRIANGLES_MAX }
    );
    let sound = mesh_of(&ball(1, 12.0)).unwrap();
    let mut unnumbered = sound.clone();
    unnumbered.facets[3][1] = u16::MAX;
    let mut endless = sound.clone();
    endless.corners_m[5][2] = f32::NAN;
    let mut open = sound.clone();
    open.facets.pop();
    let inside_out = MeshWire { facets: sound.facets.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..sound.clone() };
    let mut dented = sound.clone();
    dented.corners_m[0] = [0.0; 3];
    let huge = MeshWire {
        corners_m: sound.corners_m.iter().map(|corner| corner.map(|part| part * 100.0)).collect(),
        ..sound.clone()
    };
    let empty = MeshWire { corners_m: Vec::new(), facets: Vec::new() };
    // with as many corners that nothing names as a request has room for: what is told of it would be longer
    let mut loose = sound.clone();
    let fits = |mesh: &MeshWire| {
        let encoded = protocol::encode(&Request::Tool { mesh: mesh.clone() });
        protocol::decode::<CONTROL_MAX, Request>(&encoded).is_ok()
    };
    while fits(&loose) {
        loose.corners_m.push([0.0; 3]);
    }
    loose.corners_m.pop();
    let hostile = [unnumbered, endless, open, inside_out, dented, huge, empty, loose];
    let found = hostile.each_ref().map(|mesh| tool_of(mesh).unwrap_err());
    let is_expected = [
        matches!(found[0], BringError::Corner { triangle: 3, corner: u16::MAX, corners: 42 }),
        matches!(found[1], BringError::Mesh(ConvexError::NotANumber { .. })),
        matches!(found[2], BringError::Mesh(ConvexError::Open { .. })),
        matches!(found[3], BringError::Mesh(ConvexError::InsideOut { .. })),
        matches!(found[4], BringError::Mesh(ConvexError::NotConvex { .. })),
        matches!(found[5], BringError::Mesh(ConvexError::Size { .. })),
        matches!(found[6], BringError::Mesh(ConvexError::TooFew { .. })),
        matches!(found[7], BringError::Loose { max: 42, triangles: 80, .. }),
    ];
    assert_eq!(is_expected, [true; 8], "{found:?}");
    // a program without manners: each is answered, and nothing hangs in anybody's rack
    let mut studio = Studio::open();
    let (rude, other) = (studio.join(), studio.join());
    for mesh in hostile {
        studio.clients[rude].0.request(&Request::Tool { mesh });
        studio.idle(500);
    }
    assert_eq!(studio.answers(rude), vec![ClientEvent::NotBrought(NoTool::Unsound); 8]);
    assert_eq!(studio.answers(other), []);
    assert!(studio.clients.iter().all(|(client, _)| client.rack().len() == 4));
}

#[test]
fn a_brought_tool_is_in_everybodys_rack_and_presses_the_same_for_all() {
    let mut studio = Studio::open();
    let (first, second) = (studio.join(), studio.join());
    let tool = ball(2, 12.0);
    studio.clients[first].0.bring(&tool).unwrap();
    studio.idle(50);
    studio.clients[second].0.bring(&ball(1, 9.0)).unwrap();
    studio.idle(500);
    let late = studio.join();
    assert_eq!(studio.answers(first), [ClientEvent::Brought(Shape(4))]);
    assert_eq!(studio.answers(second), [ClientEvent::Brought(Shape(5))]);
    for number in [first, second, late] {
        let rack = studio.clients[number].0.rack();
        assert_eq!(rack.len(), 6, "client {number}");
        assert_eq!(bits(&rack[4]), bits(&tool_of(&mesh_of(&tool).unwrap()).unwrap()), "client {number}");
        assert_eq!(bits(&rack[5]), bits(&studio.clients[first].0.rack()[5]), "client {number}");
    }
    // what hangs there already is not hung a second time, whoever brings it
    studio.clients[late].0.bring(&tool).unwrap();
    studio.idle(50);
    assert_eq!(studio.answers(late), [ClientEvent::Brought(Shape(4))]);
    assert_eq!(studio.clients[first].0.rack().len(), 6);

    let begin = studio.now;
    for _ in 0..1500 {
        studio.step(|number, now| {
            let time = (now - begin) as f32 * 1e-3;
            let angle = number as f32 * 2.0;
            let distance = 0.069 - 0.003 * (2.0 * time).sin();
            let place = Vec3::new(distance * angle.cos(), distance * angle.sin(), 0.05 + 0.03 * number as f32);
            Some((Tool::Convex(Shape([4, 5, 4][number])), place))
        });
    }
    studio.idle(600);
    let pot = studio.room.pot(0).unwrap();
    assert!(pot.pressed_m3() * 1e9 > 500.0, "{} mm³", pot.pressed_m3() * 1e9);
    assert_eq!(studio.room.counts().refusals.total(), 0);
    for (number, (client, _)) in studio.clients.iter().enumerate() {
        assert!(client.is_settled() && client.mismatches() == 0, "client {number}");
        assert_eq!(Some(client.replica().digest()), studio.room.digest(0), "client {number}");
        assert_eq!(client.predicted().digest(), pot.digest(), "client {number}");
        // each has pressed again what the others pressed with tools that only one of them had a file of
        let steps = client.step_counts();
        assert!(steps.retold > 50 && steps.unlike == 0, "client {number}: {steps:?}");
    }
}

#[test]
fn an_own_stroke_with_a_brought_tool_needs_no_correction() {
    let mut studio = Studio::open();
    let own = studio.join();
    studio.clients[own].0.bring(&ball(3, 12.0)).unwrap();
    studio.idle(200);
    for _ in 0..1500 {
        studio.step(|_, now| Some((Tool::Convex(Shape(4)), Vec3::new(0.068, 0.0, 0.05 + now as f32 * 2e-5))));
    }
    studio.idle(300);
    let corrections: Vec<f32> = studio.clients[own]
        .1
        .iter()
        .filter_map(|event| match event {
            ClientEvent::Confirmed(correction) => correction.under_own_tool.map(|metres| metres.0),
            _ => None,
        })
        .collect();
    assert!(corrections.len() > 50, "{} confirmations", corrections.len());
    assert!(corrections.iter().all(|&metres| metres == 0.0), "{corrections:?}");
    assert_eq!(studio.clients[own].0.predicted().digest(), studio.room.pot(0).unwrap().digest());
}

#[test]
fn a_full_rack_says_so_and_keeps_what_it_has() {
    let mut studio = Studio::open();
    let own = studio.join();
    for number in 0..BROUGHT_MAX + 2 {
        studio.clients[own].0.bring(&ball(0, 5.0 + number as f32)).unwrap();
        studio.idle(500);
    }
    let full = ClientEvent::NotBrought(NoTool::Full { brought: BROUGHT_MAX as u16 });
    let answers = studio.answers(own);
    assert_eq!(answers[BROUGHT_MAX..], [full.clone(), full]);
    assert_eq!(answers[BROUGHT_MAX - 1], ClientEvent::Brought(Shape(3 + BROUGHT_MAX as u8)));
    let late = studio.join();
    assert_eq!(studio.clients[late].0.rack().len(), 4 + BROUGHT_MAX);
}
