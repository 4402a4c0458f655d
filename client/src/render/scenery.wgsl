// Wheel head, splash pan and backdrop; follows frame.wgsl, light.wgsl and body.wgsl.

const HEAD_RADIUS_M: f32 = 0.165;
const AROUND: u32 = 128u;
const STRIPS: u32 = 9u;

struct Lathe {
    @builtin(position) clip: vec4<f32>,
    @location(0) position_m: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // below 0.5 the wheel head, above it the pan
    @location(2) pan: f32,
}

// Radius and height of both edges of a strip of the profile, from the axis outwards, m.
fn strip_edges(strip: u32) -> vec4<f32> {
    switch strip {
        case 0u: { return vec4<f32>(0.0, 0.0, 0.1635, 0.0); }
        case 1u: { return vec4<f32>(0.1635, 0.0, 0.165, -0.0015); }
        case 2u: { return vec4<f32>(0.165, -0.0015, 0.165, -0.018); }
        case 3u: { return vec4<f32>(0.10, -0.040, 0.232, -0.040); }
        case 4u: { return vec4<f32>(0.232, -0.040, 0.246, -0.034); }
        case 5u: { return vec4<f32>(0.246, -0.034, 0.254, 0.006); }
        case 6u: { return vec4<f32>(0.254, 0.006, 0.257, 0.0085); }
        case 7u: { return vec4<f32>(0.257, 0.0085, 0.261, 0.006); }
        default: { return vec4<f32>(0.261, 0.006, 0.262, -0.050); }
    }
}

@vertex
fn lathe_vertex(@builtin(vertex_index) vertex_index: u32) -> Lathe {
    let corner = vertex_index % 6u;
    let patch_index = vertex_index / 6u;
    let right = u32(corner == 1u || corner == 2u || corner == 4u);
    let upper = corner == 2u || corner == 4u || corner == 5u;
    let strip = patch_index / AROUND;
    let turn = f32((patch_index % AROUND + right) % AROUND) / f32(AROUND) * 6.2831853;
    let circle = vec2<f32>(cos(turn), sin(turn));
    let edges = strip_edges(strip);
    let at = select(edges.xy, edges.zw, upper);
    let across = normalize(edges.zw - edges.xy);
    var lathe: Lathe;
    lathe.position_m = vec3<f32>(circle * at.x, at.y);
    lathe.normal = vec3<f32>(circle * -across.y, across.x);
    lathe.clip = frame.clip_from_room * vec4<f32>(lathe.position_m, 1.0);
    lathe.pan = select(0.0, 1.0, strip > 2u);
    return lathe;
}

// Distance in metres that a pixel covers here, for fading what is finer.
fn pixel_size(position_m: vec3<f32>) -> f32 {
    return length(fwidth(position_m.xy));
}

// Smudges of slip round the foot, thrown outwards.
fn smudge(at: vec2<f32>) -> f32 {
    let away = length(at);
    let turn = atan2(at.y, at.x);
    let wave = sin(turn * 3.0 + away * 60.0) * 0.5 + sin(turn * 7.0 - away * 95.0 + 1.7) * 0.3 + sin(turn * 17.0 + 0.6) * 0.2;
    let reach = frame.foot_m + 0.016 + 0.010 * wave;
    let puddle = 1.0 - smoothstep(reach - 0.004, reach + 0.003, away);
    let arms = smoothstep(0.55, 0.95, sin(turn * 5.0 + away * 70.0) * 0.6 + wave * 0.5)
        * (1.0 - smoothstep(frame.foot_m + 0.02, frame.foot_m + 0.075, away)) * 0.6;
    return max(puddle, arms);
}

// Mirror image of the pot's outline in the head: share of the way that clay covers.
fn mirrored_pot(position_m: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    var covered = 0.0;
    var height = 0.0;
    for (var at = 0u; at < OUTLINE; at++) {
        let rise = (f32(at) + 0.5) / f32(OUTLINE) * frame.pot_height_m - position_m.z;
        let aside = length(position_m.xy + direction.xy * (rise / max(direction.z, 0.05))) - outline_radius(at);
        let hit = 1.0 - smoothstep(-0.002 - 0.06 * rise, 0.002 + 0.06 * rise, aside);
        height = select(height, rise, hit > covered);
        covered = max(covered, hit);
    }
    return vec2<f32>(covered, height);
}

fn wheel_head(position_m: vec3<f32>, flat_normal: vec3<f32>) -> vec3<f32> {
    let away = length(position_m.xy);
    let outwards = position_m.xy / max(away, 1e-4);
    // the same point on the turning head
    let at = vec2<f32>(
        position_m.x * frame.wheel.x + position_m.y * frame.wheel.y,
        position_m.y * frame.wheel.x - position_m.x * frame.wheel.y,
    );
    let fine = pixel_size(position_m);
    let top = flat_normal.z > 0.9;

    // turned grooves every 12 mm, and finer tool marks between them
    let phase = away / 0.0125;
    let nearest = (fract(phase + 0.5) - 0.5) * 0.0125;
    let shown = 1.0 - smoothstep(0.0005, 0.0025, fine);
    let groove = exp(-nearest * nearest / (2.0 * 0.0006 * 0.0006)) * shown;
    let lean = -nearest / 0.0006 * groove * 0.55 + sin(away * 6.2831853 / 0.0017) * 0.035 * (1.0 - smoothstep(0.0003, 0.0010, fine));
    var normal = flat_normal;
    if top {
        normal = normalize(flat_normal - vec3<f32>(outwards * lean, 0.0));
    }

    // two bat pins and a chalk line tell that the head turns
    let pin_radius = 0.127;
    let pin = min(length(at - vec2<f32>(pin_radius, 0.0)), length(at + vec2<f32>(pin_radius, 0.0)));
    let brass = 1.0 - smoothstep(0.0045, 0.0045 + fine + 0.0002, pin);
    let recess = (1.0 - smoothstep(0.0045, 0.0075, pin)) * (1.0 - brass);
    let along = dot(at, vec2<f32>(0.5, 0.8660254));
    let beside = abs(dot(at, vec2<f32>(-0.8660254, 0.5)));
    let grainy = 0.65 + 0.35 * sin(along * 2100.0) * sin(beside * 3900.0 + along * 700.0);
    let chalk = (1.0 - smoothstep(0.0014, 0.0024 + fine, beside)) * smoothstep(0.092, 0.097, along)
        * (1.0 - smoothstep(0.150, 0.156, along)) * grainy;
    let slip = smudge(at) * select(0.0, 1.0, top);

    var albedo = vec3<f32>(0.040, 0.041, 0.045) * (1.0 - 0.55 * groove);
    albedo = mix(albedo, vec3<f32>(0.42, 0.27, 0.10), brass);
    albedo *= 1.0 - 0.6 * recess;
    albedo = mix(albedo, vec3<f32>(0.50, 0.48, 0.45), 0.75 * chalk);
    albedo = mix(albedo, mix(DRY_CLAY, WET_CLAY, frame.wetness) * 0.85, slip * 0.85);

    let tools = past_tools(position_m, normal);
    var matter: Matter;
    matter.position_m = position_m;
    matter.normal = normal;
    matter.film_normal = normalize(mix(normal, flat_normal, 0.4));
    matter.albedo = albedo;
    matter.film = mix(1.1, 0.7 + 0.5 * frame.wetness, slip);
    matter.blur = mix(0.30, 0.16, slip);
    // a wall of height h beside a floor hides half of 1 − d / √(d² + h²) of the sky
    let gap = max(away - frame.foot_m, 0.0);
    let wall = 1.0 - gap * inverseSqrt(gap * gap + frame.pot_height_m * frame.pot_height_m);
    let contact = exp(-gap / 0.006);
    matter.openness = tools.x * (1.0 - 0.62 * wall) * (1.0 - 0.55 * contact);
    matter.key = tools.y * past_pot(position_m) * (1.0 - 0.6 * contact);
    var radiance = shaded(matter);
    if top {
        let view = normalize(frame.camera_m - position_m);
        let mirrored = reflect(-view, normalize(mix(normal, flat_normal, 0.75)));
        let image = mirrored_pot(position_m, mirrored);
        let grazing = 0.045 + 0.5 * pow(1.0 - clamp(view.z, 0.0, 1.0), 4.0);
        let clay_light = WET_CLAY * (0.55 + 0.35 * clamp(-dot(mirrored.xy, KEY.xy), -1.0, 1.0));
        let fading = exp(-image.y / 0.09);
        radiance = mix(radiance, clay_light, image.x * grazing * 2.2 * fading * (1.0 - 0.5 * slip));
    }
    return radiance;
}

fn splash_pan(position_m: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let away = length(position_m.xy);
    let tools = past_tools(position_m, normal);
    var matter: Matter;
    matter.position_m = position_m;
    matter.normal = normal;
    matter.film_normal = normal;
    matter.albedo = vec3<f32>(0.085, 0.105, 0.115);
    matter.film = 0.9;
    matter.blur = 0.34;
    // deep between head and wall of the pan
    let depth = clamp(-position_m.z / 0.04, 0.0, 1.0);
    let under = smoothstep(HEAD_RADIUS_M - 0.01, HEAD_RADIUS_M + 0.06, away);
    matter.openness = tools.x * mix(1.0, 0.25 + 0.5 * under, depth);
    matter.key = tools.y * past_pot(position_m) * mix(1.0, under, depth);
    return shaded(matter);
}

@fragment
fn lathe_fragment(lathe: Lathe) -> @location(0) vec4<f32> {
    let normal = normalize(lathe.normal);
    var radiance: vec3<f32>;
    if lathe.pan < 0.5 {
        radiance = wheel_head(lathe.position_m, normal);
    } else {
        radiance = splash_pan(lathe.position_m, normal);
    }
    return pixel_from(radiance, lathe.clip.xy);
}

struct Backdrop {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn backdrop_vertex(@builtin(vertex_index) vertex_index: u32) -> Backdrop {
    let corner = vec2<f32>(f32(vertex_index & 1u), f32(vertex_index >> 1u)) * 4.0 - 1.0;
    return Backdrop(vec4<f32>(corner, 1.0, 1.0), corner);
}

@fragment
fn backdrop_fragment(backdrop: Backdrop) -> @location(0) vec4<f32> {
    let at = vec2<f32>(backdrop.at.x * frame.aspect, backdrop.at.y);
    // a pool of light on the wall behind the wheel, falling off to the corners
    let pool = exp(-dot((at - vec2<f32>(-0.35, 0.30)) * vec2<f32>(0.60, 0.85), (at - vec2<f32>(-0.35, 0.30)) * vec2<f32>(0.60, 0.85)));
    let lower = smoothstep(0.35, -0.9, at.y);
    var radiance = mix(vec3<f32>(0.050, 0.054, 0.062), vec3<f32>(0.235, 0.222, 0.205), pool);
    radiance = mix(radiance, vec3<f32>(0.050, 0.045, 0.042), 0.75 * lower);
    return pixel_from(radiance, backdrop.clip.xy);
}
