// Wheel head, splash pan and backdrop; follows frame.wgsl, light.wgsl and body.wgsl.

const HEAD_RADIUS_M: f32 = 0.165;
const PLASTIC: vec3<f32> = vec3<f32>(0.046, 0.057, 0.063);
const AROUND: u32 = 128u;

struct Lathe {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
}

// Radius and height of both edges of a strip of the profile, from the axis outwards, m: three strips are the head, six
// the pan.
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
    return lathe;
}

// Distance in metres that a pixel covers here, for fading what is finer.
fn pixel_size(position_m: vec3<f32>) -> f32 {
    return length(fwidth(position_m.xy));
}

// How thickly slip lies on the head, 0 to 1: a puddle at the foot, and rings thrown off it that thin out.
fn smudge(at: vec2<f32>) -> f32 {
    let away = length(at);
    let gap = away - frame.foot_m;
    let turn = atan2(at.y, at.x);
    let uneven = 0.45 * sin(turn * 2.0 + 0.6)
        + 0.35 * sin(turn * 3.0 - away * 25.0)
        + 0.20 * sin(turn * 7.0 + away * 60.0);
    let puddle = 1.0 - smoothstep(0.002, 0.009 + 0.005 * uneven, gap);
    let rings = 0.5 + 0.5 * sin(gap * 780.0 + 2.2 * uneven);
    let thrown = exp(-max(gap, 0.0) / 0.024) * (0.30 + 0.22 * uneven) * (0.45 + 0.55 * rings);
    return clamp(0.80 * puddle + thrown, 0.0, 1.0);
}

// Mirror image of the pot's outline in the head: share of the way that clay covers.
fn mirrored_pot(position_m: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    var covered = 0.0;
    var height = 0.0;
    for (var at = 0u; at < OUTLINE; at++) {
        let rise = outline_height(at) - position_m.z;
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

    // turned grooves every 12.5 mm, and finer tool marks between them
    let phase = away / 0.0125;
    let nearest = (fract(phase + 0.5) - 0.5) * 0.0125;
    let shown = 1.0 - smoothstep(0.0005, 0.0025, fine);
    let groove = exp(-nearest * nearest / (2.0 * 0.0006 * 0.0006)) * shown;
    let turned = sin(away * 6.2831853 / 0.0017) * (1.0 - smoothstep(0.0003, 0.0010, fine));
    let lean = 0.035 * turned - 0.55 * groove * nearest / 0.0006;
    var normal = flat_normal;
    if top {
        normal = normalize(flat_normal - vec3<f32>(outwards * lean, 0.0));
    }

    // two bat pins and a chalk line tell that the head turns
    let pin_radius = 0.127;
    let pin = min(length(at - vec2<f32>(pin_radius, 0.0)), length(at + vec2<f32>(pin_radius, 0.0)));
    let brass = 1.0 - smoothstep(0.0045, 0.0045 + fine + 0.0002, pin);
    let recess = (1.0 - smoothstep(0.0045, 0.0075, pin)) * (1.0 - brass);
    // the line's far half is shorter, so that no half turn looks like none
    let signed = dot(at, vec2<f32>(0.5, 0.8660254));
    let along = select(-signed - 0.022, signed, signed > 0.0);
    let beside = abs(dot(at, vec2<f32>(-0.8660254, 0.5)));
    let grainy = 0.78 + 0.22 * sin(beside * 3900.0 + 2.0 * sin(along * 260.0));
    let chalk = (1.0 - smoothstep(0.0014, 0.0024 + fine, beside)) * smoothstep(0.092, 0.097, along)
        * (1.0 - smoothstep(0.150, 0.156, abs(signed))) * grainy;
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
        // turned metal glints where its rings run across the line between light and eye
        let halfway = normalize(normalize(frame.camera_m - position_m) + KEY);
        let across = dot(vec3<f32>(-outwards.y, outwards.x, 0.0), halfway);
        let glint = fifth(fifth(fifth(1.0 - across * across)));
        radiance += 0.075 * KEY_LIGHT * glint * matter.key * (1.0 - slip) * (1.0 - 0.7 * chalk);
        let view = normalize(frame.camera_m - position_m);
        let mirrored = reflect(-view, normalize(mix(normal, flat_normal, 0.75)));
        let image = mirrored_pot(position_m, mirrored);
        let grazing = 0.045 + 0.5 * fifth(1.0 - clamp(view.z, 0.0, 1.0));
        let clay_light = WET_CLAY * (0.55 + 0.35 * clamp(-dot(mirrored.xy, KEY.xy), -1.0, 1.0));
        let fading = exp(-image.y / 0.09);
        radiance = mix(radiance, clay_light, image.x * grazing * 2.2 * fading * (1.0 - 0.5 * slip));
    }
    return radiance;
}

// Dull plastic, lit without reflections: it covers much of the picture and should not call for attention.
fn splash_pan(position_m: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let away = length(position_m.xy);
    // deep between head and wall of the pan
    let depth = clamp(-position_m.z / 0.04, 0.0, 1.0);
    let under = smoothstep(HEAD_RADIUS_M - 0.01, HEAD_RADIUS_M + 0.06, away);
    let openness = mix(1.0, 0.25 + 0.5 * under, depth);
    let key = max((dot(normal, KEY) + 0.22) / 1.22, 0.0) * past_pot(position_m) * mix(1.0, under, depth);
    let strip = max(dot(normal, STRIP), 0.0);
    let falling = KEY_LIGHT * key + STRIP_LIGHT * strip * openness + mix(GROUND, SKY, 0.5 + 0.5 * normal.z) * openness;
    let view = normalize(frame.camera_m - position_m);
    let sheen = fifth(fifth(max(dot(normal, normalize(view + KEY)), 0.0)));
    return PLASTIC * falling + KEY_LIGHT * 0.03 * sheen * key;
}

@fragment
fn head_fragment(lathe: Lathe) -> @location(0) vec4<f32> {
    return pixel_from(wheel_head(lathe.position_m, normalize(lathe.normal)));
}

@fragment
fn pan_fragment(lathe: Lathe) -> @location(0) vec4<f32> {
    return pixel_from(splash_pan(lathe.position_m, normalize(lathe.normal)));
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
    let aside = (at - vec2<f32>(-0.35, 0.30)) * vec2<f32>(0.60, 0.85);
    let pool = exp(-dot(aside, aside));
    let lower = smoothstep(0.35, -0.9, at.y);
    var radiance = mix(vec3<f32>(0.060, 0.060, 0.064), vec3<f32>(0.285, 0.255, 0.222), pool);
    radiance = mix(radiance, vec3<f32>(0.045, 0.040, 0.038), 0.8 * lower);
    // about a step of noise, against bands in what changes so slowly
    let grain = fract(52.9829189 * fract(dot(backdrop.clip.xy, vec2<f32>(0.06711056, 0.00583715)))) - 0.5;
    return pixel_from(radiance * (1.0 + 0.03 * grain));
}
