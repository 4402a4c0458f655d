// The studio's light and how a surface answers it; follows frame.wgsl.
//
// A warm key window left in front, a cool strip right behind, a pale ceiling and a dark floor. All in the room frame.

const KEY: vec3<f32> = vec3<f32>(-0.604, -0.468, 0.645);
const KEY_LEVEL: vec2<f32> = vec2<f32>(-0.7905, -0.6125);
const KEY_LIGHT: vec3<f32> = vec3<f32>(2.30, 2.00, 1.66);
const STRIP: vec3<f32> = vec3<f32>(0.725, 0.575, 0.379);
const STRIP_LEVEL: vec2<f32> = vec2<f32>(0.7835, 0.6214);
const STRIP_LIGHT: vec3<f32> = vec3<f32>(0.75, 0.95, 1.20);
const SKY: vec3<f32> = vec3<f32>(0.40, 0.43, 0.48);
const GROUND: vec3<f32> = vec3<f32>(0.13, 0.10, 0.08);

struct Matter {
    position_m: vec3<f32>,
    normal: vec3<f32>,
    // the smoother face of the water over it
    film_normal: vec3<f32>,
    albedo: vec3<f32>,
    // 0 dry, 1 under a film of water
    film: f32,
    // spread of the film's reflections, as the tangent of an angle
    blur: f32,
    // share of the surroundings that reaches the point
    openness: f32,
    // share of the key light that reaches it
    key: f32,
}

// A tall window or reflector that stands on the floor, seen from the wheel: how much of it lies in a direction.
//
// It reaches below the horizon, since upright walls seen from above mirror what is low.
fn upright(direction: vec3<f32>, towards: vec2<f32>, half_width: f32, blur: f32) -> f32 {
    let level = direction.xy * inverseSqrt(max(dot(direction.xy, direction.xy), 1e-4));
    let aside = abs(level.x * towards.y - level.y * towards.x);
    let edge = 0.15 * half_width + blur;
    let across = 1.0 - smoothstep(half_width - edge, half_width + edge, aside);
    let along = smoothstep(-0.80 - blur, -0.10, direction.z) * (1.0 - smoothstep(0.55, 0.95, direction.z));
    // what is spread wider is fainter
    return across * along * half_width / (half_width + 0.6 * blur) * step(0.0, dot(level, towards));
}

// Radiance that arrives from a direction.
fn studio(direction: vec3<f32>, blur: f32) -> vec3<f32> {
    let horizon = smoothstep(-0.35 - blur, 0.55 + blur, direction.z);
    return mix(GROUND * 0.7, SKY * 0.85, horizon)
        + KEY_LIGHT * 6.5 * upright(direction, KEY_LEVEL, 0.17, blur)
        + STRIP_LIGHT * 2.6 * upright(direction, STRIP_LEVEL, 0.12, blur);
}

// Share of the surroundings that the tools leave open, and of the key light that passes them.
fn past_tools(position_m: vec3<f32>, normal: vec3<f32>) -> vec2<f32> {
    var open = vec2<f32>(1.0);
    for (var at = 0u; at < frame.tools; at++) {
        let tool = frame.tool[at];
        let towards = tool.centre_m - position_m;
        let square = dot(towards, towards);
        let size = tool.radius_m * tool.radius_m / max(square, tool.radius_m * tool.radius_m);
        let facing = dot(normal, towards) * inverseSqrt(square);
        open.x *= 1.0 - 0.85 * size * clamp(0.65 * facing + 0.35, 0.0, 1.0);
        let along = dot(towards, KEY);
        let aside = sqrt(max(square - along * along, 0.0));
        let shade = 1.0 - smoothstep(tool.radius_m * 0.75, tool.radius_m * 1.2 + 0.12 * along, aside);
        open.y *= 1.0 - 0.8 * shade * step(0.0, along);
    }
    return open;
}

// Share of the key light that passes the pot's outline on its way to a point outside it.
fn past_pot(position_m: vec3<f32>) -> f32 {
    var open = 1.0;
    for (var at = 0u; at < OUTLINE; at++) {
        let rise = outline_height(at) - position_m.z;
        if rise > 0.0 {
            let aside = length(position_m.xy + KEY.xy * (rise / KEY.z)) - outline_radius(at);
            let blur = 0.003 + 0.15 * rise;
            open = min(open, smoothstep(-blur, blur, aside));
        }
    }
    return open;
}

fn fifth(value: f32) -> f32 {
    let square = value * value;
    return square * square * value;
}

// Radiance that leaves a surface towards the camera.
fn shaded(matter: Matter) -> vec3<f32> {
    let view = normalize(frame.camera_m - matter.position_m);
    let normal = matter.normal;
    let key = max((dot(normal, KEY) + 0.22) / 1.22, 0.0);
    let strip = max((dot(normal, STRIP) + 0.1) / 1.1, 0.0);
    let around = mix(GROUND, SKY, 0.5 + 0.5 * normal.z);
    // light that bounced off clay and wheel comes back warm into what is closed
    let bounced = matter.albedo * (1.0 - matter.openness) * 0.6;
    let falling = KEY_LIGHT * key * matter.key
        + STRIP_LIGHT * strip * strip * matter.openness
        + around * (matter.openness + bounced);
    let diffuse = matter.albedo * falling;

    // a slope may lean away from the eye where the coarser wall does not: turned back, or the film would blaze there
    let leaning = max(0.08 - dot(matter.film_normal, view), 0.0);
    let film_normal = normalize(matter.film_normal + leaning * view);
    let grazing = fifth(1.0 - clamp(dot(film_normal, view), 0.0, 1.0));
    let mirrored = reflect(-view, film_normal);
    let film = matter.film * (0.048 + 0.42 * grazing) * studio(mirrored, matter.blur);
    let halfway = normalize(view + KEY);
    let sheen = 0.05 * fifth(fifth(max(dot(normal, halfway), 0.0))) * KEY_LIGHT * matter.key;
    let seen = matter.openness * matter.openness * (0.35 + 0.65 * matter.key);
    return diffuse + (film + sheen) * seen;
}
