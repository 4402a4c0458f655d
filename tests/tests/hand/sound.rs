//! The sound of a tool on clay, made without a sound card: what it follows, and what it never does.

use std::time::{Duration, Instant};

use pottery_client::sound::{RATE_HZ, Rub, STEP_MAX, Sound, SoundError, Voice};
use proptest::prelude::*;

/// A second of rubbing that began long enough ago, so that the voice has come to it.
fn second(rub: Rub) -> Vec<f32> {
    let mut voice = Voice::default();
    let mut samples = vec![0.0; RATE_HZ as usize];
    voice.fill(rub, &mut samples);
    voice.fill(rub, &mut samples);
    samples
}

const USUAL: Rub = Rub { force_n: 1.5, slip_m_s: 0.3, wetness: 0.27 };

/// Root of the mean square.
fn loudness(samples: &[f32]) -> f32 {
    (samples.iter().map(|sample| sample * sample).sum::<f32>() / samples.len() as f32).sqrt()
}

/// How high it sounds, Hz: of a tone, its frequency; of noise, the root of the mean square of the frequencies in it.
fn height_hz(samples: &[f32]) -> f32 {
    let steps: Vec<f32> = samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
    loudness(&steps) / loudness(samples) * RATE_HZ as f32 / std::f32::consts::TAU
}

/// How uneven its loudness is from one fiftieth of a second to the next: deviation over mean.
fn roughness(samples: &[f32]) -> f32 {
    let parts: Vec<f32> = samples.chunks(RATE_HZ as usize / 50).map(loudness).collect();
    let mean = parts.iter().sum::<f32>() / parts.len() as f32;
    let variance = parts.iter().map(|part| (part - mean).powi(2)).sum::<f32>() / parts.len() as f32;
    variance.sqrt() / mean
}

#[test]
fn a_tone_is_as_high_as_its_frequency() {
    let tone: Vec<f32> =
        (0..RATE_HZ).map(|at| (at as f32 * 440.0 * std::f32::consts::TAU / RATE_HZ as f32).sin()).collect();
    assert!((height_hz(&tone) - 440.0).abs() < 1.0 && (loudness(&tone) - 0.5_f32.sqrt()).abs() < 1e-3);
}

#[test]
fn more_force_is_louder_and_no_higher() {
    let heard = [0.1, 0.3, 1.0, 3.3].map(|force_n| second(Rub { force_n, ..USUAL }));
    for pair in heard.windows(2) {
        // each force is three times the one before; the ear needs a tenth more to tell
        assert!(loudness(&pair[1]) > 1.1 * loudness(&pair[0]), "{} after {}", loudness(&pair[1]), loudness(&pair[0]));
        // what is bent at the limit gets a little brighter
        assert!((height_hz(&pair[1]) / height_hz(&pair[0]) - 1.0).abs() < 0.1);
    }
    assert!(loudness(&heard[3]) > 0.05, "{}", loudness(&heard[3]));
}

#[test]
fn faster_is_higher_and_louder() {
    let heard = [0.02, 0.1, 0.4, 1.0].map(|slip_m_s| second(Rub { slip_m_s, ..USUAL }));
    for pair in heard.windows(2) {
        assert!(
            height_hz(&pair[1]) > 1.2 * height_hz(&pair[0]),
            "{} after {}",
            height_hz(&pair[1]),
            height_hz(&pair[0])
        );
        assert!(loudness(&pair[1]) > loudness(&pair[0]));
    }
}

#[test]
fn wet_clay_is_duller_softer_and_smoother_than_dry() {
    let heard = [0.1, 0.27, 0.45, 1.0].map(|wetness| second(Rub { wetness, ..USUAL }));
    for pair in heard.windows(2) {
        assert!(height_hz(&pair[1]) < height_hz(&pair[0]) && loudness(&pair[1]) < loudness(&pair[0]));
    }
    let [dry, wet] = [&heard[0], &heard[3]];
    assert!(height_hz(wet) < 0.6 * height_hz(dry), "{} and {} Hz", height_hz(wet), height_hz(dry));
    assert!(roughness(wet) < 0.7 * roughness(dry), "{} and {}", roughness(wet), roughness(dry));
}

#[test]
fn what_rests_or_makes_no_sense_is_silent() {
    for rub in [
        Rub::default(),
        Rub { force_n: 0.0, ..USUAL },
        Rub { slip_m_s: 0.0, ..USUAL },
        Rub { force_n: f32::NAN, ..USUAL },
        Rub { slip_m_s: f32::INFINITY, ..USUAL },
        Rub { force_n: -1.0, ..USUAL },
    ] {
        let mut voice = Voice::default();
        let mut samples = vec![0.0; RATE_HZ as usize];
        voice.fill(USUAL, &mut samples);
        // a second is a hundred time constants
        voice.fill(rub, &mut samples);
        voice.fill(rub, &mut samples);
        assert!(samples.iter().all(|sample| *sample == 0.0), "{rub:?}");
    }
}

#[test]
fn the_same_rubbing_makes_the_same_samples_in_whatever_pieces_they_are_asked_for() {
    let whole = {
        let mut samples = vec![0.0; 4801];
        Voice::default().fill(USUAL, &mut samples);
        samples
    };
    let mut voice = Voice::default();
    let mut pieces = vec![0.0; 4801];
    for piece in pieces.chunks_mut(77) {
        voice.fill(USUAL, piece);
    }
    assert_eq!(whole, pieces);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn nothing_clicks_or_goes_beyond_full_scale(
        rubs in prop::collection::vec((any::<f32>(), any::<f32>(), any::<f32>(), 0.0_f32..30.0, 0.0_f32..3.0, 0.0_f32..1.0, any::<bool>()), 1..20),
    ) {
        let mut voice = Voice::default();
        let mut before = 0.0;
        for (odd_n, odd_m_s, odd_wet, force_n, slip_m_s, wetness, is_odd) in rubs {
            let rub = if is_odd {
                Rub { force_n: odd_n, slip_m_s: odd_m_s, wetness: odd_wet }
            } else {
                Rub { force_n, slip_m_s, wetness }
            };
            let mut samples = [0.0; 480];
            voice.fill(rub, &mut samples);
            for sample in samples {
                prop_assert!(sample.abs() <= 1.0, "{sample} at {rub:?}");
                // a difference of two `f32` below 1 is rounded by 6e-8
                prop_assert!((sample - before).abs() <= STEP_MAX + 1e-6, "{before} to {sample} at {rub:?}");
                before = sample;
            }
        }
    }
}

#[test]
fn a_machine_with_or_without_sound_goes_on_and_says_which() {
    let sound = Sound::start(false, || USUAL);
    let begin = Instant::now();
    while !sound.is_played() && sound.trouble().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(30), "nobody knows whether there is sound");
        std::thread::sleep(Duration::from_millis(5));
    }
    sound.mute(true);
    if let Some(trouble) = sound.trouble() {
        let sentence = trouble.to_string();
        assert!(sentence.contains("start PulseAudio or PipeWire") || trouble == SoundError::Unsupported, "{sentence}");
    }
    drop(sound);
}
