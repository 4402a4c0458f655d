// The transform of Lee and Choi, section II C: an element's angle and height follow from the vertex index, its radius
// is read from a texture, and the Cartesian position and normal are computed here.
//
// Everything is in the pot's frame, metres; z up along the wheel's axis.

struct Skin {
    columns: u32,
    rows: u32,
    // first row that is drawn: the floor's, for an inner wall
    first_row: u32,
    // every n-th column and row is a vertex; the last row always is
    column_stride: u32,
    row_stride: u32,
    // 1 looks away from the axis, -1 towards it
    facing: f32,
    // subtracted from every radius
    inset_m: f32,
    row_height_m: f32,
    // elements within which a hollow is looked for
    reach_columns: u32,
    reach_rows: u32,
    // where the pot's first column lies among the radii: there may be many pots in one texture
    first_column: u32,
    // 1 where the wall is drawn as it has given way
    deflects: u32,
}

struct Element {
    position_m: vec3<f32>,
    normal: vec3<f32>,
}

@group(1) @binding(0) var<uniform> skin: Skin;
// width: rows, height: columns, as the radii lie in memory, pot after pot
@group(1) @binding(1) var radii: texture_2d<f32>;

const QUARTER_TURN: f32 = 1.5707963267948966;
const TURN: f32 = 6.283185307179586;

// Cosine and sine of a column's angle.
//
// The quarter is split off in integers, so that column `columns` lands exactly on column 0; the rest lies within an
// eighth of a turn, where these Taylor polynomials are exact to f32. A shader's own sin() may be 2^-11 off.
fn column_circle(columns: u32, column: u32) -> vec2<f32> {
    let quarters = (8u * column + columns) / (2u * columns);
    let rest = i32(4u * column) - i32(quarters * columns);
    let angle = f32(rest) * (QUARTER_TURN / f32(columns));
    let square = angle * angle;
    let cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square / 40320.0)));
    let cubic = square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square / 362880.0)));
    let sine = angle - angle * cubic;
    switch quarters & 3u {
        case 0u: { return vec2<f32>(cosine, sine); }
        case 1u: { return vec2<f32>(-sine, cosine); }
        case 2u: { return vec2<f32>(-cosine, -sine); }
        default: { return vec2<f32>(sine, -cosine); }
    }
}

fn radius_at(grid: texture_2d<f32>, column: u32, row: u32) -> f32 {
    return textureLoad(grid, vec2<i32>(i32(row), i32(column)), 0).x;
}

// dr/dθ (m/rad) and dr/dz of an element: central differences; foot and rim look one way only, to second order.
fn slopes_at(on: Skin, grid: texture_2d<f32>, column: u32, row: u32) -> vec2<f32> {
    let here = column % on.columns;
    let before = radius_at(grid, on.first_column + (here + on.columns - 1u) % on.columns, row);
    let after = radius_at(grid, on.first_column + (here + 1u) % on.columns, row);
    let around = (after - before) * f32(on.columns) / (2.0 * TURN);
    var first = row - 1u;
    var weights = vec3<f32>(-1.0, 0.0, 1.0);
    if row == 0u {
        first = 0u;
        weights = vec3<f32>(-3.0, 4.0, -1.0);
    } else if row + 1u >= on.rows {
        first = on.rows - 3u;
        weights = vec3<f32>(1.0, -4.0, 3.0);
    }
    let three = vec3<f32>(
        radius_at(grid, on.first_column + here, first),
        radius_at(grid, on.first_column + here, first + 1u),
        radius_at(grid, on.first_column + here, first + 2u),
    );
    return vec2<f32>(around, dot(weights, three) / (2.0 * on.row_height_m));
}

// The outward normal of r(θ, z) from its slopes: e_r − (dr/dθ / r) e_θ − (dr/dz) e_z, of length one.
fn normal_from_slopes(circle: vec2<f32>, radius_m: f32, slopes: vec2<f32>) -> vec3<f32> {
    let tangential = slopes.x / radius_m;
    return normalize(vec3<f32>(circle.x + tangential * circle.y, circle.y - tangential * circle.x, -slopes.y));
}

fn element_at(on: Skin, grid: texture_2d<f32>, column: u32, row: u32) -> Element {
    return moved_element_at(on, grid, column, row, vec3<f32>(0.0));
}

// The same where it has moved away from the axis, by so much (m) and more from angle to angle (m/rad) and from height to height (m/m).
fn moved_element_at(on: Skin, grid: texture_2d<f32>, column: u32, row: u32, moved: vec3<f32>) -> Element {
    let circle = column_circle(on.columns, column);
    let radius_m = radius_at(grid, on.first_column + column % on.columns, row) - on.inset_m + moved.x;
    let slopes = slopes_at(on, grid, column, row) + moved.yz;
    var element: Element;
    element.position_m = vec3<f32>(radius_m * circle, f32(row) * on.row_height_m);
    element.normal = on.facing * normal_from_slopes(circle, radius_m, slopes);
    return element;
}

fn mesh_rows(on: Skin) -> u32 {
    return (on.rows - 1u - on.first_row + on.row_stride - 1u) / on.row_stride + 1u;
}

// Column (0 to `columns`, which is column 0 again) and row of a mesh vertex.
fn mesh_element(on: Skin, vertex_index: u32) -> vec2<u32> {
    let rows = mesh_rows(on);
    let column = min((vertex_index / rows) * on.column_stride, on.columns);
    let row = min(on.first_row + (vertex_index % rows) * on.row_stride, on.rows - 1u);
    return vec2<u32>(column, row);
}
