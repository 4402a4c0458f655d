//! A worse network than there is, between this program and the studio, so that a person can feel it.
//!
//! Owns the names on the command line; what is done to packets is `pottery_client::rehearsal`'s.
//! Invariant: of a studio that is hosted, nobody but this program goes through it.

use std::str::FromStr;

use anyhow::Context;
use pottery_client::Target;
use pottery_client::rehearsal::line::Quality;
use pottery_client::rehearsal::proxy::Proxy;

/// What the dice of every line begin with; real time makes each session another one anyway.
const SEED: u64 = 1;

/// A network by its name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Network {
    name: &'static str,
    quality: Quality,
}

impl FromStr for Network {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = || Quality::PRESETS.map(|(name, _)| name).join(", ");
        let known = Quality::PRESETS.into_iter().find(|(name, _)| *name == text);
        known.map(|(name, quality)| Self { name, quality }).ok_or_else(|| format!("choose one of {}", names()))
    }
}

impl Network {
    /// A target that is reached through the network as long as the proxy lives.
    pub(crate) async fn before(&self, target: Target) -> anyhow::Result<(Target, Proxy)> {
        let proxy = Proxy::start(target.resolved().await?, self.quality, SEED).await;
        let proxy = proxy.with_context(|| format!("no socket for the network {}", self.name))?;
        say!("network    {}: {}", self.name, self.quality);
        Ok((Target { address: proxy.address().to_string(), ..target }, proxy))
    }
}
