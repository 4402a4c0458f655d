// The studio's light and how a surface answers it; follows frame.wgsl.
//
// A warm key window left in front, a cool strip right behind, a pale ceiling and a dark floor. All in the room frame.

const KEY: vec3<f32> = vec3<f32>(-0.604, -0.468, 0.645);
const KEY_RIGHT: vec3<f32> = vec3<f32>(0.6125, -0.7905, 0.0);
const KEY_UP: vec3<f32> = vec3<f32>(0.5099, 0.3951, 0.7641);
const KEY_LIGHT: vec3<f32> = vec3<f32>(2.75, 2.45, 2.10);
const STRIP: vec3<f32> = vec3<f32>(0.725, 0.575, 0.379);
const STRIP_LIGHT: vec3<f32> = vec3<f32>(0.75, 0.95, 1.20);
const SKY: vec3<f32> = vec3<f32>(0.50, 0.53, 0.58);
const GROUND: vec3<f32> = vec3<f32>(0.17, 0.13, 0.10);

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

fn soft_box(direction: vec3<f32>, blur: f32) -> f32 {
    let ahead = dot(direction, KEY);
    let across = vec2<f32>(dot(direction, KEY_RIGHT), dot(direction, KEY_UP)) / max(ahead, 0.05);
    let half_size = vec2<f32>(0.26, 0.52);
    let edge = half_size * 0.15 + blur;
    let inside = 1.0 - smoothstep(half_size - edge, half_size + edge, abs(across));
    // what is spread wider is fainter
    let spread = half_size / (half_size + 0.6 * vec2<f32>(blur));
    return inside.x * inside.y * spread.x * spread.y * step(0.0, ahead);
}

// Radiance that arrives from a direction.
fn studio(direction: vec3<f32>, blur: f32) -> vec3<f32> {
    let horizon = smoothstep(-0.35 - blur, 0.55 + blur, direction.z);
    let strip = smoothstep(0.90 - 0.25 * blur, 1.0, dot(direction, STRIP) + 0.04);
    return mix(GROUND * 0.7, SKY * 0.85, horizon) + KEY_LIGHT * 3.2 * soft_box(direction, blur) + STRIP_LIGHT * 2.2 * strip;
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
        let rise = (f32(at) + 0.5) / f32(OUTLINE) * frame.pot_height_m - position_m.z;
        if rise > 0.0 {
            let aside = length(position_m.xy + KEY.xy * (rise / KEY.z)) - outline_radius(at);
            let blur = 0.0025 + 0.11 * rise;
            open = min(open, smoothstep(-blur, blur, aside));
        }
    }
    return open;
}

// Radiance that leaves a surface towards the camera.
fn shaded(matter: Matter) -> vec3<f32> {
    let view = normalize(frame.camera_m - matter.position_m);
    let normal = matter.normal;
    let key = max((dot(normal, KEY) + 0.22) / 1.22, 0.0);
    let strip = max((dot(normal, STRIP) + 0.1) / 1.1, 0.0);
    let around = mix(GROUND, SKY, 0.5 + 0.5 * normal.z);
    // light that bounced off clay and wheel comes back warm into what is closed
    let bounced = matter.albedo * (1.0 - matter.openness) * 0.35;
    let falling = KEY_LIGHT * key * matter.key
        + STRIP_LIGHT * strip * strip * matter.openness
        + around * (matter.openness + bounced);
    let diffuse = matter.albedo * falling;

    let facing = clamp(dot(matter.film_normal, view), 0.0, 1.0);
    let grazing = pow(1.0 - facing, 5.0);
    let mirrored = reflect(-view, matter.film_normal);
    let film = matter.film * (0.028 + 0.55 * grazing) * studio(mirrored, matter.blur);
    let halfway = normalize(view + KEY);
    let sheen = 0.05 * pow(max(dot(normal, halfway), 0.0), 14.0) * KEY_LIGHT * matter.key;
    let seen = matter.openness * matter.openness * (0.35 + 0.65 * matter.key);
    return diffuse + (film + sheen) * seen;
}
