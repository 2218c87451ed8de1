// Tiles of the waterfall: mean and maximum echo over ping and range, brought to one level and coloured by a table.
//
// Each tile is one instance of a quad. Texels are read with textureLoad and averaged over the pixel's footprint here, so
// that the picture is the same on every driver; no sampler takes part. Layouts are those of src/ui/render/waterfall.rs.

struct EchoStyle {
    gamma: f32,         // intensity ^ (1 / gamma)
    highlight: f32,     // share of the maximum in what is shown, the rest is the mean
    black: f32,         // intensity shown as 0, after gain
    white: f32,         // intensity shown as 1
    time_is_down: u32,  // 1: pings run down the screen, else to the right
    linear_target: u32, // 1: the target converts to sRGB on writing
    geometry: u32,      // across: 0 recorded slant range, 1 slant range beyond the altitude, 2 distance on the ground
    filters: u32,       // 1 gain curves, 2 stripe factors, 4 median of 3 x 3
    spreading: f32,     // dB for each decade of slant range
    absorption: f32,    // dB for each metre, there and back
    middle_m: f32,      // slant range of 0 dB
    port: f32,          // factor of a side
    starboard: f32,
    curve_far_m: f32,   // slant range where the curves by range end
    curve_factor: f32,  // on the product of the curves
    padding: f32,
}

@group(0) @binding(0) var<uniform> look: EchoStyle;
@group(0) @binding(1) var<uniform> palette: array<vec4u, 64>; // 256 colours, four bytes each
@group(0) @binding(2) var<uniform> curves: array<vec4f, 64>; // 64 places each: port by range, by angle, starboard by range, by angle
@group(1) @binding(0) var tile: texture_2d<f32>;
@group(2) @binding(0) var<uniform> rows: array<vec4f, 512>; // of each row of the tile: altitude, scale, offset, stripe factor

// Constants paired with src/ui/render/waterfall.rs.
const TILE_ROWS: u32 = 512u;     // in `rows`
const CURVE_PLACES: u32 = 64u;   // of a curve in `curves`
const RANGE_BINS: f32 = 48.0;
const ANGLE_BINS: f32 = 45.0;
const LEAST_FACTOR: f32 = 0.25;  // bounds of the product of the curves
const MOST_FACTOR: f32 = 4.0;
const LEAST_RANGE_M: f32 = 0.05; // nearer, time-varied gain does not change

struct Quad {
    @location(0) along: vec2f,     // clip-space edges of the quad in the direction of time
    @location(1) across: vec2f,    // clip-space edges in the direction of range, near to far
    @location(2) rows: vec2f,      // tile rows (pings) at the edges along
    @location(3) columns: vec2f,   // tile columns (range) at the edges across
    @location(4) footprint: vec2f, // columns and rows that a pixel covers
    @location(5) across_m: vec2f,  // metres from the middle at the edges across
    @location(6) column_m: vec2f,  // recorded slant range where column 0 begins, and of one column
    @location(7) side: u32,        // 0 port, 1 starboard
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) texel: vec2f,
    @location(1) across_m: f32,
    @location(2) @interpolate(flat) footprint: vec2f,
    @location(3) @interpolate(flat) columns: vec2f,
    @location(4) @interpolate(flat) column_m: vec2f,
    @location(5) @interpolate(flat) side: u32,
}

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32, quad: Quad) -> Corner {
    let t = vec2f(f32(vertex & 1u), f32(vertex >> 1u));
    let along = mix(quad.along.x, quad.along.y, t.x);
    let across = mix(quad.across.x, quad.across.y, t.y);
    var corner: Corner;
    corner.position = vec4f(along, across, 0.0, 1.0);
    if look.time_is_down == 1u {
        corner.position = vec4f(across, along, 0.0, 1.0);
    }
    corner.texel = vec2f(mix(quad.columns.x, quad.columns.y, t.y), mix(quad.rows.x, quad.rows.y, t.x));
    corner.across_m = mix(quad.across_m.x, quad.across_m.y, t.y);
    corner.footprint = quad.footprint;
    corner.columns = quad.columns;
    corner.column_m = quad.column_m;
    corner.side = quad.side;
    return corner;
}

// Altitude, scale, offset and stripe factor of a row of the tile.
fn ping_of(row: f32) -> vec4f {
    return rows[min(u32(max(row, 0.0)), TILE_ROWS - 1u)];
}

// Overlap of texel `index` with the interval from `low` to `high`.
fn overlap(index: i32, low: f32, high: f32) -> f32 {
    return max(min(high, f32(index) + 1.0) - max(low, f32(index)), 0.0);
}

// Mean, maximum and covered share of the texels under a pixel. A footprint below one texel shows the nearest.
fn box_filter(texel: vec2f, footprint: vec2f) -> vec3f {
    let last = vec2i(textureDimensions(tile)) - 1;
    let half = max(footprint, vec2f(1e-3)) / 2.0;
    var low = texel - half;
    var high = texel + half;
    if footprint.x < 1.0 { low.x = floor(texel.x); high.x = low.x + 1.0; }
    if footprint.y < 1.0 { low.y = floor(texel.y); high.y = low.y + 1.0; }
    // A footprint spans two texels at most on the levels that the view chooses: three per axis are touched.
    let first = clamp(vec2i(floor(low)), vec2i(0), last);
    let end = min(vec2i(ceil(high)) - 1, min(first + 3, last));
    var sum = 0.0;
    var covered = 0.0;
    var whole = 0.0;
    var largest = 0.0;
    for (var y = first.y; y <= end.y; y++) {
        for (var x = first.x; x <= end.x; x++) {
            let weight = overlap(x, low.x, high.x) * overlap(y, low.y, high.y);
            let echo = textureLoad(tile, vec2i(x, y), 0).rg;
            let has_data = f32(echo.g > 0.0) * weight;
            sum += echo.r * has_data;
            covered += has_data;
            whole += weight;
            if weight > 0.05 { largest = max(largest, echo.g); }
        }
    }
    return vec3f(sum / max(covered, 1e-6), largest, covered / max(whole, 1e-6));
}

// Median of the means of the 3 x 3 texels about one, those without data left out of it.
fn median(texel: vec2f, centre: f32) -> f32 {
    let last = vec2i(textureDimensions(tile)) - 1;
    let middle = clamp(vec2i(floor(texel)), vec2i(0), last);
    var sorted = array<f32, 9>();
    for (var index = 0; index < 9; index++) {
        let at = clamp(middle + vec2i(index % 3, index / 3) - 1, vec2i(0), last);
        let echo = textureLoad(tile, at, 0).rg;
        var value = select(centre, echo.r, echo.g > 0.0);
        // Insertion: nine values are too few for anything cleverer.
        for (var place = 0; place < index; place++) {
            let other = sorted[place];
            sorted[place] = min(other, value);
            value = max(other, value);
        }
        sorted[index] = value;
    }
    return sorted[4];
}

// Value of a curve at a place counted in bins from the middle of the first; linear between, constant beyond the ends.
fn curve(row: u32, place: f32, bins: f32) -> f32 {
    let inside = clamp(place, 0.0, bins - 1.0);
    let low = min(u32(inside), u32(bins) - 2u);
    let place_low = CURVE_PLACES * row + low;
    let place_high = place_low + 1u;
    let value_low = curves[place_low / 4u][place_low % 4u];
    let value_high = curves[place_high / 4u][place_high % 4u];
    return mix(value_low, value_high, inside - f32(low));
}

// Factor on an echo at a calibrated slant range, metres, of a ping. The water column has that of straight down.
fn gain(side: u32, slant_m: f32, ping: vec4f) -> f32 {
    let range_m = max(max(slant_m, ping.x), LEAST_RANGE_M);
    var factor = select(look.port, look.starboard, side == 1u);
    if look.spreading != 0.0 || look.absorption != 0.0 {
        let spreading = look.spreading * log2(range_m / look.middle_m) / log2(10.0);
        let absorption = 2.0 * look.absorption * (range_m - look.middle_m);
        factor *= pow(10.0, (spreading + absorption) / 20.0);
    }
    if (look.filters & 1u) != 0u {
        let angle = sqrt(max(1.0 - ping.x / range_m, 0.0));
        let by_range = curve(2u * side, range_m / look.curve_far_m * RANGE_BINS - 0.5, RANGE_BINS);
        let by_angle = curve(2u * side + 1u, angle * ANGLE_BINS - 0.5, ANGLE_BINS);
        factor *= look.curve_factor * clamp(by_range * by_angle, LEAST_FACTOR, MOST_FACTOR);
    }
    if (look.filters & 2u) != 0u {
        factor *= ping.w;
    }
    return factor;
}

fn linear_from_gamma(colour: vec3f) -> vec3f {
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, colour < vec3f(0.04045));
}

@fragment
fn fs_main(corner: Corner) -> @location(0) vec4f {
    let ping = ping_of(corner.texel.y);
    var texel = corner.texel;
    var footprint = corner.footprint;
    if look.geometry != 0u {
        var slant_m = corner.across_m + ping.x;
        if look.geometry == 2u {
            slant_m = sqrt(corner.across_m * corner.across_m + ping.x * ping.x);
            footprint.x *= corner.across_m / max(slant_m, 1e-6);
        }
        footprint.x /= ping.y;
        texel.x = ((slant_m - ping.z) / ping.y - corner.column_m.x) / corner.column_m.y;
        // The quad reaches as far as its columns do at any ping.
        if texel.x < corner.columns.x || texel.x >= corner.columns.y {
            discard;
        }
    }
    let echo = box_filter(texel, footprint);
    if echo.z <= 0.0 {
        discard;
    }
    var recorded = mix(echo.x, echo.y, look.highlight);
    if (look.filters & 4u) != 0u {
        recorded = median(texel, echo.x);
    }
    let recorded_m = corner.column_m.x + texel.x * corner.column_m.y;
    let even = recorded * gain(corner.side, ping.y * recorded_m + ping.z, ping);
    let level = clamp((even - look.black) / (look.white - look.black), 0.0, 1.0);
    let curved = pow(level, 1.0 / look.gamma);
    let index = u32(round(curved * 255.0));
    var colour = unpack4x8unorm(palette[index / 4u][index % 4u]).rgb;
    if look.linear_target == 1u {
        colour = linear_from_gamma(colour);
    }
    return vec4f(colour * echo.z, echo.z);
}
