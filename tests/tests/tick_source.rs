//! What the source of the hand's tick may not name: whatever waits, allocates, asks the system or ends a thread.
//!
//! Invariant: every function that a tick goes through stands in [`TICK_PATH`].

use std::path::Path;

/// The text of a function: from its name to the end of its outermost braces, without comments.
fn body<'a>(source: &'a [String], path: &str, function: &str) -> &'a [String] {
    let start = source
        .iter()
        .position(|line| line.contains(&format!("fn {function}(")))
        .unwrap_or_else(|| panic!("{path} has no function {function}: this test must learn its new name"));
    let mut depth = 0_i32;
    for (length, line) in source[start..].iter().enumerate() {
        depth += line.matches('{').count() as i32 - line.matches('}').count() as i32;
        if depth == 0 && line.contains('}') {
            return &source[start..=start + length];
        }
    }
    panic!("{path}: {function} does not end");
}

/// What a tick goes through, file by file.
const TICK_PATH: [(&str, &[&str]); 24] = [
    (
        "client/src/haptic_loop.rs",
        &[
            "keep",
            "is_idle",
            "turn",
            "tick",
            "follow_teacher",
            "between",
            "read",
            "setup",
            "grip",
            "let_go",
            "put_away",
            "give",
            "sample",
            "point",
            "feel",
            "wet",
            "send",
            "meet",
            "press",
            "catch_up",
        ],
    ),
    (
        "client/src/pacing.rs",
        &["turn", "is_tick", "deadline", "lateness", "done", "rest", "turns_a_tick", "period", "whole_turns"],
    ),
    (
        "client/src/boundary.rs",
        &[
            "note_tick",
            "note_lost_sample",
            "is_lifted",
            "tick_offset",
            "note_tool",
            "note_late",
            "note_rub",
            "is_force_off",
            "is_unguided",
            "is_pointing",
            "note_guided",
            "note_grip",
        ],
    ),
    (
        "client/src/device/driven.rs",
        &[
            "position",
            "velocity",
            "buttons",
            "tool",
            "orientation",
            "set_rub",
            "set_force",
            "specs",
            "is_another",
            "setup",
        ],
    ),
    (
        "client/src/device/pointer.rs",
        &["asked", "position", "glided", "tool", "orientation", "set_force", "specs", "setup"],
    ),
    ("client/src/device/rhythm.rs", &["late_after_s"]),
    (
        "client/src/device/calibration.rs",
        &["fitted", "turned", "place", "velocity", "force_to_device", "specs_in_room"],
    ),
    (
        "shared/src/prediction/hand.rs",
        &["press", "feel", "catch_up", "side", "stopped_at_clay", "ground", "is_corrected_since"],
    ),
    ("shared/src/prediction/ground.rs", &["free_share", "touches", "element_m2", "differs", "rows_beside"]),
    ("shared/src/prediction/field.rs", &["press", "feel", "advance", "round"]),
    (
        "shared/src/haptics.rs",
        &[
            "for_device",
            "new",
            "set_up",
            "is_taken_over",
            "accept",
            "guide",
            "lead",
            "hear_teacher",
            "follow_teacher",
            "guided",
            "render",
            "coupled",
            "filter",
            "withhold",
            "rest",
            "follow",
        ],
    ),
    (
        "shared/src/haptics/guidance.rs",
        &[
            "tune",
            "is_taken_over",
            "order",
            "lead",
            "hear",
            "pass",
            "lifts",
            "goal",
            "goal_velocity",
            "felt",
            "wanted",
            "given_for",
            "own_share",
            "guided",
            "rest",
            "saturated",
        ],
    ),
    ("shared/src/haptics/guidance/playout.rs", &["hear", "newest", "at", "lag", "between"]),
    ("shared/src/haptics/guidance/around.rs", &["polar", "between", "error_m", "felt", "turned"]),
    ("shared/src/haptics/guidance/noise.rs", &["pass", "roll"]),
    ("shared/src/haptics/guidance/tank.rs", &["pay_in", "add", "share", "stored_j"]),
    ("shared/src/haptics/given.rs", &["acted", "note"]),
    ("shared/src/haptics/coupling.rs", &["tuned", "stiffness_limit"]),
    ("shared/src/haptics/specs.rs", &["checked"]),
    ("shared/src/haptics/gate.rs", &["check", "fail", "recover"]),
    ("shared/src/haptics/proxy.rs", &["is_free", "follow", "meet", "forget"]),
    ("shared/src/haptics/drag.rs", &["of", "slip_m"]),
    ("shared/src/haptics/passivity.rs", &["control", "note", "forget"]),
    ("shared/src/haptics/ease.rs", &["blend", "ease", "forget"]),
];

/// What waits, allocates, asks the system for something, or may end a thread that must not end.
const FORBIDDEN: [&str; 37] = [
    "Mutex",
    "RwLock",
    ".lock(",
    ".wait(",
    ".recv(",
    ".join(",
    "yield_now",
    "park",
    "spawn",
    "sleep",
    "std::io",
    "std::fs",
    "std::net",
    "std::process",
    "std::env",
    "rustix",
    "SystemTime",
    "println!",
    "eprintln!",
    "print!",
    "tracing::",
    "log::",
    "format!",
    "Vec::",
    "vec!",
    "Box::",
    "Arc::",
    "String",
    ".to_vec(",
    ".to_owned(",
    ".to_string(",
    ".clone()",
    ".collect",
    ".unwrap()",
    ".expect(",
    "panic!",
    "File",
];

#[test]
fn tick_names_nothing_that_waits_or_allocates() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut broken = Vec::new();
    for (path, functions) in TICK_PATH {
        let text = std::fs::read_to_string(root.join(path)).unwrap();
        let source: Vec<_> = text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned()).collect();
        for function in functions {
            for line in body(&source, path, function) {
                let named = FORBIDDEN.iter().filter(|word| line.contains(**word));
                broken.extend(named.map(|word| format!("{path}, {function}: `{word}` in `{}`", line.trim())));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn the_thread_asks_the_system_for_sleep_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = std::fs::read_to_string(root.join("client/src/pacing.rs")).unwrap();
    let source: Vec<_> = text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned()).collect();
    let wait = body(&source, "client/src/pacing.rs", "wait_until");
    let named = |word: &str| wait.iter().filter(|line| line.contains(word)).count();
    assert_eq!(named("std::thread::sleep(left - spun)"), 1);
    let broken: Vec<_> = FORBIDDEN.iter().filter(|word| named(word) > usize::from(**word == "sleep")).collect();
    assert!(broken.is_empty(), "{broken:?}");
}
