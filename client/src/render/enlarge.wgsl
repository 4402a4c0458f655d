// A smaller picture over the whole of a larger one.

@group(0) @binding(0) var smaller: texture_2d<f32>;
@group(0) @binding(1) var between: sampler;

struct Sheet {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn sheet_vertex(@builtin(vertex_index) vertex_index: u32) -> Sheet {
    let corner = vec2<f32>(f32(vertex_index & 1u), f32(vertex_index >> 1u)) * 2.0;
    return Sheet(vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0), vec2<f32>(corner.x, 1.0 - corner.y));
}

@fragment
fn sheet_fragment(sheet: Sheet) -> @location(0) vec4<f32> {
    return textureSample(smaller, between, sheet.at);
}
