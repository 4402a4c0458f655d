// Tools as spheres; follows frame.wgsl and light.wgsl.

const AROUND: u32 = 40u;
const ALONG: u32 = 20u;

struct Ball {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
    @location(2) @interpolate(flat) number: u32,
}

@vertex
fn ball_vertex(@builtin(vertex_index) vertex_index: u32, @builtin(instance_index) number: u32) -> Ball {
    let corner = vertex_index % 6u;
    let patch_index = vertex_index / 6u;
    let right = u32(corner == 1u || corner == 2u || corner == 4u);
    let upper = u32(corner == 2u || corner == 4u || corner == 5u);
    let turn = f32((patch_index % AROUND + right) % AROUND) / f32(AROUND) * 6.2831853;
    let fall = (1.0 - f32(patch_index / AROUND + upper) / f32(ALONG)) * 3.14159265;
    let tool = frame.tool[number];
    var ball: Ball;
    ball.normal = vec3<f32>(sin(fall) * cos(turn), sin(fall) * sin(turn), cos(fall));
    ball.position_m = tool.centre_m + tool.radius_m * ball.normal;
    ball.clip = frame.clip_from_room * vec4<f32>(ball.position_m, 1.0);
    ball.number = number;
    return ball;
}

@fragment
fn ball_fragment(ball: Ball) -> @location(0) vec4<f32> {
    let tool = frame.tool[ball.number];
    let normal = normalize(ball.normal);
    let view = normalize(frame.camera_m - ball.position_m);
    let facing = clamp(dot(normal, view), 0.0, 1.0);
    var matter: Matter;
    matter.position_m = ball.position_m;
    matter.normal = normal;
    matter.film_normal = normal;
    matter.albedo = tool.colour * 0.62 + 0.03;
    matter.film = 1.5;
    matter.blur = 0.10;
    matter.openness = 0.75 + 0.25 * normal.z;
    matter.key = past_pot(ball.position_m + normal * 0.002);
    // light through the body of the ball, and a ring while it touches
    let glow = tool.colour * (0.08 + 0.25 * (1.0 - facing) * (1.0 - facing));
    let ring = smoothstep(0.62, 0.40, facing) * tool.touching;
    let radiance = shaded(matter) + glow + (tool.colour * 1.6 + 0.15) * ring;
    return pixel_from(radiance);
}
