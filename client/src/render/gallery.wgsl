// Many wheels at once: each instance is a wheel with its pot, in a part of the picture of its own; follows transform.wgsl, frame.wgsl,
// light.wgsl and body.wgsl. `skin` is the inner wall, and its first column how far behind the outer wall's its radii begin; the outer one has no
// inset.

struct Place {
    // middle of its part of the picture and half the part's size, clip space
    middle: vec2<f32>,
    half: vec2<f32>,
    // cosine and sine of the wheel's angle
    wheel: vec2<f32>,
    row_height_m: f32,
    padding: f32,
}

struct Gallery {
    place: array<Place, 256>,
}

@group(2) @binding(0) var<uniform> gallery: Gallery;

// Steps of the profile on the wheel head, before those of the pot.
const HEAD_STEPS: u32 = 4u;

struct Wheel {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
    // on the turning wheel, m
    @location(2) @interpolate(perspective, centroid) at: vec2<f32>,
    // height of the rim, and radius of the foot, m
    @location(3) @interpolate(flat) size_m: vec2<f32>,
    // 0 wheel head, 1 outer wall, 2 inner wall and floor
    @location(4) @interpolate(perspective, centroid) what: f32,
}

fn turned_by(point: vec3<f32>, wheel: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(point.x * wheel.x - point.y * wheel.y, point.x * wheel.y + point.y * wheel.x, point.z);
}

fn clip_in(place: Place, position_m: vec3<f32>) -> vec4<f32> {
    let clip = frame.clip_from_room * vec4<f32>(position_m, 1.0);
    return vec4<f32>(clip.xy * place.half + place.middle * clip.w, clip.zw);
}

// Radius, height, and the normal's share outwards and upwards, of a step on the wheel head.
fn head_step(step: u32) -> vec4<f32> {
    switch step {
        case 0u: { return vec4<f32>(0.165, -0.018, 1.0, 0.0); }
        case 1u: { return vec4<f32>(0.165, -0.0015, 1.0, 0.0); }
        case 2u: { return vec4<f32>(0.1635, 0.0, 0.0, 1.0); }
        default: { return vec4<f32>(0.0, 0.0, 0.0, 1.0); }
    }
}

@vertex
fn wheel_vertex(@builtin(vertex_index) vertex_index: u32, @builtin(instance_index) instance: u32) -> Wheel {
    let place = gallery.place[instance];
    var outer = skin;
    outer.first_column = instance * (skin.columns + skin.first_column);
    outer.row_height_m = place.row_height_m;
    var inner = outer;
    inner.first_column += skin.first_column;
    outer.inset_m = 0.0;
    outer.facing = 1.0;
    let steps = HEAD_STEPS + 2u * skin.rows - skin.first_row + 1u;
    let column = vertex_index / steps;
    var step = vertex_index % steps;
    let circle = column_circle(skin.columns, column);
    var point = vec3<f32>(0.0);
    var normal = vec3<f32>(0.0, 0.0, 1.0);
    var wheel: Wheel;
    if step < HEAD_STEPS {
        let head = head_step(step);
        point = vec3<f32>(circle * head.x, head.y);
        normal = vec3<f32>(circle * head.z, head.w);
        wheel.what = 0.0;
    } else if step < HEAD_STEPS + skin.rows {
        let element = element_at(outer, radii, column, step - HEAD_STEPS);
        point = element.position_m;
        normal = element.normal;
        wheel.what = 1.0;
    } else {
        wheel.what = 2.0;
        // from the rim down, and the middle of the floor at last
        let down = step - HEAD_STEPS - skin.rows;
        let row = max(skin.rows - 1u - min(down, skin.rows - 1u), skin.first_row);
        let element = element_at(inner, radii, column, row);
        point = element.position_m;
        normal = element.normal;
        if step + 1u == steps {
            point = vec3<f32>(0.0, 0.0, point.z);
            normal = vec3<f32>(0.0, 0.0, 1.0);
        }
    }
    wheel.at = point.xy;
    wheel.position_m = turned_by(point, place.wheel);
    wheel.normal = turned_by(normal, place.wheel);
    wheel.size_m = vec2<f32>(
        place.row_height_m * f32(skin.rows - 1u),
        radius_at(radii, outer.first_column, 0u),
    );
    wheel.clip = clip_in(place, wheel.position_m);
    return wheel;
}

@fragment
fn wheel_fragment(wheel: Wheel) -> @location(0) vec4<f32> {
    let normal = normalize(wheel.normal);
    let bend = length(fwidth(normal));
    var matter: Matter;
    matter.position_m = wheel.position_m;
    matter.normal = normal;
    matter.film_normal = normal;
    matter.openness = 1.0;
    matter.key = 1.0;
    if wheel.what < 0.5 {
        // dark, with a chalk line whose far half is shorter
        let signed = dot(wheel.at, vec2<f32>(0.5, 0.8660254));
        let along = select(-signed - 0.022, signed, signed > 0.0);
        let beside = abs(dot(wheel.at, vec2<f32>(-0.8660254, 0.5)));
        let chalk = (1.0 - smoothstep(0.003, 0.006, beside)) * smoothstep(0.09, 0.097, along)
            * (1.0 - smoothstep(0.150, 0.156, abs(signed)));
        matter.albedo = mix(vec3<f32>(0.050, 0.051, 0.055), vec3<f32>(0.55, 0.53, 0.50), chalk);
        matter.film = 0.6;
        matter.blur = 0.4;
        let gap = max(length(wheel.at) - wheel.size_m.y, 0.0);
        matter.openness = 1.0 - 0.6 * exp(-gap / 0.03);
        matter.key = 1.0 - 0.7 * exp(-gap / 0.012);
    } else {
        matter.albedo = mix(DRY_CLAY, WET_CLAY, frame.wetness);
        matter.film = (frame.wetness * 0.8 + 0.06) / (1.0 + 4.0 * bend * bend);
        matter.blur = mix(0.55, 0.09, frame.wetness) + bend;
        let inside = clamp(wheel.what - 1.0, 0.0, 1.0);
        let depth = max(wheel.size_m.x - wheel.position_m.z, 0.0);
        let rim = 0.045;
        let open = rim * rim / (rim * rim + 0.8 * depth * depth);
        matter.openness = mix(1.0 - 0.5 * exp(-wheel.position_m.z / 0.018), open, inside);
        matter.key = mix(1.0, 1.0 - smoothstep(0.0, 0.05, depth), inside);
    }
    return pixel_from(shaded(matter));
}
