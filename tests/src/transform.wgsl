// Draws vertices that come transformed: one light from the camera's left, one colour.

@group(0) @binding(0) var<uniform> clip_from_pot: mat4x4<f32>;

struct Shaded {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
}

@vertex
fn vertex(@location(0) position_m: vec3<f32>, @location(1) normal: vec3<f32>) -> Shaded {
    return Shaded(clip_from_pot * vec4(position_m, 1.0), normal);
}

@fragment
fn fragment(shaded: Shaded) -> @location(0) vec4<f32> {
    let light = max(dot(normalize(shaded.normal), normalize(vec3(-0.5, -0.7, 0.5))), 0.0);
    return vec4(vec3(0.60, 0.30, 0.17) * (0.2 + 0.8 * light), 1.0);
}
