// Writes what the vertex stage computes for every vertex of a skin into one pixel each; follows transform.wgsl.

struct Probed {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) position_m: vec3<f32>,
    @location(1) @interpolate(flat) normal: vec3<f32>,
}

struct Pixel {
    // the bits of f32: not every WebGL2 can draw into a float texture
    @location(0) position_m: vec4<u32>,
    @location(1) normal: vec4<u32>,
}

@vertex
fn probe_vertex(@builtin(vertex_index) vertex_index: u32) -> Probed {
    let at = mesh_element(skin, vertex_index);
    let element = element_at(skin, radii, at.x, at.y);
    let pixel = vec2<f32>(f32(at.y) + 0.5, f32(at.x) + 0.5) / vec2<f32>(f32(skin.rows), f32(skin.columns));
    var probed: Probed;
    probed.clip = vec4<f32>(2.0 * pixel.x - 1.0, 1.0 - 2.0 * pixel.y, 0.5, 1.0);
    probed.position_m = element.position_m;
    probed.normal = element.normal;
    return probed;
}

@fragment
fn probe_fragment(probed: Probed) -> Pixel {
    var pixel: Pixel;
    pixel.position_m = bitcast<vec4<u32>>(vec4<f32>(probed.position_m, 1.0));
    pixel.normal = bitcast<vec4<u32>>(vec4<f32>(probed.normal, 1.0));
    return pixel;
}
