//! What the Falcon's firmware is told and what it answers: 16 ASCII bytes each way.
//!
//! Pure. Layout from libnifalcon's `FalconFirmwareNovintSDK.cpp`: `<`, three signed 16-bit numbers as four nibbles each,
//! lowest first, a byte of flags, a byte without meaning, `>`; nibbles and flags are counted from `A`.
//! Invariant: only bytes that a packet can have become an [`Answer`].

/// Bytes of a packet, either way.
pub const PACKET_BYTES: usize = 16;
/// Largest number for a motor, either way round: its converter has thirteen bits with the sign.
pub const MOTOR_MAX: i16 = 4095;

const FLAGS_AT: usize = 13;

/// What the grip's light shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// In use.
    Green = 2,
    /// Ready, without force.
    Blue = 4,
    /// To be homed.
    Red = 8,
}

/// What the Falcon is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// Voltages of the motors, −4095 to 4095.
    pub motors: [i16; 3],
    /// The grip's light.
    pub light: Light,
    /// Whether it is to look for its zero.
    pub homing: bool,
}

impl Order {
    /// The packet.
    #[must_use]
    pub fn bytes(&self) -> [u8; PACKET_BYTES] {
        let mut packet = [b'A'; PACKET_BYTES];
        packet[0] = b'<';
        packet[PACKET_BYTES - 1] = b'>';
        for (motor, &value) in self.motors.iter().enumerate() {
            let bits = value.clamp(-MOTOR_MAX, MOTOR_MAX) as u16;
            for nibble in 0..4 {
                packet[1 + motor * 4 + nibble] += (bits >> (4 * nibble)) as u8 & 0xf;
            }
        }
        packet[FLAGS_AT] += self.light as u8 | u8::from(self.homing);
        packet
    }
}

/// What the Falcon answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Counts of the encoders.
    pub encoders: [i16; 3],
    /// Buttons of the grip that are down: plus, forward, middle, minus from the lowest bit.
    pub buttons: u8,
    /// Whether all three legs know their zero.
    pub is_homed: bool,
}

impl Answer {
    /// Reads a packet; `None` for what is none.
    #[must_use]
    pub fn from_bytes(packet: &[u8; PACKET_BYTES]) -> Option<Self> {
        if packet[0] != b'<' || packet[PACKET_BYTES - 1] != b'>' {
            return None;
        }
        let mut encoders = [0; 3];
        for (leg, encoder) in encoders.iter_mut().enumerate() {
            let mut bits = 0;
            for nibble in 0..4 {
                let value = packet[1 + leg * 4 + nibble].checked_sub(b'A').filter(|value| *value < 16)?;
                bits |= u16::from(value) << (4 * nibble);
            }
            *encoder = bits as i16;
        }
        let flags = packet[FLAGS_AT].checked_sub(b'A').filter(|flags| *flags < 0x80)?;
        Some(Self { encoders, buttons: flags & 0xf, is_homed: flags >> 4 == 7 })
    }
}

/// Takes packets out of the bytes as they come.
#[derive(Debug, Default)]
pub struct Packets {
    bytes: Vec<u8>,
}

impl Packets {
    /// Appends what was read.
    pub fn take(&mut self, read: &[u8]) {
        self.bytes.extend_from_slice(read);
    }

    /// The next packet, and how many bytes before it were none; `None` as long as there is no whole one.
    pub fn poll(&mut self) -> Option<Result<Answer, usize>> {
        let begin = self.bytes.iter().position(|byte| *byte == b'<').unwrap_or(self.bytes.len());
        if begin > 0 {
            self.bytes.drain(..begin);
            return Some(Err(begin));
        }
        let packet: [u8; PACKET_BYTES] = self.bytes.get(..PACKET_BYTES)?.try_into().ok()?;
        if let Some(answer) = Answer::from_bytes(&packet) {
            self.bytes.drain(..PACKET_BYTES);
            return Some(Ok(answer));
        }
        // the packet may begin at a later `<`
        self.bytes.remove(0);
        Some(Err(1))
    }

    /// Forgets what has come so far.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_what_the_public_driver_sends() {
        let order = Order { motors: [0, 1, -1], light: Light::Green, homing: false };
        assert_eq!(&order.bytes(), b"<AAAABAAAPPPPCA>");
        let order = Order { motors: [0x0abc, -4096, 32767], light: Light::Red, homing: true };
        // limited to ±4095: −4095 is f001, 4095 is 0fff
        assert_eq!(&order.bytes(), b"<MLKABAAPPPPAJA>");
    }

    #[test]
    fn answer_has_signed_counts_buttons_and_homing() {
        let answer = Answer::from_bytes(b"<AAAABAAAPPPPFA>").unwrap();
        assert_eq!(answer, Answer { encoders: [0, 1, -1], buttons: 5, is_homed: false });
        let homed = *b"<AAAAAAAAAAAA\xb1A>";
        assert_eq!(Answer::from_bytes(&homed).unwrap(), Answer { encoders: [0; 3], buttons: 0, is_homed: true });
        let partly =
            [b'<', b'A', b'A', b'A', b'A', b'A', b'A', b'A', b'A', b'A', b'A', b'A', b'A', b'A' + 0x30, b'A', b'>'];
        assert!(!Answer::from_bytes(&partly).unwrap().is_homed);
    }

    #[test]
    fn bytes_that_no_packet_has_are_refused() {
        for packet in [b"<AAAAAAAAAAAAAAA", b"AAAAAAAAAAAAAAA>", b"<QAAAAAAAAAAAAA>", b"<@AAAAAAAAAAAAA>"] {
            assert_eq!(Answer::from_bytes(packet), None);
        }
    }

    #[test]
    fn packets_are_found_in_any_pieces_and_after_any_noise() {
        let stream = b"xx<AA<AAAABAAAPPPPFA><AAAAAAAAAAAAAA>";
        for piece in 1..stream.len() {
            let (mut packets, mut answers, mut noise) = (Packets::default(), Vec::new(), 0);
            for bytes in stream.chunks(piece) {
                packets.take(bytes);
                while let Some(next) = packets.poll() {
                    match next {
                        Ok(answer) => answers.push(answer),
                        Err(bytes) => noise += bytes,
                    }
                }
            }
            assert_eq!(answers.len(), 2, "in pieces of {piece}");
            assert_eq!((answers[0].encoders, noise), ([0, 1, -1], 5), "in pieces of {piece}");
        }
    }
}
