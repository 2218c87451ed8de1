// Tiles of the waterfall: mean and maximum echo over ping and range, coloured by a table.
//
// Each tile is one instance of a quad. Texels are read with textureLoad and averaged over the pixel's footprint here, so
// that the picture is the same on every driver; no sampler takes part. Layouts are those of src/render/waterfall.rs.

struct Look {
    brightness: f32,    // added to the intensity
    contrast: f32,      // factor about mid-grey
    gamma: f32,         // intensity ^ (1 / gamma)
    highlight: f32,     // share of the maximum in what is shown, the rest is the mean
    time_is_down: u32,  // 1: pings run down the screen, else to the right
    linear_target: u32, // 1: the target converts to sRGB on writing
    black: f32,         // intensity shown as 0, before all of the above
    white: f32,         // intensity shown as 1
}

@group(0) @binding(0) var<uniform> look: Look;
@group(0) @binding(1) var palette: texture_2d<f32>;
@group(1) @binding(0) var tile: texture_2d<f32>;

struct Quad {
    @location(0) along: vec2f,     // clip-space edges of the quad in the direction of time
    @location(1) across: vec2f,    // clip-space edges in the direction of range, near to far
    @location(2) rows: vec2f,      // tile rows (pings) at the edges along
    @location(3) columns: vec2f,   // tile columns (range) at the edges across
    @location(4) footprint: vec2f, // columns and rows that a pixel covers
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) texel: vec2f,
    @location(1) @interpolate(flat) footprint: vec2f,
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
    corner.footprint = quad.footprint;
    return corner;
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

fn linear_from_gamma(colour: vec3f) -> vec3f {
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, colour < vec3f(0.04045));
}

@fragment
fn fs_main(corner: Corner) -> @location(0) vec4f {
    let echo = box_filter(corner.texel, corner.footprint);
    if echo.z <= 0.0 {
        discard;
    }
    let recorded = mix(echo.x, echo.y, look.highlight);
    let level = clamp((recorded - look.black) / (look.white - look.black), 0.0, 1.0);
    let shown = clamp((level - 0.5) * look.contrast + 0.5 + look.brightness, 0.0, 1.0);
    let curved = pow(shown, 1.0 / look.gamma);
    var colour = textureLoad(palette, vec2i(i32(round(curved * 255.0)), 0), 0).rgb;
    if look.linear_target == 1u {
        colour = linear_from_gamma(colour);
    }
    return vec4f(colour * echo.z, echo.z);
}
