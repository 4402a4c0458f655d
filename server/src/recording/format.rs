//! How a session file lies in bytes, version 3: the head of the file, and blocks with a head each.
//!
//! `server/SESSION-FILE.md` is the description; the numbers here are the same. Knows nothing of what is in a block.
//! Invariant: every byte of a block is covered by one of its two checksums, which are compared before a number is used.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use pottery_shared::clay::GridShape;
use pottery_shared::units::Tick;

/// The first byte is no text, the rest shows a transfer that changed the ends of lines, as PNG's does.
pub(super) const SIGNATURE: [u8; 8] = *b"\x89PSR\r\n\x1a\n";
/// The newest version there is; version 1 has no replaced clay, and what is older than [`VERSION_FOLDS`] no folds; they are the same for the rest.
pub(super) const VERSION: u32 = 3;
/// The first version whose states know how a hollow wall has folded.
pub(super) const VERSION_FOLDS: u32 = 3;
pub(super) const FILE_HEAD_BYTES: usize = 36;
pub(super) const BLOCK_HEAD_BYTES: usize = 36;
pub(super) const CHECKSUM_BYTES: usize = 4;
/// Room for the name of the program that wrote the file.
const WRITER_BYTES: usize = 16;
/// Largest block before it is packed: the state of the largest grid, both skins of a wall in two bytes an element, and 8 MiB for how it has
/// folded, all its tools and everybody.
pub(super) const PLAIN_MAX: usize = 2 * 2 * GridShape::ELEMENTS_MAX as usize + (8 << 20);
/// What packing without gain adds at most.
const PACKED_MAX: usize = PLAIN_MAX + (64 << 10);
/// Latest tick: nine thousand years.
pub(super) const TICK_MAX: u64 = 1 << 48;

/// What a block is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// How everything at a wheel stands.
    State,
    /// What happened at a wheel.
    Entries,
    /// The studio was closed; nothing follows.
    End,
}

impl Kind {
    const ALL: [(u8, Self); 3] = [(1, Self::State), (2, Self::Entries), (3, Self::End)];

    fn number(self) -> u8 {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or(0, |(number, _)| *number)
    }
}

/// The head of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BlockHead {
    pub(super) kind: Kind,
    pub(super) wheel: u16,
    /// Counted from 0 through the file.
    pub(super) number: u32,
    /// Bytes of the packed contents.
    pub(super) packed: u32,
    /// Bytes before packing.
    pub(super) plain: u32,
    pub(super) first: Tick,
    pub(super) last: Tick,
}

/// What is wrong with a head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HeadFault {
    /// Its bytes are not those that were written.
    Damaged,
    /// This stands for nothing.
    Meaningless(&'static str),
}

impl BlockHead {
    pub(super) fn bytes(&self) -> [u8; BLOCK_HEAD_BYTES] {
        let mut bytes = Vec::with_capacity(BLOCK_HEAD_BYTES);
        bytes.extend([self.kind.number(), 0]);
        bytes.extend(self.wheel.to_le_bytes());
        bytes.extend(self.number.to_le_bytes());
        bytes.extend(self.packed.to_le_bytes());
        bytes.extend(self.plain.to_le_bytes());
        bytes.extend(self.first.0.to_le_bytes());
        bytes.extend(self.last.0.to_le_bytes());
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes.try_into().expect("the fields of a head fill it")
    }

    pub(super) fn read(bytes: &[u8; BLOCK_HEAD_BYTES]) -> Result<Self, HeadFault> {
        let (sealed, checksum) = bytes.split_at(BLOCK_HEAD_BYTES - CHECKSUM_BYTES);
        if crc32fast::hash(sealed).to_le_bytes() != checksum {
            return Err(HeadFault::Damaged);
        }
        let mut fields = Fields(sealed);
        let meaningless = HeadFault::Meaningless;
        let [kind, zero] = fields.array();
        let kind = Kind::ALL.iter().find(|(number, _)| *number == kind && zero == 0).ok_or(meaningless("kind"))?.1;
        let head = Self {
            kind,
            wheel: u16::from_le_bytes(fields.array()),
            number: u32::from_le_bytes(fields.array()),
            packed: u32::from_le_bytes(fields.array()),
            plain: u32::from_le_bytes(fields.array()),
            first: Tick(u64::from_le_bytes(fields.array())),
            last: Tick(u64::from_le_bytes(fields.array())),
        };
        if head.packed as usize > PACKED_MAX || head.plain as usize > PLAIN_MAX {
            return Err(meaningless("length"));
        }
        if head.first > head.last || head.last.0 > TICK_MAX {
            return Err(meaningless("time"));
        }
        Ok(head)
    }

    /// Bytes from the beginning of the block to the next one.
    pub(super) fn length(&self) -> u64 {
        (BLOCK_HEAD_BYTES + CHECKSUM_BYTES) as u64 + u64::from(self.packed)
    }
}

/// Fields of a head whose length is known.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn array<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk().expect("a head has all its fields");
        self.0 = rest;
        *first
    }
}

/// The head of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FileHead {
    /// Of the format.
    pub(super) version: u32,
    pub(super) wheels: u16,
    /// Which program wrote it.
    pub(super) writer: String,
}

/// What is wrong with the head of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FileFault {
    NotASession,
    Version(u32),
    Damaged,
    Meaningless(&'static str),
}

impl FileHead {
    pub(super) fn bytes(&self) -> [u8; FILE_HEAD_BYTES] {
        let mut bytes = Vec::with_capacity(FILE_HEAD_BYTES);
        bytes.extend(SIGNATURE);
        bytes.extend(self.version.to_le_bytes());
        bytes.extend(self.wheels.to_le_bytes());
        bytes.extend([0; 2]);
        let mut writer = [0; WRITER_BYTES];
        writer.iter_mut().zip(self.writer.bytes()).for_each(|(to, from)| *to = from);
        bytes.extend(writer);
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes.try_into().expect("the fields of a head fill it")
    }

    /// The version is looked at before the checksum, since another version may have another head.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, FileFault> {
        let rest = bytes.strip_prefix(&SIGNATURE).ok_or(FileFault::NotASession)?;
        let (version, _) = rest.split_first_chunk().ok_or(FileFault::NotASession)?;
        let version = u32::from_le_bytes(*version);
        if !(1..=VERSION).contains(&version) {
            return Err(FileFault::Version(version));
        }
        let bytes: &[u8; FILE_HEAD_BYTES] = bytes.first_chunk().ok_or(FileFault::NotASession)?;
        let (sealed, checksum) = bytes.split_at(FILE_HEAD_BYTES - CHECKSUM_BYTES);
        if crc32fast::hash(sealed).to_le_bytes() != checksum {
            return Err(FileFault::Damaged);
        }
        let mut fields = Fields(&sealed[SIGNATURE.len() + 4..]);
        let wheels = u16::from_le_bytes(fields.array());
        let zero = u16::from_le_bytes(fields.array());
        let writer: [u8; WRITER_BYTES] = fields.array();
        let writer = writer.split(|&byte| byte == 0).next().unwrap_or_default();
        let is_text = writer.iter().all(u8::is_ascii_graphic);
        if wheels == 0 || zero != 0 || !is_text {
            return Err(FileFault::Meaningless("head"));
        }
        Ok(Self { version, wheels, writer: String::from_utf8_lossy(writer).into_owned() })
    }
}

/// A whole block: head, packed contents, their checksum.
pub(super) fn block(kind: Kind, wheel: u16, number: u32, span: (Tick, Tick), plain: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    let packed = encoder.write_all(plain).and_then(|()| encoder.finish()).expect("writing to memory does not fail");
    let head = BlockHead {
        kind,
        wheel,
        number,
        packed: u32::try_from(packed.len()).expect("a block is below its bound"),
        plain: u32::try_from(plain.len()).expect("a block is below its bound"),
        first: span.0,
        last: span.1,
    };
    let mut bytes = head.bytes().to_vec();
    bytes.extend(&packed);
    bytes.extend(crc32fast::hash(&packed).to_le_bytes());
    bytes
}

/// The contents of a block; `None` when they are not packed as they should be.
pub(super) fn unpack(head: &BlockHead, packed: &[u8]) -> Option<Vec<u8>> {
    let mut plain = Vec::new();
    let mut decoder = ZlibDecoder::new(packed);
    // grows with what is really there; a byte too many is seen and no more
    decoder.by_ref().take(u64::from(head.plain) + 1).read_to_end(&mut plain).ok()?;
    (plain.len() == head.plain as usize && decoder.total_in() == packed.len() as u64).then_some(plain)
}
