//! Playing through PulseAudio's protocol, which PipeWire speaks as well; no C library is needed to build or to run.
//!
//! Owns the connection; the server asks for samples when it needs them.
//! Invariant: never more than [`AHEAD`] of sound waits in the server.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use pulseaudio::protocol::{ChannelMap, DEFAULT_SINK, PlaybackStreamParams, SampleFormat, SampleSpec};
use pulseaudio::protocol::{stream::BufferAttr, stream::StreamFlags};
use pulseaudio::{AsPlaybackSource, Client, PlaybackStream};

use super::{Player, RATE_HZ, Rub, SoundError, locked};

/// Sound that the server holds, and the least that it asks for: force and sound belong together within 50 ms.
const AHEAD: Duration = Duration::from_millis(30);
const ASKED: Duration = Duration::from_millis(10);
/// Bytes of a sample.
const SAMPLE: usize = size_of::<f32>();

fn bytes(time: Duration) -> u32 {
    (time.as_millis() as u32 * RATE_HZ / 1000) * SAMPLE as u32
}

/// Plays until what it returns is dropped.
pub(super) fn play<L: FnMut() -> Rub + Send + 'static>(
    player: Arc<Mutex<Player<L>>>,
) -> Result<(Client, PlaybackStream), SoundError> {
    let no_server = |error: pulseaudio::ClientError| {
        let cause = std::error::Error::source(&error).map(|cause| format!(": {cause}")).unwrap_or_default();
        SoundError::NoServer { reason: format!("{error}{cause}") }
    };
    let client = Client::from_env(c"Pottery studio").map_err(no_server)?;
    let buffer_attr = BufferAttr {
        target_length: bytes(AHEAD),
        minimum_request_length: bytes(ASKED),
        pre_buffering: bytes(ASKED),
        ..BufferAttr::default()
    };
    let params = PlaybackStreamParams {
        sample_spec: SampleSpec { format: SampleFormat::Float32Le, channels: 1, sample_rate: RATE_HZ },
        channel_map: ChannelMap::mono(),
        sink_name: Some(DEFAULT_SINK.to_owned()),
        buffer_attr,
        flags: StreamFlags { adjust_latency: true, ..StreamFlags::default() },
        ..PlaybackStreamParams::default()
    };
    let mut samples = Vec::new();
    let source = move |asked: &mut [u8]| {
        let count = asked.len() / SAMPLE;
        samples.resize(count, 0.0);
        locked(&player).fill(&mut samples);
        for (bytes, sample) in asked.chunks_exact_mut(SAMPLE).zip(&samples) {
            bytes.copy_from_slice(&sample.to_le_bytes());
        }
        count * SAMPLE
    };
    let stream = pollster::block_on(client.create_playback_stream(params, source.as_playback_source()));
    Ok((client, stream.map_err(no_server)?))
}
