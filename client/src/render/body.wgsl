// The clay body, whichever part of the pot it is on; follows light.wgsl.

const WET_CLAY: vec3<f32> = vec3<f32>(0.285, 0.115, 0.066);
const DRY_CLAY: vec3<f32> = vec3<f32>(0.500, 0.285, 0.195);
const SLIP: vec3<f32> = vec3<f32>(0.37, 0.175, 0.108);

// Share of the surroundings seen from within the pot: the opening's solid angle shrinks with the depth.
fn opening(position_m: vec3<f32>) -> f32 {
    let depth = max(frame.pot_height_m - position_m.z, 0.0);
    let rim = frame.rim_inner_m;
    return rim * rim / (rim * rim + 0.8 * depth * depth) * mix(0.62, 1.0, smoothstep(0.0, 0.5, depth / rim) * 0.6);
}

// Share of the key light that falls through the rim onto a point within the pot.
fn through_rim(position_m: vec3<f32>) -> f32 {
    let rise = max(frame.pot_height_m - position_m.z, 0.0);
    let aside = length(position_m.xy + KEY.xy * (rise / KEY.z)) - frame.rim_inner_m;
    let blur = 0.002 + 0.10 * rise;
    return 1.0 - smoothstep(-blur, blur, aside);
}

// How thickly a glaze lies, 1 where nothing makes it run: it gathers in hollows, drains from ridges and from the rim,
// and is wiped off the foot.
fn glaze_thickness(position_m: vec3<f32>, groove: f32, streak: f32, inside: bool) -> f32 {
    let below_rim = frame.pot_height_m - position_m.z;
    let rim = 1.0 - 0.55 * exp(-below_rim / 0.004);
    let line_m = 0.004 + 0.0012 * streak;
    let foot = select(smoothstep(line_m, line_m + 0.0012, position_m.z), 1.0, inside);
    return (1.0 + 0.9 * groove + 0.10 * streak) * rim * foot;
}

// Fired clay, bare or under a glaze: what is scattered in the glass, what the body throws back, both dimmed by the way
// through it.
fn fired(position_m: vec3<f32>, groove: f32, streak: f32, inside: bool, matter: ptr<function, Matter>, bend: f32) {
    let finish = frame.finish;
    let thickness = glaze_thickness(position_m, groove, streak, inside);
    let body = finish.body * (1.0 + 0.05 * streak - 0.06 * groove);
    let covered = 1.0 - exp(-finish.opacity * thickness);
    (*matter).albedo = mix(body, finish.scattered, covered) * exp(-finish.absorbed * thickness);
    let glass = finish.gloss * smoothstep(0.0, 0.25, thickness);
    (*matter).film = (0.05 + glass) / (1.0 + 4.0 * bend * bend);
    (*matter).blur = mix(0.60, 0.045, min(glass, 1.0)) + bend;
}

// Where a person sees how far a tool is from the clay: a ring about the place that it would touch, wider than the tool by as much
// as it is far, and a seam round it while it touches. Colour, and how much of it.
fn tool_mark(position_m: vec3<f32>, pixel_m: f32) -> vec4<f32> {
    var mark = vec4<f32>(0.0);
    for (var at = 0u; at < frame.tools; at++) {
        let tool = frame.tool[at];
        if tool.touching == 0.0 {
            continue;
        }
        let away = length(tool.centre_m - position_m);
        var share = 0.0;
        if tool.touching > 0.0 {
            let beyond = away - tool.radius_m;
            share = 0.75 * (1.0 - smoothstep(0.0012, 0.0035 + pixel_m, beyond));
        } else {
            let nearest = -tool.touching;
            let gap = max(nearest - tool.radius_m, 0.0);
            let aside = sqrt(max(away * away - nearest * nearest, 0.0));
            let line = 0.0007 + 0.5 * pixel_m;
            let ring = 1.0 - smoothstep(line, 2.0 * line, abs(aside - (tool.radius_m + 0.002 + 0.5 * gap)));
            share = 0.8 * ring * (1.0 - smoothstep(0.03, 0.06, gap));
        }
        mark = select(mark, vec4<f32>(tool.colour, share), share > mark.w);
    }
    return mark;
}

// Share of its look that wet clay keeps when it has dried.
const DRIED: f32 = 0.30;

// Water on the wall where no map of it is at hand: on the rim, and pooled on the floor.
fn water_at_rim(position_m: vec3<f32>) -> f32 {
    let turn = atan2(position_m.y, position_m.x) - atan2(frame.wheel.y, frame.wheel.x);
    return textureSampleLevel(water, water_filter, vec2<f32>(1.0, turn / 6.2831853), 0.0).x;
}

// `hollow_mm` is positive in a groove, `streak` runs from −1 to 1, `damp` is the water on the clay, 0 to 1.
//
// Asks for the normals of neighbouring pixels: call it in uniform control flow.
fn clay(position_m: vec3<f32>, normal: vec3<f32>, hollow_mm: f32, streak: f32, damp: f32, inside: bool) -> vec3<f32> {
    // a bend within the pixel spreads what it mirrors, or thin crests would sparkle
    let bend = length(fwidth(normal));
    // at an outline, where a neighbour lies far behind, no more than from the farthest view, or a tool's mark would be seen there
    let pixel_m = min(length(fwidth(position_m)), 0.004);
    // it dries from the ridges down, so that its edge is ragged
    let wet = frame.wetness * mix(DRIED, 1.0, smoothstep(0.0, 1.0, damp + 0.10 * streak * (1.0 - damp)));
    let groove = clamp(hollow_mm * 2.2, -1.0, 1.0);
    var albedo = mix(DRY_CLAY, WET_CLAY, wet);
    // slip gathers where fingers left it; ridges rub paler
    albedo = mix(albedo, SLIP, clamp(0.12 + 0.12 * streak - 0.25 * groove, 0.0, 0.5));
    albedo *= 1.0 + 0.07 * streak;
    let tools = past_tools(position_m, normal);

    var matter: Matter;
    matter.position_m = position_m;
    matter.normal = normal;
    matter.film_normal = normalize(normal + vec3<f32>(0.0, 0.0, 0.015 * streak));
    matter.albedo = albedo;
    matter.film = wet * clamp(0.80 + 0.45 * streak + 0.25 * groove, 0.25, 1.3) + 0.06;
    matter.film *= (1.0 - 0.6 * max(-normal.z, 0.0)) / (1.0 + 4.0 * bend * bend);
    matter.blur = mix(0.55, 0.09, wet) + 0.05 * streak + bend;
    if frame.finish.is_fired > 0.5 {
        fired(position_m, groove, streak, inside, &matter, bend);
    }
    matter.openness = tools.x * (1.0 - 0.45 * max(groove, 0.0));
    matter.key = tools.y * (1.0 - 0.30 * max(groove, 0.0));
    if inside {
        matter.openness *= opening(position_m);
        matter.key *= through_rim(position_m);
    } else {
        // the wheel head takes half the sky from the foot and throws its shade back
        matter.openness *= 1.0 - 0.5 * exp(-position_m.z / 0.018);
    }
    let mark = tool_mark(position_m, pixel_m);
    return mix(shaded(matter), mark.xyz * 1.4 + 0.05, mark.w);
}
