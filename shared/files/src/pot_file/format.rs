//! How a pot file lies in bytes, versions 1 and 2: a head of fixed places, packed radii, a checksum.
//!
//! `shared/files/POT-FILE.md` is the description; the numbers here are the same.
//! Invariant: version and length are read before anything else is believed, the checksum before any number is used.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use pottery_shared::clay::{Digest, GridShape, Material, MethodKind, PotError, PotSpec, Strength, Support, Wheel};
use pottery_shared::snapshot::{PotRecord, RecordError, dequantise};
use pottery_shared::units::{Metres, Rpm, Seconds};

use super::{FormatError, PotFile};

/// The first byte is no text, the rest shows a transfer that changed the ends of lines, as PNG's does.
const SIGNATURE: [u8; 8] = *b"\x89POT\r\n\x1a\n";
/// Version of a file with one surface, which older readers know, and of one with both skins of a wall.
const VERSIONS: [u32; 2] = [1, 2];
const HEAD_BYTES: usize = 72;
const CHECKSUM_BYTES: usize = 4;
const SHORTEST_BYTES: usize = HEAD_BYTES + CHECKSUM_BYTES;
/// Longest file: two of the largest grids, packed without gain (5 bytes in 16 kB), with head and checksum.
pub(super) const BYTES_MAX: usize = 4 * GridShape::ELEMENTS_MAX as usize + (64 << 10);

pub(super) fn encode(file: &PotFile) -> Vec<u8> {
    let spec = file.pot.spec();
    let packed = pack(&file.pot.planes());
    let length = SHORTEST_BYTES + packed.len();
    let mut bytes = Vec::with_capacity(length);
    bytes.extend(SIGNATURE);
    let surfaces = file.pot.steps().len();
    bytes.extend(VERSIONS[surfaces - 1].to_le_bytes());
    bytes.extend(u32::try_from(length).expect("a file is below its bound").to_le_bytes());
    bytes.extend(spec.shape.columns().to_le_bytes());
    bytes.extend(spec.shape.rows().to_le_bytes());
    let Material { viscosity, strength } = file.clay;
    let numbers = [
        spec.height.0,
        spec.radius.0,
        spec.wall.0,
        file.wheel_speed.0,
        viscosity.0,
        strength.youngs_pa,
        strength.yield_pa,
    ];
    bytes.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
    bytes.extend([u8::from(spec.keeps_volume), spec.support.number(), file.method.number(), surfaces as u8]);
    let pot = file.pot.pot();
    bytes.extend(pot.surfaces()[0].height_m().to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(digest_of(&file.pot, surfaces).to_le_bytes());
    assert_eq!(bytes.len(), HEAD_BYTES);
    bytes.extend(packed);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

pub(super) fn decode(bytes: &[u8]) -> Result<PotFile, FormatError> {
    if !bytes.starts_with(&SIGNATURE) {
        return Err(FormatError::NotAPot);
    }
    let mut head = Head { rest: &bytes[SIGNATURE.len()..], bytes: bytes.len() };
    let version = head.u32()?;
    let surfaces = match VERSIONS.iter().position(|&known| known == version) {
        Some(at) => at + 1,
        None if version == 0 => return Err(FormatError::Number { field: "version", number: 0 }),
        None => return Err(FormatError::FromTheFuture { version, newest: VERSIONS[1] }),
    };
    let expected = (head.u32()? as usize).max(SHORTEST_BYTES);
    let (sealed, checksum) = match bytes.split_last_chunk::<CHECKSUM_BYTES>() {
        Some(parts) if bytes.len() == expected => parts,
        _ => return Err(FormatError::Length { bytes: bytes.len(), expected }),
    };
    if crc32fast::hash(sealed) != u32::from_le_bytes(*checksum) {
        return Err(FormatError::Checksum);
    }
    let (columns, rows) = (head.u32()?, head.u32()?);
    let [height, radius, wall] = [head.f32()?, head.f32()?, head.f32()?].map(Metres);
    let wheel_speed = Rpm(head.f32()?);
    if !(-Wheel::RPM_MAX.0..=Wheel::RPM_MAX.0).contains(&wheel_speed.0) {
        return Err(FormatError::WheelSpeed { rpm: wheel_speed.0, max: Wheel::RPM_MAX.0 });
    }
    let viscosity = Seconds(head.f32()?);
    let clay = Material::new(viscosity, Strength { youngs_pa: head.f32()?, yield_pa: head.f32()? })?;
    let keeps_volume = known("rule for the volume", head.u8()?, |number| number == 1, u8::from)?;
    let support = known("support", head.u8()?, Support::from_number, Support::number)?;
    let method = known("method", head.u8()?, MethodKind::from_number, MethodKind::number)?;
    known("count of surfaces", head.u8()?, |_| surfaces as u8, |surfaces| surfaces)?;
    // for other readers; here it follows from the radii
    let _height_now_m = head.f32()?;
    let _reserved = head.u32()?;
    let digest = u64::from(head.u32()?) | u64::from(head.u32()?) << 32;
    let shape = GridShape::new(columns, rows).map_err(|error| RecordError::from(PotError::from(error)))?;
    let spec = PotSpec { shape, height, radius, wall, keeps_volume, support };
    spec.check().map_err(RecordError::from)?;
    let planes = unpack(&sealed[HEAD_BYTES..], 2 * surfaces * shape.elements())?;
    let pot = PotRecord::of_planes(spec, &planes)?;
    if digest_of(&pot, surfaces) != digest {
        return Err(FormatError::Digest);
    }
    Ok(PotFile { pot, method, wheel_speed, clay })
}

/// Digest of the radii of the first surfaces of a pot, as floats.
fn digest_of(pot: &PotRecord, surfaces: usize) -> u64 {
    let mut digest = Digest::default();
    let radii = pot.steps()[..surfaces].iter().flatten();
    radii.for_each(|&step| digest.add(dequantise(step).to_bits()));
    digest.finish()
}

/// What a number stands for; an error when it stands for nothing.
fn known<T: Copy>(
    field: &'static str,
    number: u8,
    from_number: impl Fn(u8) -> T,
    number_of: impl Fn(T) -> u8,
) -> Result<T, FormatError> {
    let found = from_number(number);
    if number_of(found) == number { Ok(found) } else { Err(FormatError::Number { field, number: number.into() }) }
}

/// The head, read from the front.
struct Head<'a> {
    rest: &'a [u8],
    /// Length of the whole file.
    bytes: usize,
}

impl Head<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], FormatError> {
        let cut_short = FormatError::Length { bytes: self.bytes, expected: SHORTEST_BYTES };
        let (first, rest) = self.rest.split_first_chunk::<N>().ok_or(cut_short)?;
        self.rest = rest;
        Ok(*first)
    }

    fn u8(&mut self) -> Result<u8, FormatError> {
        self.array().map(|[byte]| byte)
    }

    fn u32(&mut self) -> Result<u32, FormatError> {
        self.array().map(u32::from_le_bytes)
    }

    fn f32(&mut self) -> Result<f32, FormatError> {
        self.array().map(f32::from_le_bytes)
    }
}

/// Planes of radii as a zlib stream.
fn pack(planes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(planes).and_then(|()| encoder.finish()).expect("writing to memory does not fail")
}

fn unpack(packed: &[u8], bytes: usize) -> Result<Vec<u8>, FormatError> {
    let mut planes = Vec::new();
    let mut decoder = ZlibDecoder::new(packed);
    // grows with what is really there; a byte too many is seen and no more
    decoder.by_ref().take(bytes as u64 + 1).read_to_end(&mut planes).map_err(|_| FormatError::Packing)?;
    let is_all = planes.len() == bytes && decoder.total_in() == packed.len() as u64;
    if is_all { Ok(planes) } else { Err(FormatError::Packing) }
}
