// Tools as spheres and as solids of flat facets; follows frame.wgsl and light.wgsl.

const AROUND: u32 = 40u;
const ALONG: u32 = 20u;

struct Body {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
    @location(2) @interpolate(flat) number: u32,
}

fn body_at(position_m: vec3<f32>, normal: vec3<f32>, number: u32) -> Body {
    var body: Body;
    body.position_m = position_m;
    body.normal = normal;
    body.clip = frame.clip_from_room * vec4<f32>(position_m, 1.0);
    body.number = number;
    return body;
}

fn turned(turn: vec4<f32>, vector: vec3<f32>) -> vec3<f32> {
    return vector + 2.0 * cross(turn.xyz, cross(turn.xyz, vector) + turn.w * vector);
}

@vertex
fn facet_vertex(
    @location(0) from_centre_m: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @builtin(instance_index) number: u32,
) -> Body {
    let tool = frame.tool[number];
    return body_at(tool.centre_m + turned(tool.turn, from_centre_m), turned(tool.turn, normal), number);
}

@vertex
fn ball_vertex(@builtin(vertex_index) vertex_index: u32, @builtin(instance_index) number: u32) -> Body {
    let corner = vertex_index % 6u;
    let patch_index = vertex_index / 6u;
    let right = u32(corner == 1u || corner == 2u || corner == 4u);
    let upper = u32(corner == 2u || corner == 4u || corner == 5u);
    let turn = f32((patch_index % AROUND + right) % AROUND) / f32(AROUND) * 6.2831853;
    let fall = (1.0 - f32(patch_index / AROUND + upper) / f32(ALONG)) * 3.14159265;
    let tool = frame.tool[number];
    let normal = vec3<f32>(sin(fall) * cos(turn), sin(fall) * sin(turn), cos(fall));
    return body_at(tool.centre_m + tool.radius_m * normal, normal, number);
}

// Light that a body sends back, and from within it `glow` of its own colour.
fn radiance_of(body: Body, normal: vec3<f32>, glow: f32) -> vec3<f32> {
    let tool = frame.tool[body.number];
    var matter: Matter;
    matter.position_m = body.position_m;
    matter.normal = normal;
    matter.film_normal = normal;
    matter.albedo = tool.colour * 0.62 + 0.03;
    matter.film = 1.5;
    matter.blur = 0.10;
    matter.openness = 0.75 + 0.25 * normal.z;
    matter.key = past_pot(body.position_m + normal * 0.002);
    return shaded(matter) + tool.colour * glow;
}

@fragment
fn ball_fragment(body: Body) -> @location(0) vec4<f32> {
    let tool = frame.tool[body.number];
    let normal = normalize(body.normal);
    let view = normalize(frame.camera_m - body.position_m);
    let facing = clamp(dot(normal, view), 0.0, 1.0);
    // light through the body of the ball, and a ring while it touches
    let glow = 0.08 + 0.25 * (1.0 - facing) * (1.0 - facing);
    let ring = smoothstep(0.62, 0.40, facing) * max(tool.touching, 0.0);
    return pixel_from(radiance_of(body, normal, glow) + (tool.colour * 1.6 + 0.15) * ring);
}

@fragment
fn facet_fragment(body: Body) -> @location(0) vec4<f32> {
    let tool = frame.tool[body.number];
    // a flat side has no rim to light up while it touches: all of it does
    return pixel_from(radiance_of(body, normalize(body.normal), 0.08 + 0.15 * max(tool.touching, 0.0)));
}
