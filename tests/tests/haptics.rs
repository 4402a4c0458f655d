//! What stands between clay and hand, piece by piece: what devices may report, and how fast a tool is held to be.

use glam::Vec3;
use pottery_shared::haptics::{DeviceSpecs, Haptics, PRESETS, VelocityEstimate};
use pottery_shared::units::Seconds;

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
            assert!(Haptics::new(specs, 1.0).fault().is_some(), "{name} = {value}");
        }
    }
}

#[test]
fn velocity_lags_a_steady_acceleration_by_the_delay_it_states() {
    const DT: Seconds = Seconds(1e-3);
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
