// How far a hollow wall gives way under the tools at it, and springs back: elements where they stand meanwhile; follows transform.wgsl.

// width: heights from foot to rim, height: angles round the pot; towards the axis in m, and its slopes in m/rad and m/m
@group(0) @binding(3) var deflection: texture_2d<f32>;

// Between four places, of a turn of the pot and a share of its height. WebGL2 does not filter numbers that are so exact.
fn deflection_at(turn: f32, up: f32) -> vec3<f32> {
    let size = vec2<i32>(textureDimensions(deflection));
    let row = up * f32(size.x - 1);
    let column = turn * f32(size.y);
    let low = clamp(i32(floor(row)), 0, size.x - 2);
    let left = i32(floor(column)) % size.y;
    let right = (left + 1) % size.y;
    let rise = row - f32(low);
    let before = mix(
        textureLoad(deflection, vec2<i32>(low, left), 0),
        textureLoad(deflection, vec2<i32>(low + 1, left), 0),
        rise,
    );
    let after = mix(
        textureLoad(deflection, vec2<i32>(low, right), 0),
        textureLoad(deflection, vec2<i32>(low + 1, right), 0),
        rise,
    );
    return mix(before, after, fract(column)).xyz;
}

fn deflected_element_at(on: Skin, grid: texture_2d<f32>, column: u32, row: u32) -> Element {
    if on.deflects == 0u {
        return element_at(on, grid, column, row);
    }
    let deflected = deflection_at(f32(column) / f32(on.columns), f32(row) / f32(on.rows - 1u));
    return moved_element_at(on, grid, column, row, -deflected);
}
