// The relief map: what the light needs to know of every element, at the full resolution of the grid, whatever the
// stride of the mesh; follows transform.wgsl. Drawn again only where radii changed.
//
// Channels: dr/dθ (m/rad), dr/dz, hollow (how far the element lies below its neighbourhood, mm), streak (−1 to 1).

@vertex
fn relief_vertex(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(vertex_index & 1u), f32(vertex_index >> 1u));
    return vec4<f32>(corner * 4.0 - 1.0, 0.5, 1.0);
}

fn scatter(cell: vec2<u32>) -> f32 {
    var bits = (cell.x * 0x9E3779B1u) ^ (cell.y * 0x85EBCA77u);
    bits = (bits ^ (bits >> 15u)) * 0x2C1B3C6Du;
    bits = (bits ^ (bits >> 12u)) * 0x297A2D39u;
    bits = bits ^ (bits >> 15u);
    return f32(bits & 0xFFFFu) / 32767.5 - 1.0;
}

// Value noise whose first coordinate closes after `around` cells.
fn ring_noise(at: vec2<f32>, around: u32, layer: u32) -> f32 {
    let cell = vec2<u32>(floor(at));
    let part = fract(at);
    let eased = part * part * (3.0 - 2.0 * part);
    let left = cell.x % around;
    let right = (cell.x + 1u) % around;
    let low = cell.y + layer * 7919u;
    return mix(
        mix(scatter(vec2<u32>(left, low)), scatter(vec2<u32>(right, low)), eased.x),
        mix(scatter(vec2<u32>(left, low + 1u)), scatter(vec2<u32>(right, low + 1u)), eased.x),
        eased.y,
    );
}

// Traces of fingers and slip: long round the pot, thin along it.
fn streak(turn: f32, z_m: f32) -> f32 {
    let broad = ring_noise(vec2<f32>(turn * 5.0, z_m * 90.0 + 2.0 * turn * (1.0 - turn)), 5u, 0u);
    let fine = ring_noise(vec2<f32>(turn * 11.0, z_m * 420.0), 11u, 1u);
    let hair = ring_noise(vec2<f32>(turn * 29.0, z_m * 1300.0), 29u, 2u);
    return 0.4 * broad + 0.35 * fine + 0.25 * hair;
}

@fragment
fn relief_fragment(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let row = u32(pixel.x);
    let column = u32(pixel.y);
    let slopes = slopes_at(skin, radii, column, row);
    let here = radius_at(radii, column, row);
    var around = 0.0;
    for (var ring = 1u; ring <= 2u; ring++) {
        let rows = max(skin.reach_rows * ring / 2u, 1u);
        let columns = max(skin.reach_columns * ring / 2u, 1u);
        let low = u32(max(i32(row) - i32(rows), 0));
        let high = min(row + rows, skin.rows - 1u);
        let left = (column + skin.columns - columns) % skin.columns;
        let right = (column + columns) % skin.columns;
        around += radius_at(radii, column, low) + radius_at(radii, column, high);
        around += 0.5 * (radius_at(radii, left, row) + radius_at(radii, right, row));
        around += 0.25 * (radius_at(radii, left, low) + radius_at(radii, left, high));
        around += 0.25 * (radius_at(radii, right, low) + radius_at(radii, right, high));
    }
    let hollow_mm = (around / 8.0 - here) * 1000.0;
    return vec4<f32>(slopes, hollow_mm, streak(f32(column) / f32(skin.columns), f32(row) * skin.row_height_m));
}
