//! The part of Wavefront OBJ that a solid needs: `v` and `f`.
//!
//! Everything else (normals, textures, names, materials) is passed over. Read here and not by a library: those that
//! there are read materials for the most part, and none tells the line that is wrong.
//! Invariant: every corner that a face names has been read before.

use pottery_shared::tool::ConvexTool;

use super::{LineProblem, ToolFileFault, Triangles, has_room};

/// Most corners: three of their own for every triangle.
const CORNERS_MAX: usize = 3 * ConvexTool::TRIANGLES_MAX;

/// The triangles of an OBJ file; a face of more than three corners is cut from its first corner on.
pub(super) fn triangles(bytes: &[u8]) -> Result<Triangles, ToolFileFault> {
    // names and remarks may be in any encoding, numbers are not
    let text = String::from_utf8_lossy(bytes);
    let mut corners = Vec::new();
    let mut triangles = Triangles::new();
    for (number, line) in text.lines().enumerate() {
        let at_line = |problem| ToolFileFault::Line { line: number + 1, problem };
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                if corners.len() == CORNERS_MAX {
                    return Err(at_line(LineProblem::TooManyCorners { max: CORNERS_MAX }));
                }
                corners.push(corner(words).ok_or(at_line(LineProblem::Corner))?);
            }
            Some("f") => face(words, &corners, &mut triangles).map_err(at_line)?,
            _ => {}
        }
        if !has_room(&triangles) {
            break;
        }
    }
    Ok(triangles)
}

/// The first three numbers; a weight or a colour may follow.
fn corner<'a>(words: impl Iterator<Item = &'a str>) -> Option<[f32; 3]> {
    let mut numbers = words.map_while(|word| word.parse().ok());
    Some([numbers.next()?, numbers.next()?, numbers.next()?])
}

/// A fan over the corners of a face, each of them `corner`, `corner/texture` or `corner/texture/normal`.
fn face<'a>(
    words: impl Iterator<Item = &'a str>,
    corners: &[[f32; 3]],
    triangles: &mut Triangles,
) -> Result<(), LineProblem> {
    let mut first_and_last = None;
    let mut count = 0;
    for word in words.take_while(|word| !word.starts_with('#')) {
        let number = word.split('/').next().and_then(|number| number.parse::<i64>().ok()).unwrap_or(0);
        let index = if number < 0 { number + corners.len() as i64 } else { number - 1 };
        let named = usize::try_from(index).ok().and_then(|index| corners.get(index));
        let &corner = named.ok_or(LineProblem::Number { number, corners: corners.len() })?;
        if let Some((first, last)) = first_and_last {
            if count > 1 && has_room(triangles) {
                triangles.push([first, last, corner]);
            }
            first_and_last = Some((first, corner));
        } else {
            first_and_last = Some((corner, corner));
        }
        count += 1;
    }
    if count < 3 { Err(LineProblem::Face) } else { Ok(()) }
}
