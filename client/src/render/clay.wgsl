// Walls, rim and floor of the pot; follows transform.wgsl, deflection.wgsl, frame.wgsl and light.wgsl.

@group(2) @binding(0) var relief: texture_2d<f32>;
@group(2) @binding(1) var relief_filter: sampler;

struct Wall {
    @builtin(position) clip: vec4<f32>,
    // centroid: at an outline the middle of the pixel may lie beside the wall, where light grazes without end
    @location(0) @interpolate(perspective, centroid) position_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
    // row and column, counted on through the seam
    @location(2) @interpolate(perspective, centroid) element: vec2<f32>,
}

@vertex
fn wall_vertex(@builtin(vertex_index) vertex_index: u32) -> Wall {
    let at = mesh_element(skin, vertex_index);
    let element = deflected_element_at(skin, radii, at.x, at.y);
    var wall: Wall;
    wall.position_m = room_from_pot(element.position_m);
    wall.normal = room_from_pot(element.normal);
    wall.clip = frame.clip_from_room * vec4<f32>(wall.position_m, 1.0);
    wall.element = vec2<f32>(f32(at.y), f32(at.x));
    return wall;
}

@fragment
fn wall_fragment(wall: Wall) -> @location(0) vec4<f32> {
    let texel = (wall.element + 0.5) / vec2<f32>(f32(skin.rows), f32(skin.columns));
    let known = textureSample(relief, relief_filter, texel);
    let radius_m = length(wall.position_m.xy);
    var slopes = known.xy;
    if skin.deflects != 0u {
        slopes -= deflection_at(wall.element.y / f32(skin.columns), wall.element.x / f32(skin.rows - 1u)).yz;
    }
    let detailed = skin.facing * normal_from_slopes(wall.position_m.xy / radius_m, radius_m, slopes);
    // where a pixel spans several vertices the mesh's own normal is the steadier mean of them
    let spans = fwidth(wall.element) / vec2<f32>(f32(skin.row_stride), f32(skin.column_stride));
    let span = max(spans.x, spans.y);
    let normal = normalize(mix(detailed, wall.normal, smoothstep(1.5, 4.0, span)));
    let hollow = skin.facing * known.z;
    let damp = textureSample(water, water_filter, texel).x;
    let inside = skin.facing < 0.0;
    return pixel_from(clay(wall.position_m, normal, hollow, known.w, damp, inside));
}
