// What every drawing shader knows of the frame: camera, wheel, the pot's outline, the tools; and how radiance becomes
// a pixel. Room frame, metres.

struct Tool {
    centre_m: vec3<f32>,
    radius_m: f32,
    colour: vec3<f32>,
    // 1 while it touches; below 0, minus the way from its centre to the nearest clay, m; 0 when that is not known
    touching: f32,
    // a unit quaternion
    turn: vec4<f32>,
}

// A glaze is a layer of glass: `absorbed` and `opacity` are those of its usual thickness.
struct Finish {
    body: vec3<f32>,
    is_fired: f32,
    absorbed: vec3<f32>,
    opacity: f32,
    scattered: vec3<f32>,
    gloss: f32,
}

struct Frame {
    clip_from_room: mat4x4<f32>,
    camera_m: vec3<f32>,
    wetness: f32,
    // cosine and sine of the wheel's angle
    wheel: vec2<f32>,
    // 1 when the shader has to apply the sRGB curve itself
    encodes: f32,
    aspect: f32,
    pot_height_m: f32,
    rim_inner_m: f32,
    foot_m: f32,
    tools: u32,
    // mean outer radius at eight heights above the foot, the last at the rim
    outline: array<vec4<f32>, 2>,
    finish: Finish,
    tool: array<Tool, 64>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// how much water is on the wall: across, from foot to rim, and down, round the pot
@group(0) @binding(1) var water: texture_2d<f32>;
@group(0) @binding(2) var water_filter: sampler;

const EXPOSURE: f32 = 0.58;
const OUTLINE: u32 = 8u;

fn room_from_pot(point: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        point.x * frame.wheel.x - point.y * frame.wheel.y,
        point.x * frame.wheel.y + point.y * frame.wheel.x,
        point.z,
    );
}

fn outline_height(step: u32) -> f32 {
    return f32(step + 1u) / f32(OUTLINE) * frame.pot_height_m;
}

fn outline_radius(step: u32) -> f32 {
    return frame.outline[step / 4u][step % 4u];
}

// Filmic curve of Narkowicz (2015), an approximation of ACES.
fn filmic(radiance: vec3<f32>) -> vec3<f32> {
    let exposed = EXPOSURE * radiance;
    let shown = exposed * (2.51 * exposed + 0.03) / (exposed * (2.43 * exposed + 0.59) + 0.14);
    return clamp(shown, vec3<f32>(0.0), vec3<f32>(1.0));
}

fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(linear, vec3<f32>(0.0031308)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear < vec3<f32>(0.0031308));
}

// Radiance to a pixel of the target.
fn pixel_from(radiance: vec3<f32>) -> vec4<f32> {
    var shown = filmic(radiance);
    if frame.encodes > 0.5 {
        shown = srgb_from_linear(shown);
    }
    return vec4<f32>(shown, 1.0);
}
