//! What stands between clay and hand, piece by piece: what devices may report, and how fast a tool is held to be.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::Vec3;
use pottery_shared::clay::{Material, Preset};
use pottery_shared::haptics::{
    Coupling, DeviceSpecs, Fault, Guidance, GuidanceMode, Haptics, PRESETS, Setup, Stages, Touch, VelocityEstimate, Wet,
};
use pottery_shared::tool::Position;
use pottery_shared::units::Seconds;
use pottery_tests::dice::Dice;

#[test]
fn every_preset_makes_sense_and_is_found_by_its_name() {
    for preset in &PRESETS {
        assert_eq!(preset.specs.checked(), Ok(preset.specs), "{}", preset.name);
        assert_eq!(DeviceSpecs::preset(preset.name), Some(preset), "{}", preset.name);
        assert!(preset.source.len() > 5, "{}", preset.name);
    }
    assert_eq!(DeviceSpecs::preset("omni").unwrap().specs, DeviceSpecs::OMNI);
    assert_eq!(DeviceSpecs::preset("mouse").unwrap().specs, DeviceSpecs::MOUSE);
}

#[test]
fn specs_that_make_no_sense_are_refused_in_one_sentence_that_names_the_figure() {
    type Spoil = fn(&mut DeviceSpecs, f32);
    let figures: [(&str, Spoil); 6] = [
        ("peak force", |specs, value| specs.peak_force_n = value),
        ("continuous force", |specs, value| specs.continuous_force_n = Some(value)),
        ("stiffness", |specs, value| specs.stiffness_max_n_m = value),
        ("workspace", |specs, value| specs.workspace_radius_m = value),
        ("mass", |specs, value| specs.mass_kg = value),
        ("resolution", |specs, value| specs.resolution_m = value),
    ];
    for (name, spoil) in figures {
        for value in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            let mut specs = DeviceSpecs::OMNI;
            spoil(&mut specs, value);
            // an exact position is no fault
            if name == "resolution" && value == 0.0 {
                specs.checked().unwrap();
                continue;
            }
            let said = specs.checked().unwrap_err().to_string();
            assert!(said.contains(name) && said.lines().count() == 1, "{said}");
            assert!(Haptics::new(Setup::for_device(specs, 1.0)).fault().is_some(), "{name} = {value}");
        }
    }
}

#[test]
fn force_of_the_clay_that_is_no_number_is_a_fault_at_once_and_passes_when_the_clay_is_sound() {
    // 2 mm deep, and at rest there
    let at_m = Vec3::X * -2e-3;
    for spoil in [
        (|touch: &mut Touch| touch.force_n.y = f32::NAN) as fn(&mut Touch),
        |touch| touch.force_n.x = f32::INFINITY,
        |touch| touch.penetration_m = f32::NAN,
    ] {
        let mut haptics = Haptics::new(Setup::for_device(DeviceSpecs::OMNI, 1.0));
        let mut felt = |spoils: bool| {
            let pressed = haptics.accept(Some(at_m), None, DT);
            let force_n = pressed.map(|pressed| {
                let mut touch = wall(pressed, None);
                if spoils {
                    spoil(&mut touch);
                }
                haptics.render(&touch)
            });
            (force_n, haptics.fault())
        };
        let felt_after = |felt: &mut dyn FnMut(bool) -> (Option<Vec3>, Option<Fault>)| {
            for _ in 0..200 {
                felt(false);
            }
            felt(false)
        };
        let (before_n, fault) = felt_after(&mut felt);
        assert!(before_n.unwrap().length() > 0.1 && fault.is_none(), "{before_n:?}");
        // in the same tick
        assert_eq!(felt(true), (Some(Vec3::ZERO), Some(Fault::Force)));
        // clay that stays so is asked again each hundred ticks, and never felt
        let mut asked = 0;
        for _ in 0..1000 {
            let (force_n, fault) = felt(true);
            asked += u32::from(force_n.is_some());
            assert_eq!((force_n.unwrap_or_default(), fault), (Vec3::ZERO, Some(Fault::Force)));
        }
        assert_eq!(asked, 1000 / Haptics::RECOVERY_TICKS);
        // sound ticks are counted from the last fault on, and then the force comes by the ramp: 100 N/s
        let mut ticks = 0;
        let first_n = loop {
            ticks += 1;
            match felt(false) {
                (Some(force_n), fault) if force_n != Vec3::ZERO => {
                    assert_eq!(fault, None);
                    break force_n;
                }
                (force_n, _) => {
                    assert!(force_n.is_none_or(|force_n| force_n == Vec3::ZERO) && ticks < 110, "{ticks} ticks")
                }
            }
        };
        assert!(first_n.length() < 0.1001, "{first_n} N");
        let (after_n, fault) = felt_after(&mut felt);
        assert!(
            after_n.unwrap().distance(before_n.unwrap()) < 1e-3 && fault.is_none(),
            "{before_n:?}, then {after_n:?}"
        );
        assert!(Fault::Force.to_string().lines().count() == 1);
    }
}

#[test]
fn velocity_lags_a_steady_acceleration_by_the_delay_it_states() {
    let acceleration_m_s2 = 0.5;
    let mut estimate = VelocityEstimate::default();
    let mut found = Vec3::ZERO;
    for tick in 0..200_u8 {
        let seconds = f32::from(tick) * DT.0;
        found = estimate.follow(Vec3::X * (0.5 * acceleration_m_s2 * seconds * seconds), DT);
    }
    let lag_s = 0.199 - found.x / acceleration_m_s2;
    // by the documentation; 10 mm in f32 are known to 1 nm, which is 1 µm/s in a difference and 2 µs of lag
    assert!((lag_s - 2.0415e-3).abs() < 0.004e-3, "{lag_s} s");
    assert!((lag_s / VelocityEstimate::DELAY.0 - 1.0).abs() < 0.03, "{lag_s} s");
}

#[test]
fn velocity_of_a_flickering_place_is_less_than_its_step_over_the_tick() {
    let step_m = 55e-6;
    let mut estimate = VelocityEstimate::default();
    for tick in 0..100_u8 {
        let found = estimate.follow(Vec3::Y * step_m * f32::from(tick % 2), Seconds(1e-3));
        assert!(found.length() <= 0.4 * step_m / 1e-3, "{found}");
    }
    estimate.forget();
    assert_eq!(estimate.follow(Vec3::ONE, Seconds(1e-3)), Vec3::ZERO);
}

/// A loop of 1 kHz.
const DT: Seconds = Seconds(1e-3);

/// A wall at x = 0 with 10 N/mm, on whose face clay goes by.
fn wall(centre: Position, wet: Option<Wet>) -> Touch {
    let penetration_m = (-centre.point_m().x).max(0.0);
    Touch { centre, force_n: Vec3::X * (penetration_m * 1e4), penetration_m, held_n: 0.0, wet }
}

fn clay_of(preset: Preset, velocity_m_s: Vec3) -> Wet {
    // what 10 N press on at the pressure that clay of that strength bears
    let material = Material::from_wetness(preset.wetness());
    let area_m2 = 10.0 / (2.2 * material.strength.yield_pa);
    Wet { clay_velocity_m_s: velocity_m_s, area_m2, material }
}

/// What is felt after half a second in which the device was held at a place.
fn held(setup: Setup, at_m: Vec3, wet: Option<Wet>) -> (Vec3, Position) {
    let mut chain = Haptics::new(setup);
    let mut felt = (Vec3::ZERO, Position::default());
    for tick in 0..500_u16 {
        // from the air in, no faster than a hand
        let begin_m = at_m.with_x(2e-3);
        let centre = chain.accept(Some(begin_m.lerp(at_m, (f32::from(tick) / 100.0).min(1.0))), None, DT).unwrap();
        felt = (chain.render(&wall(centre, wet)), centre);
    }
    felt
}

#[test]
fn coupling_of_every_device_keeps_to_the_bound_of_a_sampled_loop_at_every_delay() {
    for preset in &PRESETS {
        for delay_ms in [0.0, 0.5, 1.0, 2.0, 5.0, 20.0] {
            let delay = Seconds(delay_ms * 1e-3);
            let Coupling { stiffness_n_m, damping_ns_m } = Coupling::tuned(&preset.specs, DT, delay);
            // its own, and a hand of 1 N·s/m
            let least = stiffness_n_m * (0.5 * DT.0 + delay.0) + damping_ns_m.abs();
            assert!(preset.specs.damping_ns_m + 1.0 > least, "{} at {delay_ms} ms: {least}", preset.name);
            assert!(stiffness_n_m > 0.0 && stiffness_n_m <= preset.specs.stiffness_max_n_m, "{}", preset.name);
            assert!((0.0..=preset.specs.damping_max_ns_m).contains(&damping_ns_m), "{}", preset.name);
        }
    }
}

#[test]
fn stronger_device_feels_more_of_the_clay_and_never_more_than_all_of_it() {
    let share = |name| Setup::for_device(DeviceSpecs::preset(name).unwrap().specs, 0.2).felt_share;
    assert!((share("omni") - 0.2).abs() < 1e-6);
    // 12 N of 16.5 N, which is what the Omni's 3.3 N stand for
    assert!((share("omega.3") - 12.0 / 16.5).abs() < 1e-6);
    assert_eq!(share("delta.3"), 1.0);
}

#[test]
fn hand_at_rest_feels_the_coupling_and_the_clay_in_series() {
    let setup = Setup { felt_share: 0.2, ..Setup::for_device(DeviceSpecs::OMNI, 0.2) };
    let (force_n, centre) = held(setup, Vec3::new(-2e-3, 0.0, 0.0), None);
    // 0.7 N/mm before 2 N/mm, and half of the 10 µm in which places travel on 2 N/mm
    let wanted_n = 2e-3 / (1.0 / 700.0 + 1.0 / 2000.0);
    assert!((force_n.x - wanted_n).abs() < 0.01, "{force_n} N, not {wanted_n} N");
    assert!((force_n.x - 0.2 * wall(centre, None).force_n.x).abs() < 0.02, "{force_n} N against the clay");
}

#[test]
fn clay_is_pressed_with_no_more_than_the_device_gives_however_deep_the_hand_is() {
    for depth_mm in [8.0_f32, 12.0, 20.0] {
        let (force_n, centre) = held(Setup::for_device(DeviceSpecs::OMNI, 0.2), Vec3::X * (-depth_mm * 1e-3), None);
        assert!((force_n.length() - 3.3).abs() < 1e-4, "{force_n} N");
        let pressed_n = 0.2 * wall(centre, None).force_n.x;
        // half of the step in which places travel, on 2 N/mm
        assert!(pressed_n < 3.3 + 0.011, "{pressed_n} N at {depth_mm} mm");
    }
}

#[test]
fn drag_pulls_the_hand_the_way_the_clay_goes_and_the_wetter_the_less() {
    let setup = Setup::for_device(DeviceSpecs::OMNI, 0.2);
    let along = |preset, velocity_m_s| {
        let (force_n, _) = held(setup, Vec3::new(-2.5e-3, 0.0, 0.0), Some(clay_of(preset, velocity_m_s)));
        force_n.with_x(0.0) / force_n.x
    };
    let shares = Preset::ALL.map(|preset| along(preset, Vec3::Y * 0.3).y);
    assert!(shares.is_sorted_by(|drier, wetter| drier > wetter), "{shares:?}");
    assert!(shares[0] > 0.12 && shares[3] < 0.06, "{shares:?}");
    for velocity_m_s in [Vec3::Y * 0.3, Vec3::Z * -0.3, Vec3::new(0.0, 0.2, 0.2)] {
        let share = along(Preset::Throwing, velocity_m_s);
        // alike in all directions: a spring of 0.7 N/mm holds the tool 0.3 mm aside, where the wall is the same
        assert!(share.normalize().dot(velocity_m_s.normalize()) > 0.999, "{share} along {velocity_m_s}");
        assert!((share.length() / along(Preset::Throwing, Vec3::Y * 0.3).length() - 1.0).abs() < 0.1, "{share}");
    }
    // slip of water is felt by how fast it goes by
    let [slow, fast] = [0.1, 0.6].map(|speed| along(Preset::Slip, Vec3::Y * speed).y);
    assert!(fast > 2.0 * slow, "{slow} {fast}");
}

#[test]
fn still_clay_holds_a_tool_until_it_is_pulled_harder_than_it_sticks() {
    let wet = Some(clay_of(Preset::Stiff, Vec3::ZERO));
    let mut chain = Haptics::new(Setup::for_device(DeviceSpecs::OMNI, 0.2));
    let mut aside = Vec::new();
    for tick in 0..1000_u16 {
        let into = (f32::from(tick) / 100.0).min(1.0);
        let along_m = f32::from(tick.saturating_sub(500)) * 2e-6;
        let centre = chain.accept(Some(Vec3::new(2e-3 - 4.5e-3 * into, along_m, 0.0)), None, DT).unwrap();
        chain.render(&wall(centre, wet));
        aside.push((along_m, centre.point_m().y));
    }
    // 1.3 N press, 18 % of it hold: 0.33 mm of 0.7 N/mm
    let let_go = aside.iter().position(|(_, tool_m)| *tool_m > 0.0).unwrap();
    assert!((0.2e-3..0.45e-3).contains(&aside[let_go].0), "lets go at {} mm", aside[let_go].0 * 1e3);
    let (device_m, tool_m) = aside[999];
    assert!((0.2e-3..0.45e-3).contains(&(device_m - tool_m)), "it is dragged {} mm behind", (device_m - tool_m) * 1e3);
}

#[test]
fn chain_of_another_device_is_tuned_to_it_and_its_force_comes_by_the_ramp() {
    let (at_m, falcon) = (Vec3::X * -2e-3, DeviceSpecs::preset("falcon").unwrap().specs);
    let mut chain = Haptics::new(Setup { delay: Seconds(2e-3), ..Setup::for_device(DeviceSpecs::OMNI, 0.2) });
    chain.guide(Some(Guidance::new(GuidanceMode::ALL[0], 1.0)));
    let guided = chain.guided();
    assert!(guided.is_some());
    let setup = Setup { delay: Seconds(3e-3), ..Setup::for_device(falcon, 0.2) };
    let mut before_n = 0.0;
    for tick in 0..1000 {
        if tick == 500 {
            chain.set_up(setup);
            assert_eq!((chain.coupling(), chain.guided()), (Haptics::new(setup).coupling(), guided));
            assert_eq!(chain.tool_m(), None);
            before_n = 0.0;
        }
        let centre = chain.accept(Some(at_m), None, DT).unwrap();
        let force_n = chain.render(&wall(centre, None)).length();
        // 100 N/s
        assert!((tick % 500 > 10) || force_n - before_n < 0.1001, "tick {tick}: {before_n} N, then {force_n} N");
        before_n = force_n;
    }
    assert!(before_n > 0.3, "{before_n} N");
    // limits that make no sense keep the force off, and sound ones bring it back
    chain.set_up(Setup::for_device(DeviceSpecs { peak_force_n: 0.0, ..falcon }, 0.2));
    assert_eq!((chain.accept(Some(at_m), None, DT), chain.fault()), (None, Some(Fault::Specs)));
    chain.set_up(setup);
    assert!(chain.accept(Some(at_m), None, DT).is_some() && chain.fault().is_none());
}

#[test]
fn a_force_that_a_driver_took_for_gone_comes_back_by_the_ramp() {
    let mut chain = Haptics::new(Setup::for_device(DeviceSpecs::OMNI, 0.2));
    let mut pressed = |ticks: u16| {
        let centre = chain.accept(Some(Vec3::X * -2e-3), None, Seconds(1e-3 * f32::from(ticks))).unwrap();
        chain.render(&wall(centre, None)).length()
    };
    let settled_n = (0..500).map(|_| pressed(1)).last().unwrap();
    assert!(settled_n > 0.5, "{settled_n} N");
    // the driver goes on with the last force meanwhile
    let kept_n = pressed(30);
    assert!((kept_n - settled_n).abs() < 0.1001, "{kept_n} N after {settled_n} N");
    for stall in [Haptics::SILENCE_TICKS + 3, 4 * Haptics::SILENCE_TICKS] {
        assert!((0..500).map(|_| pressed(1)).last() > Some(0.5));
        let mut before_n = pressed(stall);
        assert!(before_n < 0.1001, "{before_n} N at once after {stall} ticks");
        for tick in 0..200 {
            let force_n = pressed(1);
            // 100 N/s
            assert!(force_n - before_n < 0.1001, "{stall} ticks, then {tick}: {before_n} N, then {force_n} N");
            before_n = force_n;
        }
        assert!((before_n / settled_n - 1.0).abs() < 0.1, "{before_n} N, {settled_n} N before");
    }
}

/// Two slopes that fall towards each other at 45°, with 40 N/mm each.
fn groove(centre: Position) -> Touch {
    let [x, _, z] = centre.point_m().to_array();
    let pushes_n = [x, -x].map(|aside_m| 4e4 * (aside_m - z).max(0.0) / core::f32::consts::SQRT_2);
    let level_n = pushes_n[1] - pushes_n[0];
    let parts_n = pushes_n.map(|push_n| push_n / core::f32::consts::SQRT_2);
    Touch {
        centre,
        force_n: Vec3::new(level_n, 0.0, pushes_n[0] + pushes_n[1]) / core::f32::consts::SQRT_2,
        penetration_m: (x.abs() - z).max(0.0) / core::f32::consts::SQRT_2,
        held_n: parts_n[0] + parts_n[1] - (parts_n[0] - parts_n[1]).abs(),
        wet: None,
    }
}

#[test]
fn a_tool_that_clay_holds_on_both_sides_is_not_thrown_from_one_to_the_other() {
    // a hand in a groove, which goes from side to side at up to 15 mm/s
    let largest_change_n = |is_known: bool| {
        let mut chain = Haptics::new(Setup::for_device(DeviceSpecs::OMNI, 0.2));
        let mut forces_n = Vec::new();
        for tick in 0..2000_u16 {
            let seconds = f32::from(tick) * DT.0;
            let at_m = Vec3::new(2e-3 * (7.5 * seconds).sin(), 0.0, 1e-3 - (5e-3 * seconds).min(3e-3));
            let centre = chain.accept(Some(at_m), None, DT).unwrap();
            let touch = groove(centre);
            let held_n = if is_known { touch.held_n } else { 0.0 };
            forces_n.push(chain.render(&Touch { held_n, ..touch }));
        }
        forces_n[1000..].windows(2).map(|pair| pair[1].distance(pair[0])).fold(0.0, f32::max)
    };
    let [known_n, unknown_n] = [true, false].map(largest_change_n);
    // a step in which places travel is 0.08 N on these slopes, and a hand tells 0.1 N apart
    let what = format!("{known_n} N in a tick, {unknown_n} N where nobody says what holds it");
    println!("{what}");
    assert!(known_n < 0.05 && unknown_n > 1.5 * known_n, "{what}");
}

#[test]
fn what_damps_a_hand_that_a_standing_force_has_thrown_lets_go_little_by_little() {
    // a device that bears more than is asked for, so that the limit hides nothing
    let specs = DeviceSpecs { peak_force_n: 100.0, continuous_force_n: None, ..DeviceSpecs::OMNI };
    let setup = |passivity| Setup {
        stages: Stages { passivity, ramp: false, ..Stages::WHOLE },
        felt_share: 0.2,
        ..Setup::for_device(specs, 0.2)
    };
    let mut chains = [true, false].map(|passivity| Haptics::new(setup(passivity)));
    // into the wall at 0.1 m/s, with a loop that stands still for 15 ms on the way
    let mut brakes_n = Vec::new();
    for tick in (0..40).chain(55..120_u16) {
        let (at_m, dt) = (Vec3::X * (1e-3 - f32::from(tick) * 1e-4), if tick == 55 { Seconds(16e-3) } else { DT });
        let [with_n, without_n] = chains.each_mut().map(|chain| {
            let centre = chain.accept(Some(at_m), None, dt).unwrap();
            chain.render(&wall(centre, None)).x
        });
        brakes_n.push(with_n - without_n);
    }
    let after_n = &brakes_n[40..];
    // 5 N·s/m
    assert!(after_n.iter().any(|&brake_n| (0.45..=0.501).contains(&brake_n)), "{after_n:?}");
    assert!(after_n[after_n.len() - 20..].iter().all(|brake_n| brake_n.abs() < 1e-3), "{after_n:?}");
    // 50 N/s, and what the encoder's steps make of the speed
    assert!(after_n.windows(2).all(|pair| pair[0] - pair[1] < 0.051), "{after_n:?}");
}

#[test]
fn correction_leaves_room_for_a_step_of_the_encoders_and_ends_however_coarse_they_are() {
    // over a wall that is 2 mm lower from one tick to the next
    for (resolution_m, within_20_ms_n) in [(0.0, 0.09), (55e-6, 0.09 - 700.0 * 55e-6), (1e-3, 0.045)] {
        let specs = DeviceSpecs { resolution_m, ..DeviceSpecs::OMNI };
        let mut chain = Haptics::new(Setup { felt_share: 0.2, ..Setup::for_device(specs, 0.2) });
        let mut forces_n = Vec::new();
        for tick in 0..2000_u16 {
            if tick == 500 {
                chain.clay_corrected();
            }
            let lower_m = if tick < 500 { Vec3::ZERO } else { Vec3::X * 2e-3 };
            let centre = chain.accept(Some(Vec3::X * -2.5e-3 * (f32::from(tick) / 100.0).min(1.0)), None, DT).unwrap();
            let there = Position::nearest(centre.point_m() + lower_m).unwrap();
            forces_n.push(chain.render(&Touch { centre, ..wall(there, None) }).x);
        }
        let changed_n = forces_n[490..].windows(21).map(|pair| pair[0] - pair[20]).fold(0.0, f32::max);
        assert!((changed_n - within_20_ms_n).abs() < 1e-3, "{resolution_m} m: {changed_n} N in 20 ms");
        // 0.5 mm is left of 2.5, in series with 2 N/mm
        let left_n = 0.5e-3 / (1.0 / 700.0 + 1.0 / 2000.0);
        assert!((forces_n[1999] - left_n).abs() < 0.01, "{resolution_m} m: {} N in the end", forces_n[1999]);
    }
}

/// A device that rests in the clay and says that it flies.
#[test]
fn a_velocity_that_no_hand_has_is_not_felt() {
    let coupling = Coupling { stiffness_n_m: 700.0, damping_ns_m: 5.0 };
    for velocity_m_s in [f32::MAX, -1e20, 100.0, 5.1].map(Vec3::splat) {
        let forces_n = [Vec3::ZERO, velocity_m_s].map(|odd_m_s| {
            let mut chain =
                Haptics::new(Setup { coupling: Some(coupling), ..Setup::for_device(DeviceSpecs::OMNI, 0.2) });
            let mut force_n = Vec3::ZERO;
            for tick in 0..400 {
                let said_m_s = if tick == 399 { odd_m_s } else { Vec3::ZERO };
                let at_m = Vec3::new(-1e-3, 0.0, 0.0);
                let centre = chain.accept(Some(at_m), Some(said_m_s), Seconds(1e-3)).unwrap();
                force_n = chain.render(&wall(centre, Some(clay_of(Preset::Soft, Vec3::ZERO))));
            }
            force_n
        });
        assert!(forces_n[0].length() > 0.1 && forces_n[0] == forces_n[1], "{velocity_m_s} m/s: {forces_n:?}");
    }
}

#[test]
fn force_is_finite_and_within_the_peak_whatever_comes() {
    let mut dice = Dice::new(0xf0e);
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e20, 0.0, 1e-45];
    for stages in [Stages::WHOLE, Stages::EXACT, Stages::ORIGINAL] {
        let mut chain = Haptics::new(Setup { stages, ..Setup::for_device(DeviceSpecs::OMNI, 0.2) });
        let mut felt = 0;
        for tick in 0..50_000_u32 {
            let strange = dice.chance(0.002);
            let mut number =
                |usual: f32| if strange && dice.chance(0.3) { odd[(dice.roll() % 7) as usize] } else { usual };
            let depth_m = 3e-3 * (tick as f32 * 0.01).sin();
            let at_m = Vec3::new(number(-depth_m), number(0.0), number(1e-3));
            let dt = Seconds(number(1e-3));
            let velocity_m_s = Vec3::splat(number(0.1));
            let Some(centre) = chain.accept(Some(at_m), Some(velocity_m_s), dt) else { continue };
            let sound = wall(centre, Some(clay_of(Preset::Soft, Vec3::Y * number(0.3))));
            let force_n = sound.force_n.map(&mut number);
            if strange {
                chain.clay_corrected();
            }
            let (penetration_m, held_n) = (number(sound.penetration_m), number(sound.held_n));
            let force_n = chain.render(&Touch { force_n, penetration_m, held_n, ..sound });
            assert!(
                force_n.is_finite() && force_n.length() <= 3.3 * (1.0 + 1e-6),
                "{stages:?}, tick {tick}: {force_n}"
            );
            felt += u32::from(force_n.length() > 0.1);
        }
        assert!(felt > 1000, "{stages:?}: {felt} ticks with a force");
    }
}
