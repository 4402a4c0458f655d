//! glTF 2.0 in one binary file.
//!
//! The format has metres and y upwards and nothing else, so here, alone among the solids, the pot is in metres and lies the
//! other way round: (x, y, z) becomes (x, z, −y).
//! Invariant: both chunks and every view in them begin at a multiple of four bytes.

use std::io;

use serde_json::json;

use super::SolidMesh;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const HEAD_BYTES: usize = 12;
const CHUNK_HEAD_BYTES: usize = 8;
/// Numbers of the format for what a view holds and what its numbers are.
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// A vector as the format lies: y upwards.
fn lying([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, z, 0.0 - y]
}

pub(super) fn write(mesh: &SolidMesh, out: &mut impl io::Write) -> io::Result<()> {
    let metres = |length_mm: f32| (f64::from(length_mm) * 1e-3) as f32;
    let places: Vec<_> = mesh.corners_mm().iter().map(|&corner_mm| lying(corner_mm).map(metres)).collect();
    let mut json = description(&places, mesh.facets().len()).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let numbers = places.len() * 6 + mesh.facets().len() * 3;
    let length = HEAD_BYTES + 2 * CHUNK_HEAD_BYTES + json.len() + 4 * numbers;
    let word = |bytes: usize| u32::try_from(bytes).map(u32::to_le_bytes).map_err(|_| io::ErrorKind::FileTooLarge);
    out.write_all(MAGIC)?;
    out.write_all(&VERSION.to_le_bytes())?;
    out.write_all(&word(length)?)?;
    out.write_all(&word(json.len())?)?;
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    out.write_all(&word(4 * numbers)?)?;
    out.write_all(b"BIN\0")?;
    for number in places.into_iter().chain(mesh.normals().iter().copied().map(lying)).flatten() {
        out.write_all(&number.to_le_bytes())?;
    }
    for corner in mesh.facets().iter().flatten() {
        out.write_all(&corner.to_le_bytes())?;
    }
    Ok(())
}

/// The JSON chunk: one node with one mesh, whose bytes lie one after the other in the other chunk.
fn description(places: &[[f32; 3]], facets: usize) -> serde_json::Value {
    let least = |axis: usize| places.iter().map(|place| place[axis]).fold(f32::INFINITY, f32::min);
    let most = |axis: usize| places.iter().map(|place| place[axis]).fold(f32::NEG_INFINITY, f32::max);
    let (corners, vectors) = (places.len(), places.len() * 12);
    let indices = facets * 12;
    json!({
        "asset": { "version": "2.0", "generator": "pottery studio" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "pot" }],
        "meshes": [{ "name": "pot", "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0, "mode": 4
        }] }],
        "materials": [{ "name": "clay", "pbrMetallicRoughness": {
            "baseColorFactor": [0.34, 0.19, 0.12, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8
        } }],
        "buffers": [{ "byteLength": 2 * vectors + indices }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": vectors, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": vectors, "byteLength": vectors, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": 2 * vectors, "byteLength": indices, "target": ELEMENT_ARRAY_BUFFER }
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": FLOAT, "count": corners, "type": "VEC3",
                "min": [least(0), least(1), least(2)], "max": [most(0), most(1), most(2)]
            },
            { "bufferView": 1, "componentType": FLOAT, "count": corners, "type": "VEC3" },
            { "bufferView": 2, "componentType": UNSIGNED_INT, "count": 3 * facets, "type": "SCALAR" }
        ]
    })
}
