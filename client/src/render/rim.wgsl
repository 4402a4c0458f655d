// The lip between two skins, the floor within, and the face where the pot is cut; follows transform.wgsl, deflection.wgsl, frame.wgsl, light.wgsl and body.wgsl.

@group(2) @binding(0) var<uniform> inner: Skin;
@group(2) @binding(1) var inner_radii: texture_2d<f32>;

// The lip is drawn as a low half ellipse over the flat rim of the model, so that light runs round its edge.
const LIP_STEPS: u32 = 8u;
const LIP_RISE: f32 = 0.16;

struct Lip {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
}

@vertex
fn lip_vertex(@builtin(vertex_index) vertex_index: u32) -> Lip {
    let corner = vertex_index % 6u;
    let patch_index = vertex_index / 6u;
    let right = u32(corner == 1u || corner == 2u || corner == 4u);
    let upper = u32(corner == 2u || corner == 4u || corner == 5u);
    let column = min((patch_index / LIP_STEPS + right) * skin.column_stride, skin.columns);
    let across = f32(patch_index % LIP_STEPS + upper) / f32(LIP_STEPS);
    let outer_edge = deflected_element_at(skin, radii, column, skin.rows - 1u);
    let inner_edge = deflected_element_at(inner, inner_radii, column * inner.columns / skin.columns, inner.rows - 1u);
    let angle = across * 2.0 * QUARTER_TURN;
    let half_m = 0.5 * length(outer_edge.position_m.xy - inner_edge.position_m.xy);
    let rise_m = 2.0 * LIP_RISE * half_m;
    let outwards = column_circle(skin.columns, column);
    var lip: Lip;
    lip.position_m = mix(outer_edge.position_m, inner_edge.position_m, 0.5 - 0.5 * cos(angle));
    lip.position_m.z += rise_m * sin(angle);
    lip.normal = normalize(vec3<f32>(outwards * cos(angle) * rise_m, sin(angle) * half_m));
    // the walls' own slopes at both edges
    lip.normal = normalize(mix(lip.normal, outer_edge.normal, pow(1.0 - across, 4.0)));
    lip.normal = normalize(mix(lip.normal, inner_edge.normal, pow(across, 4.0)));
    lip.position_m = room_from_pot(lip.position_m);
    lip.normal = room_from_pot(lip.normal);
    lip.clip = frame.clip_from_room * vec4<f32>(lip.position_m, 1.0);
    return lip;
}

@fragment
fn lip_fragment(lip: Lip) -> @location(0) vec4<f32> {
    let rub = -0.12;
    return pixel_from(clay(lip.position_m, normalize(lip.normal), rub, 0.1, water_at_rim(lip.position_m), false));
}

struct Floor {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
}

@vertex
fn floor_vertex(@builtin(vertex_index) vertex_index: u32) -> Floor {
    let corner = vertex_index % 3u;
    let column = min((vertex_index / 3u + corner / 2u) * skin.column_stride, skin.columns);
    var point = deflected_element_at(skin, radii, column, skin.first_row).position_m;
    if corner == 0u {
        point = vec3<f32>(0.0, 0.0, point.z);
    }
    var floor_point: Floor;
    floor_point.position_m = room_from_pot(point);
    floor_point.clip = frame.clip_from_room * vec4<f32>(floor_point.position_m, 1.0);
    return floor_point;
}

@fragment
fn floor_fragment(floor_point: Floor) -> @location(0) vec4<f32> {
    // the spiral that a finger leaves when it opens the clay
    let at = floor_point.position_m.xy;
    let away = length(at);
    let turned = atan2(at.y, at.x) - atan2(frame.wheel.y, frame.wheel.x);
    let wave = sin(away * TURN / 0.009 + turned);
    let fade = smoothstep(0.0, 0.008, away);
    let normal = normalize(vec3<f32>(-at / max(away, 1e-4) * wave * 0.16 * fade, 1.0));
    return pixel_from(clay(floor_point.position_m, normal, -0.1 * wave, 0.15 * wave, 1.0, true));
}

// A drawing's face and no lit one: told from clay in any light, radiance.
const FRESH: vec3<f32> = vec3<f32>(0.36, 0.29, 0.26);

// The face where the pot is cut along the column that the instance counts: wall and floor up to the rim, then the lip's half
// ellipse. A segment lies between two rows of the outer wall.
@vertex
fn section_vertex(@builtin(vertex_index) vertex_index: u32, @builtin(instance_index) instance: u32) -> Floor {
    let segments = (skin.rows - 2u) / skin.row_stride + 1u;
    let outer_column = instance % skin.columns;
    let inner_column = outer_column * inner.columns / skin.columns;
    let segment = vertex_index / 6u;
    let corner = vertex_index % 6u;
    let upper = u32(corner == 2u || corner == 4u || corner == 5u);
    let towards_axis = corner == 1u || corner == 2u || corner == 4u;
    let row = min((segment + upper) * skin.row_stride, skin.rows - 1u);
    let inner_row = row * (inner.rows - 1u) / (skin.rows - 1u);
    let is_floor = (segment + 1u) * skin.row_stride <= inner.first_row;
    let outer_edge = deflected_element_at(skin, radii, outer_column, row);
    let inner_edge = deflected_element_at(inner, inner_radii, inner_column, inner_row);
    var cut: Floor;
    cut.position_m = outer_edge.position_m;
    if towards_axis {
        cut.position_m = inner_edge.position_m;
        cut.position_m.z = outer_edge.position_m.z;
        if is_floor {
            cut.position_m = vec3<f32>(0.0, 0.0, outer_edge.position_m.z);
        }
    }
    if segment >= segments {
        // a fan under the lip, whose middle is that of the rim
        let step = segment - segments + u32(corner == 1u);
        let angle = 2.0 * QUARTER_TURN * f32(step) / f32(LIP_STEPS);
        let half_m = 0.5 * length(outer_edge.position_m.xy - inner_edge.position_m.xy);
        let share = select(0.5 - 0.5 * cos(angle), 0.5, corner > 1u);
        cut.position_m = mix(outer_edge.position_m, inner_edge.position_m, share);
        cut.position_m.z += select(2.0 * LIP_RISE * half_m * sin(angle), 0.0, corner > 1u);
    }
    cut.position_m = room_from_pot(cut.position_m);
    cut.clip = frame.clip_from_room * vec4<f32>(cut.position_m, 1.0);
    return cut;
}

@fragment
fn section_fragment(cut: Floor) -> @location(0) vec4<f32> {
    // strokes of the wire, two millimetres apart
    let stroke = 0.5 + 0.5 * sin((cut.position_m.z + 0.3 * length(cut.position_m.xy)) * TURN / 0.002);
    return pixel_from(FRESH * (0.85 + 0.15 * stroke));
}
