//! STL, binary and text.
//!
//! `stl_io` reads both; decided here is which of the two it is, and that the file is whole.
//! Invariant: a binary file is told by its length, not by its first word.

use std::io::Cursor;

use super::{LineProblem, ToolFileFault, Triangles, has_room};

const HEADER_BYTES: usize = 80;
const COUNT_BYTES: usize = 4;
const FACET_BYTES: u64 = 50;
const BYTE_ORDER_MARK: &str = "\u{feff}";

/// The triangles of an STL file; the normals that stand there are left to themselves.
pub(super) fn triangles(mut bytes: Vec<u8>) -> Result<Triangles, ToolFileFault> {
    let length = bytes.len() as u64;
    let Some((triangles, needed)) = announced(&bytes) else { return read_text(&bytes) };
    if needed != length && text_start(&bytes).is_some() {
        return read_text(&bytes);
    }
    if needed > length {
        return Err(ToolFileFault::CutShort { triangles, needed, bytes: length });
    }
    // some programs begin their binary files with the word that begins the text form
    bytes[..HEADER_BYTES].fill(0);
    read(bytes)
}

/// How many triangles a binary file announces, and how many bytes they make.
fn announced(bytes: &[u8]) -> Option<(u32, u64)> {
    let count = bytes.get(HEADER_BYTES..)?.first_chunk::<COUNT_BYTES>()?;
    let triangles = u32::from_le_bytes(*count);
    Some((triangles, (HEADER_BYTES + COUNT_BYTES) as u64 + FACET_BYTES * u64::from(triangles)))
}

/// The text, from its first word on, when that is `solid`.
fn text_start(bytes: &[u8]) -> Option<&str> {
    let text = str::from_utf8(bytes).ok()?;
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text).trim_start();
    text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case("solid")).then_some(text)
}

/// Text as `stl_io` expects it: words in small letters, and a name behind `solid`, which other programs may leave out.
fn read_text(bytes: &[u8]) -> Result<Triangles, ToolFileFault> {
    let text = text_start(bytes).ok_or(ToolFileFault::Stl)?.to_ascii_lowercase();
    let (_, facets) = text.split_once('\n').unwrap_or_default();
    // what stands before the first facet is counted as well
    let before = bytes[..bytes.len() - facets.len()].iter().filter(|byte| **byte == b'\n').count();
    if let Some(at) = facets.lines().position(|line| !has_its_numbers(line)) {
        return Err(ToolFileFault::Line { line: before + at + 1, problem: LineProblem::Numbers });
    }
    if facets.lines().filter(|line| line.trim_start().starts_with("endsolid")).count() > 1 {
        return Err(ToolFileFault::SeveralSolids);
    }
    read(format!("solid tool\n{facets}").into_bytes())
}

/// Whether a line that has three numbers, as that of a corner or a normal does, has them indeed.
fn has_its_numbers(line: &str) -> bool {
    let line = line.trim_start();
    let Some(numbers) = line.strip_prefix("vertex").or_else(|| line.strip_prefix("facet normal")) else { return true };
    let mut words = numbers.split_ascii_whitespace();
    let finite = words.by_ref().take(3).filter(|word| word.parse().is_ok_and(f32::is_finite)).count();
    finite == 3 && words.next().is_none()
}

fn read(bytes: Vec<u8>) -> Result<Triangles, ToolFileFault> {
    let mut file = Cursor::new(bytes);
    let facets = stl_io::create_stl_reader(&mut file).map_err(|_| ToolFileFault::Stl)?;
    let mut triangles = Triangles::new();
    for facet in facets {
        if !has_room(&triangles) {
            break;
        }
        triangles.push(facet.map_err(|_| ToolFileFault::Stl)?.vertices.map(|corner| corner.0));
    }
    Ok(triangles)
}
