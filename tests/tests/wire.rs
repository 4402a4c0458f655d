//! The bytes between client and server: every message survives the journey, and bytes that are no message are refused
//! for no more memory than the message was allowed.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use pottery_shared::protocol::{
    self, Audience, Body, CONTROL_MAX, ClassWire, ClayWire, DATAGRAM_MEMORY_MAX, DetailWire, Fragment, FragmentOf,
    FrameReader, Greeting, GuidanceWire, HandWire, Hello, Inputs, JoinCode, JoinCodeError, KEYFRAME_MAX, Keyframe,
    LeadWire, MeshWire, NewsOf, NewsWire, Nickname, NoOrder, NoTool, Notice, Order, POT_PIECE, Pass, PersonWire,
    PlaceWire, PotOf, PotWire, Presence, ProgressWire, ProtocolError, Pulse, PulseHead, Purpose, Refusal, Request,
    ResumeToken, Retelling, Role, Run, ShapeWire, Sight, SightName, TargetWire, TeacherToken, ToolWire, Upload,
    Welcome, WheelInfo, WheelWire,
};
use proptest::prelude::*;

/// Counts the bytes that a thread asks for.
struct Counting;

thread_local! {
    static ASKED_BYTES: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: hands everything on to the system's allocator as it is; the counter is a plain cell that allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ASKED_BYTES.set(ASKED_BYTES.get().saturating_add(layout.size()));
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        ASKED_BYTES.set(ASKED_BYTES.get().saturating_add(new_size));
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.realloc(memory, layout, new_size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes that `work` asked the allocator for in all.
fn asked_bytes(work: impl FnOnce()) -> usize {
    let before = ASKED_BYTES.get();
    work();
    ASKED_BYTES.get() - before
}

fn text() -> impl Strategy<Value = String> {
    prop::collection::vec(any::<char>(), 0..40).prop_map(|characters| characters.into_iter().collect())
}

fn bytes(most: usize) -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..most)
}

fn greeting() -> impl Strategy<Value = Greeting> {
    (any::<[u8; 4]>(), any::<[u8; 2]>(), bytes(200)).prop_map(|(magic, version, hello)| Greeting {
        magic,
        version,
        hello,
    })
}

fn hello() -> impl Strategy<Value = Hello> {
    let purpose = prop_oneof![
        any::<bool>().prop_map(|retells| Purpose::Works { retells }),
        any::<u32>().prop_map(|bytes_per_s| Purpose::Watches { bytes_per_s }),
    ];
    let pass = prop_oneof![
        Just(Pass::None),
        any::<[u8; 32]>().prop_map(|bytes| Pass::Teacher(TeacherToken(bytes))),
        any::<[u8; 16]>().prop_map(|bytes| Pass::Resume(ResumeToken(bytes))),
        any::<([u8; 16], [u8; 32])>()
            .prop_map(|(back, teacher)| Pass::Return(ResumeToken(back), TeacherToken(teacher))),
    ];
    (text(), any::<u16>(), purpose, pass).prop_map(|(code, wheel, purpose, pass)| Hello { code, wheel, purpose, pass })
}

fn order() -> impl Strategy<Value = Order> {
    prop_oneof![
        any::<(u16, bool)>().prop_map(|(wheel, is_frozen)| Order::Freeze { wheel, is_frozen }),
        any::<(u16, bool)>().prop_map(|(wheel, is_open)| Order::Open { wheel, is_open }),
        (any::<u16>(), -1e9_f32..1e9).prop_map(|(wheel, rpm)| Order::WheelSpeed { wheel, rpm }),
        any::<(u16, u16, bool)>().prop_map(|(client, wheel, works)| Order::Seat { client, wheel, works }),
        any::<(u16, u8)>().prop_map(|(wheel, form)| Order::Pot { wheel, of: PotOf::Form(form) }),
        any::<(u16, u16)>().prop_map(|(wheel, from)| Order::Pot { wheel, of: PotOf::Wheel(from) }),
        any::<(u16, u64)>().prop_map(|(wheel, to)| Order::GoBack { wheel, to }),
        any::<u16>().prop_map(|wheel| Order::TakeBack { wheel }),
        any::<bool>().prop_map(|is_locked| Order::Lock { is_locked }),
        any::<bool>().prop_map(|is_on| Order::Lobby { is_on }),
        any::<(u16, bool)>().prop_map(|(client, is_admitted)| Order::Admit { client, is_admitted }),
        Just(Order::NewCode),
        Just(Order::End),
    ]
}

fn person() -> impl Strategy<Value = PersonWire> {
    let role = prop_oneof![Just(Role::Teacher), Just(Role::Student), Just(Role::Guest)];
    let presence = prop_oneof![Just(Presence::Here), Just(Presence::Away), Just(Presence::Waiting)];
    (any::<(u16, u16, u16, bool, bool)>(), role, presence).prop_map(
        |((client, name, wheel, works, touching), role, presence)| PersonWire {
            client,
            role,
            name: Nickname(name),
            wheel,
            works,
            presence,
            touching,
        },
    )
}

fn class() -> impl Strategy<Value = ClassWire> {
    let wheel =
        any::<(bool, bool, u64)>().prop_map(|(is_open, is_frozen, oldest)| WheelInfo { is_open, is_frozen, oldest });
    (text(), any::<(Option<u64>, bool, bool)>(), prop::collection::vec(wheel, 0..40)).prop_map(
        |(code, (expires, is_locked, has_lobby), wheels)| ClassWire { code, expires, is_locked, has_lobby, wheels },
    )
}

fn clay() -> impl Strategy<Value = ClayWire> {
    any::<[f32; 3]>().prop_map(|[viscosity_s, youngs_pa, yield_pa]| ClayWire { viscosity_s, youngs_pa, yield_pa })
}

fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        any::<f32>().prop_map(|rpm| Request::WheelSpeed { rpm }),
        clay().prop_map(|clay| Request::Clay { clay }),
        any::<u32>().prop_map(|have| Request::Again { have }),
        any::<u32>().prop_map(|have| Request::Resync { have }),
        (sight_name(), any::<u32>()).prop_map(|(sight, have)| Request::Watch { sight, have }),
        sight_name().prop_map(|sight| Request::Unwatch { sight }),
        any::<bool>().prop_map(|retells| Request::Retell { retells }),
        mesh().prop_map(|mesh| Request::Tool { mesh }),
        Just(Request::Leave),
        (any::<u32>(), bytes(1200)).prop_map(|(have, tiles)| Request::Mend { have, tiles }),
        (sight_name(), any::<u32>(), bytes(1200)).prop_map(|(sight, have, tiles)| Request::MendSight {
            sight,
            have,
            tiles,
        }),
        order().prop_map(Request::Order),
        any::<(u16, u8, u8)>().prop_map(|(student, mode, strength)| Request::Guide {
            student,
            guidance: GuidanceWire { mode, strength },
        }),
        Just(Request::EndGuidance),
        target().prop_map(Request::Target),
        (any::<u64>(), any::<u16>(), bytes(POT_PIECE)).prop_map(|(held, piece, bytes)| Request::Pot {
            held,
            piece,
            bytes
        }),
    ]
}

fn sight_name() -> impl Strategy<Value = SightName> {
    (any::<u16>(), detail()).prop_map(|(wheel, detail)| SightName { wheel, detail })
}

fn detail() -> impl Strategy<Value = DetailWire> {
    prop_oneof![
        Just(DetailWire::Spectator),
        Just(DetailWire::Gallery),
        Just(DetailWire::Retold),
        any::<(u16, u8, u8, u8, u8, bool)>().prop_map(|(quantum, fold, every, first, end, tools)| DetailWire::Own {
            quantum,
            fold,
            every,
            first,
            end,
            tools
        }),
    ]
}

fn mesh() -> impl Strategy<Value = MeshWire> {
    // what is not a number is not equal to itself
    let corner = prop::array::uniform3(-1e3_f32..1e3);
    (prop::collection::vec(corner, 0..40), prop::collection::vec(any::<[u16; 3]>(), 0..40))
        .prop_map(|(corners_m, facets)| MeshWire { corners_m, facets })
}

fn refusal() -> impl Strategy<Value = Refusal> {
    prop_oneof![
        any::<(u16, u16)>().prop_map(|(server, client)| Refusal::Version { server, client }),
        Just(Refusal::Code),
        any::<(u16, u16)>().prop_map(|(wheel, wheels)| Refusal::Wheel { wheel, wheels }),
        any::<u16>().prop_map(|people| Refusal::Full { people }),
        Just(Refusal::Greeting),
        Just(Refusal::CodeGone),
        Just(Refusal::Locked),
        Just(Refusal::Token),
        any::<u16>().prop_map(|wheel| Refusal::WheelClosed { wheel }),
        Just(Refusal::NotAdmitted),
    ]
}

fn wheel() -> impl Strategy<Value = WheelWire> {
    any::<(u64, u32, i32)>().prop_map(|(from, phase, rate)| WheelWire { from, phase, rate })
}

fn pot() -> impl Strategy<Value = PotWire> {
    let measures = any::<(u32, u32, f32, f32, f32, u8)>();
    measures.prop_map(|(columns, rows, height_m, radius_m, wall_m, support)| PotWire {
        columns,
        rows,
        height_m,
        radius_m,
        wall_m,
        support,
    })
}

fn audience() -> impl Strategy<Value = Audience> {
    (any::<(u64, u16, u8)>(), pot()).prop_map(|((now, wheels, method), pot)| Audience { now, wheels, pot, method })
}

fn welcome() -> impl Strategy<Value = Welcome> {
    let clay = prop::collection::vec((any::<u64>(), clay()), 0..20);
    let wheel = prop::collection::vec(wheel(), 0..20);
    (any::<(u16, u64, u8, u32, u8)>(), pot(), wheel, clay).prop_map(|(own, pot, wheel, clay)| {
        let (client, now, method, told, ahead) = own;
        Welcome { client, now, pot, wheel, clay, method, told, ahead }
    })
}

fn notice() -> impl Strategy<Value = Notice> {
    prop_oneof![
        welcome().prop_map(Notice::Welcome),
        audience().prop_map(Notice::Audience),
        refusal().prop_map(Notice::Refused),
        (any::<u64>(), any::<i32>()).prop_map(|(from, rate)| Notice::Wheel { from, rate }),
        (any::<u64>(), clay()).prop_map(|(from, clay)| Notice::Clay { from, clay }),
        (any::<u8>(), mesh()).prop_map(|(shape, mesh)| Notice::Tool { shape, mesh }),
        any::<u16>().prop_map(|brought| Notice::NoTool(NoTool::Full { brought })),
        Just(Notice::NoTool(NoTool::Unsound)),
        Just(Notice::Closing),
        Just(Notice::Waiting),
        any::<(u16, u16, u8, u8)>().prop_map(|(teacher, student, mode, strength)| {
            Notice::Guidance(LeadWire { teacher, student, guidance: GuidanceWire { mode, strength } })
        }),
        target().prop_map(Notice::Target),
        prop::collection::vec(progress(), 0..3).prop_map(Notice::Progress),
        (person(), any::<(bool, Option<[u8; 16]>)>()).prop_map(|(person, (may_press, resume))| {
            let PersonWire { client, role, name, wheel, .. } = person;
            let resume = resume.map(ResumeToken);
            Notice::Place(PlaceWire { client, role, name, wheel, may_press, resume })
        }),
        (prop::collection::vec(person(), 0..40), prop::collection::vec(any::<u16>(), 0..40))
            .prop_map(|(people, gone)| Notice::People { people, gone }),
        class().prop_map(Notice::Class),
        sight_name().prop_map(Notice::NoSight),
        any::<u16>().prop_map(|wheel| Notice::Come { wheel }),
        any::<u16>().prop_map(|client| Notice::NoOrder(NoOrder::Person { client })),
        any::<u64>().prop_map(|oldest| Notice::NoOrder(NoOrder::TooLongAgo { oldest })),
        (any::<(u16, u32)>(), news()).prop_map(|((wheel, told), of)| Notice::News(NewsWire { wheel, told, of })),
    ]
}

fn news() -> impl Strategy<Value = NewsOf> {
    let clays = prop::collection::vec((any::<u64>(), clay()), 0..20);
    prop_oneof![
        (prop::collection::vec(wheel(), 0..20), clays).prop_map(|(wheel, clay)| NewsOf::Standing { wheel, clay }),
        (any::<u64>(), any::<i32>()).prop_map(|(from, rate)| NewsOf::Wheel { from, rate }),
        (any::<u64>(), clay()).prop_map(|(from, clay)| NewsOf::Clay { from, clay }),
        (any::<u8>(), mesh()).prop_map(|(shape, mesh)| NewsOf::Tool { shape, mesh }),
    ]
}

fn progress() -> impl Strategy<Value = ProgressWire> {
    let is = target().prop_filter_map("a profile", |target| target);
    (any::<u16>(), is, prop::array::uniform3(-1e3_f32..1e3))
        .prop_map(|(wheel, is, [rms_m, most_m, most_at_m])| ProgressWire { wheel, is, rms_m, most_m, most_at_m })
}

fn target() -> impl Strategy<Value = Option<TargetWire>> {
    let radii = prop::collection::vec(any::<u16>(), 0..70);
    prop::option::of((-1e3_f32..1e3, radii).prop_map(|(height_m, radii)| TargetWire { height_m, radii }))
}

fn shape() -> impl Strategy<Value = ShapeWire> {
    prop_oneof![
        any::<u16>().prop_map(|radius_um| ShapeWire::Sphere { radius_um }),
        any::<(u8, [i16; 3])>().prop_map(|(shape, orientation)| ShapeWire::Convex { shape, orientation }),
    ]
}

fn inputs() -> impl Strategy<Value = Inputs> {
    let place = -Run::PLACE_MAX - 1..=Run::PLACE_MAX;
    let ways = prop::collection::vec(any::<([i16; 3], [i16; 3])>(), 0..60);
    let run = (any::<(u16, bool, bool)>(), prop::array::uniform3(place), shape(), ways).prop_map(
        |((first_tick, inside, turns), start, tool, ways)| {
            let turns = turns && matches!(tool, ShapeWire::Convex { .. });
            let (steps, turned): (Vec<_>, Vec<_>) = ways.into_iter().unzip();
            Run { first_tick, tool, inside, start, steps, turns: if turns { turned } else { Vec::new() } }
        },
    );
    (any::<(u16, bool)>(), prop::collection::vec(run, 0..6)).prop_map(|((first, rests), runs)| Inputs {
        first,
        runs,
        rests,
    })
}

fn hand() -> impl Strategy<Value = Option<HandWire>> {
    let hand = (any::<(u64, [i32; 3], u16, [bool; 2])>(), shape()).prop_map(
        |((tick, centre, force_mn, [draws, inside]), tool)| HandWire { tick, centre, tool, force_mn, draws, inside },
    );
    prop::option::of(hand)
}

fn upload() -> impl Strategy<Value = Upload> {
    (inputs(), hand(), any::<Option<u32>>()).prop_map(|(inputs, hand, again)| Upload { inputs, hand, again })
}

fn retelling() -> impl Strategy<Value = Retelling> {
    (any::<[[u8; 2]; 3]>(), bytes(900)).prop_map(|([since, told, digest], transcript)| Retelling {
        since,
        told,
        digest,
        transcript,
    })
}

fn pulse() -> impl Strategy<Value = Pulse> {
    let head = (any::<(u32, Option<i16>)>(), hand()).prop_map(|((acknowledged, slack), teacher)| PulseHead {
        acknowledged,
        slack,
        teacher,
    });
    (head, body()).prop_map(|(head, body)| Pulse { head, body })
}

fn sight() -> impl Strategy<Value = Sight> {
    (sight_name(), prop::option::of(wheel()), body()).prop_map(|(name, turning, body)| Sight { name, turning, body })
}

fn body() -> impl Strategy<Value = Body> {
    let tool = (any::<(u16, [i32; 3], bool, bool)>(), shape())
        .prop_map(|((client, centre, touching, inside), tool)| ToolWire { client, centre, tool, touching, inside });
    let of = prop_oneof![Just(FragmentOf::Delta), Just(FragmentOf::Transcript)];
    let fragment = (any::<(u32, u16, u16)>(), of, bytes(600))
        .prop_map(|((version, index, count), of, bytes)| Fragment { version, of, index, count, bytes });
    let tools = prop::option::of(prop::collection::vec(tool, 0..30));
    let fragments = prop::collection::vec(fragment, 0..3);
    (any::<(u64, u32, Option<u64>)>(), tools, fragments).prop_map(|((tick, latest, digest), tools, fragments)| Body {
        tick,
        latest,
        digest,
        tools,
        fragments,
    })
}

fn keyframe() -> impl Strategy<Value = Keyframe> {
    (any::<(u32, u32, u64, u32, u16, bool)>(), prop::option::of(sight_name()), bytes(3000)).prop_map(
        |((version, since, tick, acknowledged, mended, goes_on), sight, bytes)| Keyframe {
            version,
            since,
            tick,
            acknowledged,
            sight,
            mended,
            goes_on,
            bytes,
        },
    )
}

/// The laws of one message: it reads back, and neither more, fewer nor too many bytes are taken for it.
macro_rules! laws {
    ($name:ident, $strategy:expr, $message:ty, $limit:expr) => {
        proptest! {
            #[test]
            fn $name(message in $strategy, behind in 1_usize..9) {
                let encoded = protocol::encode(&message);
                prop_assert_eq!(protocol::decode::<{ $limit }, $message>(&encoded).unwrap(), message);
                let mut longer = encoded.clone();
                longer.extend(std::iter::repeat_n(0, behind));
                let malformed = ProtocolError::Malformed { bytes: longer.len() };
                prop_assert_eq!(protocol::decode::<{ $limit }, $message>(&longer), Err(malformed));
                for length in 0..encoded.len() {
                    let malformed = ProtocolError::Malformed { bytes: length };
                    prop_assert_eq!(protocol::decode::<{ $limit }, $message>(&encoded[..length]), Err(malformed));
                }
                let long = vec![0; $limit + 1];
                let too_long = ProtocolError::TooLong { bytes: $limit + 1, limit: $limit };
                prop_assert_eq!(protocol::decode::<{ $limit }, $message>(&long), Err(too_long));
            }
        }
    };
}

laws!(greeting_is_read_as_written, greeting(), Greeting, CONTROL_MAX);
laws!(hello_is_read_as_written, hello(), Hello, CONTROL_MAX);
laws!(request_is_read_as_written, request(), Request, CONTROL_MAX);
laws!(notice_is_read_as_written, notice(), Notice, CONTROL_MAX);
laws!(uploads_are_read_as_written, upload(), Upload, DATAGRAM_MEMORY_MAX);
laws!(pulse_is_read_as_written, pulse(), Pulse, DATAGRAM_MEMORY_MAX);
laws!(sight_is_read_as_written, sight(), Sight, DATAGRAM_MEMORY_MAX);
laws!(retelling_is_read_as_written, retelling(), Retelling, DATAGRAM_MEMORY_MAX);

proptest! {
    // a limit of 16 MiB is slow to exceed, so the law of too long input stands apart
    #[test]
    fn keyframe_is_read_as_written(message in keyframe(), behind in 1_usize..9) {
        let encoded = protocol::encode(&message);
        prop_assert_eq!(protocol::decode::<KEYFRAME_MAX, Keyframe>(&encoded).unwrap(), message);
        let mut longer = encoded.clone();
        longer.extend(std::iter::repeat_n(0, behind));
        prop_assert!(protocol::decode::<KEYFRAME_MAX, Keyframe>(&longer).is_err());
        prop_assert!(protocol::decode::<KEYFRAME_MAX, Keyframe>(&encoded[..encoded.len() - 1]).is_err());
    }
}

#[test]
fn keyframe_longer_than_allowed_is_refused() {
    let long = vec![0; KEYFRAME_MAX + 1];
    let too_long = ProtocolError::TooLong { bytes: KEYFRAME_MAX + 1, limit: KEYFRAME_MAX };
    assert_eq!(protocol::decode::<KEYFRAME_MAX, Keyframe>(&long), Err(too_long));
}

/// Decodes as everything there is and says how much memory was asked for.
fn memory_to_decode(bytes: &[u8]) -> usize {
    asked_bytes(|| {
        drop(protocol::decode::<CONTROL_MAX, Greeting>(bytes));
        drop(protocol::decode::<CONTROL_MAX, Hello>(bytes));
        drop(protocol::decode::<CONTROL_MAX, Request>(bytes));
        drop(protocol::decode::<CONTROL_MAX, Notice>(bytes));
        drop(protocol::decode::<DATAGRAM_MEMORY_MAX, Upload>(bytes));
        drop(protocol::decode::<DATAGRAM_MEMORY_MAX, Pulse>(bytes));
    })
}

/// Memory that all of `memory_to_decode` may take: each message its limit. Vectors are made in one piece, since their
/// lengths stand before them.
const MEMORY_MAX: usize = 4 * CONTROL_MAX + 2 * DATAGRAM_MEMORY_MAX;

/// A number as the wire writes it when it takes eight bytes.
fn eight_byte_number(number: u64) -> Vec<u8> {
    let mut bytes = vec![253];
    bytes.extend_from_slice(&number.to_le_bytes());
    bytes
}

#[test]
fn allocator_is_counted() {
    assert_eq!(asked_bytes(|| drop(std::hint::black_box(vec![1_u8; 1000]))), 1000);
}

/// What decoding `bytes` as a message asks for; it must be refused.
macro_rules! asked_to_refuse {
    ($message:ty, $limit:expr, $bytes:expr) => {{
        let bytes = $bytes;
        asked_bytes(|| assert!(protocol::decode::<{ $limit }, $message>(&bytes).is_err()))
    }};
}

#[test]
fn claimed_length_is_not_believed() {
    for claimed in [1 << 16, 1 << 32, 1 << 60, u64::MAX] {
        let claim = |before: &[u8]| [before, &eight_byte_number(claimed)].concat();
        let asked = [
            asked_to_refuse!(Greeting, CONTROL_MAX, claim(b"POTS\x01\x00")),
            asked_to_refuse!(Hello, CONTROL_MAX, claim(&[])),
            asked_to_refuse!(Notice, CONTROL_MAX, claim(&[0, 1, 0, 8, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0])),
            asked_to_refuse!(Request, CONTROL_MAX, claim(&[2])),
            asked_to_refuse!(Request, CONTROL_MAX, claim(&[2, 0])),
            asked_to_refuse!(Upload, DATAGRAM_MEMORY_MAX, claim(&[])),
            asked_to_refuse!(Pulse, DATAGRAM_MEMORY_MAX, claim(&[0, 0, 0, 0, 0, 0, 1])),
            asked_to_refuse!(Pulse, DATAGRAM_MEMORY_MAX, claim(&[0, 0, 0, 0, 0, 0, 0])),
        ];
        // nothing is taken for what is only claimed
        assert!(asked.iter().all(|&bytes| bytes == 0), "{claimed} elements claimed: {asked:?} bytes asked for");
        // 2¹⁶ bytes are allowed in a keyframe, so they may be taken before they are missed
        let of_keyframe = asked_to_refuse!(Keyframe, KEYFRAME_MAX, claim(&[0, 0, 0, 0]));
        let allowed = if claimed <= KEYFRAME_MAX as u64 { claimed as usize } else { 0 };
        assert!(of_keyframe <= allowed, "{claimed} bytes claimed: {of_keyframe} bytes asked for");
    }
}

proptest! {
    #[test]
    fn bytes_of_chance_take_no_more_memory_than_allowed(bytes in bytes(1200)) {
        prop_assert!(memory_to_decode(&bytes) <= MEMORY_MAX);
    }

    #[test]
    fn damaged_message_takes_no_more_memory_than_allowed(
        message in inputs(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut bytes = protocol::encode(&message);
        for (at, value) in damage {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        prop_assert!(memory_to_decode(&bytes) <= MEMORY_MAX);
    }

    #[test]
    fn frames_are_put_together_from_any_pieces(
        messages in prop::collection::vec(bytes(300), 0..12),
        cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..40),
    ) {
        let stream: Vec<u8> = messages.iter().flat_map(|message| protocol::frame(message)).collect();
        let mut cuts: Vec<_> = cuts.iter().map(|cut| cut.index(stream.len() + 1)).collect();
        cuts.extend([0, stream.len()]);
        cuts.sort_unstable();
        let mut reader = FrameReader::default();
        let mut found = Vec::new();
        for piece in cuts.windows(2) {
            reader.push(&stream[piece[0]..piece[1]]);
            while let Some(message) = reader.next_frame().unwrap() {
                found.push(message);
            }
        }
        prop_assert_eq!(found, messages);
    }

    #[test]
    fn frame_announced_too_long_is_refused_before_it_arrives(
        length in CONTROL_MAX + 1..=usize::from(u16::MAX),
        before in prop::option::of(bytes(20)),
    ) {
        let mut reader = FrameReader::default();
        if let Some(message) = &before {
            reader.push(&protocol::frame(message));
        }
        reader.push(&(length as u16).to_le_bytes());
        if before.is_some() {
            prop_assert_eq!(reader.next_frame(), Ok(before));
        }
        prop_assert_eq!(reader.next_frame(), Err(ProtocolError::TooLong { bytes: length, limit: CONTROL_MAX }));
    }
}

#[test]
fn clay_takes_twelve_bytes_and_the_longest_welcome_passes() {
    let clay = ClayWire { viscosity_s: 0.1195, youngs_pa: 2e6, yield_pa: 40e3 };
    assert_eq!(protocol::encode(&clay).len(), 12);
    assert_eq!(protocol::encode(&Request::Clay { clay }).len(), 13);
    // one byte says which notice it is, nine that the tick is a large number
    assert_eq!(protocol::encode(&Notice::Clay { from: u64::MAX, clay }).len(), 22);
    // a wheel remembers 256 changes of each setting, and a newcomer is told of them all
    let welcome = Notice::Welcome(Welcome {
        client: u16::MAX,
        now: 1 << 48,
        pot: PotWire { columns: 1440, rows: 1600, height_m: 0.2, radius_m: 0.06, wall_m: 0.008, support: 1 },
        wheel: vec![WheelWire { from: 1 << 48, phase: u32::MAX, rate: i32::MIN }; 256],
        clay: vec![(1 << 48, clay); 256],
        method: 2,
        told: u32::MAX,
        ahead: 15,
    });
    let bytes = protocol::encode(&welcome);
    println!("{} bytes of {CONTROL_MAX}", bytes.len());
    assert_eq!(protocol::decode::<CONTROL_MAX, Notice>(&bytes), Ok(welcome));
}

#[test]
fn longest_frame_passes() {
    let message = vec![7; CONTROL_MAX];
    let mut reader = FrameReader::default();
    reader.push(&protocol::frame(&message));
    assert_eq!(reader.next_frame(), Ok(Some(message)));
    assert_eq!(reader.next_frame(), Ok(None));
}

fn join_code() -> impl Strategy<Value = JoinCode> {
    any::<([u8; 5], [u8; 32])>().prop_map(|(random, certificate)| JoinCode::new(random, &certificate))
}

/// How people spell a code: in lower case, with other letters that look alike, with other gaps.
fn spelled(code: &str, habits: &[u8]) -> String {
    let habit = |at: usize| habits[at % habits.len()];
    let letters = code.chars().enumerate().filter(|(at, character)| *character != '-' || habit(*at) % 2 == 0);
    let alike = letters.map(|(at, character)| match (character, habit(at) % 5) {
        ('1', 1) => 'I',
        ('1', 2) => 'l',
        ('1', 3) => 'i',
        ('1', 4) => 'L',
        ('0', 1 | 3) => 'O',
        ('0', 2 | 4) => 'o',
        ('-', 2 | 4) => ' ',
        (other, 1 | 2) => other.to_ascii_lowercase(),
        (other, _) => other,
    });
    alike.collect()
}

proptest! {
    #[test]
    fn join_code_is_read_as_printed(code in join_code()) {
        let printed = code.to_string();
        prop_assert_eq!(printed.len(), 24 + 5, "{}", printed);
        prop_assert_eq!(printed.parse::<JoinCode>().unwrap(), code);
    }

    #[test]
    fn join_code_without_a_server_is_read_as_printed(code in join_code()) {
        let room: JoinCode = code.room().parse().unwrap();
        prop_assert_eq!((room.room(), room.print()), (code.room(), None));
        prop_assert_eq!(room.to_string().parse::<JoinCode>().unwrap(), room);
    }

    #[test]
    fn join_code_is_read_however_it_is_spelled(code in join_code(), habits in prop::collection::vec(any::<u8>(), 1..30)) {
        let printed = code.to_string();
        let spelled = spelled(&printed, &habits);
        prop_assert_eq!(spelled.parse::<JoinCode>().unwrap(), code.clone(), "{}", spelled);
        let bare: String = printed.to_lowercase().replace('-', "");
        prop_assert_eq!(bare.parse::<JoinCode>().unwrap(), code);
    }

    #[test]
    fn wrong_character_is_refused_by_name(
        code in join_code(),
        at in any::<prop::sample::Index>(),
        wrong in any::<char>().prop_filter("stands in a code", |wrong| {
            !(wrong.is_ascii_alphanumeric() && !matches!(wrong, 'u' | 'U') || matches!(wrong, '-' | ' '))
        }),
    ) {
        let mut characters: Vec<char> = code.to_string().chars().collect();
        let at = at.index(characters.len());
        characters[at] = wrong;
        let text: String = characters.into_iter().collect();
        let error = text.parse::<JoinCode>().unwrap_err();
        prop_assert_eq!(error, JoinCodeError::Character(wrong));
        prop_assert!(error.to_string().contains(&format!("'{wrong}'")), "{}", error);
    }

    #[test]
    fn wrong_length_is_refused_with_the_length(length in (0_usize..60).prop_filter("sound", |&n| n != 8 && n != 24)) {
        let error = "7".repeat(length).parse::<JoinCode>().unwrap_err();
        prop_assert_eq!(error, JoinCodeError::Length(length));
        prop_assert_eq!(error.to_string(), format!("a join code has 8 or 24 characters, this one has {length}"));
    }
}

#[test]
fn join_code_is_printed_in_fours_without_letters_that_look_alike() {
    let code = JoinCode::new([0xff, 0x00, 0xff, 0x00, 0xff], &[0xa5; 32]);
    assert_eq!(code.to_string(), "ZW0F-Y07Z-MPJT-B9D5-MPJT-B9D5");
    assert_eq!(code.print(), Some(&[0xa5; 10]));
}

#[test]
fn a_datagram_that_is_cut_takes_no_more_memory_than_it_may() {
    let (tool, steps) = (ShapeWire::Sphere { radius_um: 12_000 }, vec![[250, -90, 3000]; Run::STEPS_MAX]);
    let run = Run { first_tick: 0, tool, inside: false, start: [0; 3], steps, turns: Vec::new() };
    let whole = protocol::encode(&Inputs { first: 0, runs: vec![run], rests: false });
    for bytes in 0..whole.len() - 1 {
        let cut = [&[bytes as u8][..], &whole[1..=bytes]].concat();
        let asked = asked_bytes(|| drop(protocol::decode::<DATAGRAM_MEMORY_MAX, Inputs>(&cut)));
        assert!(asked <= DATAGRAM_MEMORY_MAX, "{asked} bytes asked for");
    }
}
