//! Who comes in: codes old and new, a locked door, a lobby, a teacher's token.
//!
//! Owns what is shown at the door and the secrets that the room hands out; knows no person and no wheel.
//! Invariant: a secret is drawn once, and what could be stolen from here is hashes.

use alloc::collections::VecDeque;
use alloc::string::String;

use sha2::{Digest, Sha256};

use super::register::DoorState;
use crate::protocol::{JoinCode, Refusal, ResumeToken, TeacherToken};
use crate::units::Tick;

/// SHA-256 of a token.
pub type TokenHash = [u8; 32];

/// Who comes in, and with what.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DoorConfig {
    /// Random bits that nobody knows, from which codes and tokens are drawn; without them there are no new ones.
    pub secret: Option<[u8; 32]>,
    /// The hash of the teacher's token; nobody teaches without one.
    pub teacher: Option<TokenHash>,
    /// Ticks for which a code is good.
    pub code_ticks: Option<u64>,
    /// Whether who comes waits until a teacher lets them in.
    pub has_lobby: bool,
}

/// The hash of a token as it is kept.
#[must_use]
pub fn token_hash(token: &[u8]) -> TokenHash {
    Sha256::digest(token).into()
}

/// Codes that were replaced and are still told from those that never were.
const FORMER_MAX: usize = 16;

/// The doors of a room.
#[derive(Debug)]
pub(super) struct Doors {
    config: DoorConfig,
    /// Secrets drawn so far.
    drawn: u64,
    code: String,
    expires: Option<Tick>,
    former: VecDeque<String>,
    pub(super) is_locked: bool,
    pub(super) has_lobby: bool,
}

impl Doors {
    /// Doors that a code opens for good, and behind which nobody teaches.
    pub(super) fn new(code: String) -> Self {
        Self {
            config: DoorConfig::default(),
            drawn: 0,
            code,
            expires: None,
            former: VecDeque::new(),
            is_locked: false,
            has_lobby: false,
        }
    }

    /// The same doors, kept as given from now on.
    pub(super) fn keep(&mut self, config: DoorConfig, now: Tick) {
        self.expires = expiry(config.code_ticks, now);
        self.has_lobby = config.has_lobby;
        self.config = config;
    }

    /// What of them outlasts the room.
    pub(super) fn state(&self) -> DoorState {
        DoorState {
            code: self.code.clone(),
            former: self.former.iter().cloned().collect(),
            is_locked: self.is_locked,
            has_lobby: self.has_lobby,
        }
    }

    /// Goes on with other doors' state behind the own code, which is good for so many ticks. A lobby that was asked for stays.
    pub(super) fn go_on_from(&mut self, state: DoorState, code_ticks: Option<u64>, now: Tick) {
        self.former = state.former.into_iter().chain([state.code]).filter(|code| *code != self.code).collect();
        let too_many = self.former.len().saturating_sub(FORMER_MAX);
        self.former.drain(..too_many);
        self.expires = expiry(code_ticks, now);
        self.is_locked = state.is_locked;
        self.has_lobby |= state.has_lobby;
    }

    /// The room's part of the code.
    pub(super) fn code(&self) -> &str {
        &self.code
    }

    /// From when on the code is good no longer.
    pub(super) const fn expires(&self) -> Option<Tick> {
        self.expires
    }

    /// Whether a code lets in now.
    ///
    /// # Errors
    /// [`Refusal::Code`] for one that never was, which is a guess; else what is in the way of one that was right.
    pub(super) fn check(&self, code: &str, now: Tick) -> Result<(), Refusal> {
        if code != self.code {
            let is_former = self.former.iter().any(|former| former == code);
            return Err(if is_former { Refusal::CodeGone } else { Refusal::Code });
        }
        if self.expires.is_some_and(|expires| now >= expires) {
            return Err(Refusal::CodeGone);
        }
        if self.is_locked { Err(Refusal::Locked) } else { Ok(()) }
    }

    /// Whether a token is the teacher's. Hashes are compared: how long that takes says nothing about the token.
    pub(super) fn is_teachers(&self, token: &TeacherToken) -> bool {
        self.config.teacher.is_some_and(|teacher| teacher == token_hash(&token.0))
    }

    /// Another code from now on; false where none can be drawn.
    pub(super) fn renew_code(&mut self, now: Tick) -> bool {
        let Some([a, b, c, d, e, ..]) = self.draw() else { return false };
        if self.former.len() == FORMER_MAX {
            self.former.pop_front();
        }
        let new = JoinCode::room_of([a, b, c, d, e]);
        self.former.push_back(core::mem::replace(&mut self.code, new));
        self.expires = expiry(self.config.code_ticks, now);
        true
    }

    /// A token with which somebody comes back.
    pub(super) fn draw_resume(&mut self) -> Option<ResumeToken> {
        let mut token = [0; 16];
        token.copy_from_slice(&self.draw()?[..16]);
        Some(ResumeToken(token))
    }

    /// A number below a bound, as good as random.
    pub(super) fn draw_below(&mut self, bound: u16) -> u16 {
        self.draw().map_or(0, |bits| u16::from_le_bytes([bits[0], bits[1]]) % bound.max(1))
    }

    /// 256 bits that nobody can foretell who does not know the secret: its hash with a number that is used once.
    fn draw(&mut self) -> Option<[u8; 32]> {
        let secret = self.config.secret?;
        let number = self.drawn.to_le_bytes();
        self.drawn += 1;
        Some(Sha256::new().chain_update(secret).chain_update(number).finalize().into())
    }
}

fn expiry(code_ticks: Option<u64>, now: Tick) -> Option<Tick> {
    code_ticks.map(|ticks| Tick(now.0.saturating_add(ticks)))
}
