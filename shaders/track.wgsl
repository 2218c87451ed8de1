// A track as instanced quads, one a segment, with round ends: pieces join without gaps at any turn. A segment from or to a
// vertex of alpha 0 is a break in the line.

struct Line {
    // Pixels from metres: scale x, scale y (negative: north is up), offset x, offset y.
    px_from_world: vec4f,
    // Size of the picture in pixels.
    size_px: vec2f,
    half_width_px: f32,
    // Above 0: this colour instead of the segments' own.
    plain: f32,
    colour: vec4f,
}

@group(0) @binding(0) var<uniform> line: Line;

struct Segment {
    @location(0) from_m: vec2f,
    @location(1) to_m: vec2f,
    @location(2) from_colour: vec4f,
    @location(3) to_colour: vec4f,
}

struct Corner {
    @builtin(position) clip: vec4f,
    // Along the segment from its start, and across it, pixels.
    @location(0) along_across_px: vec2f,
    @location(1) @interpolate(flat) length_px: f32,
    @location(2) @interpolate(flat) from_colour: vec4f,
    @location(3) @interpolate(flat) to_colour: vec4f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, segment: Segment) -> Corner {
    let from_px = segment.from_m * line.px_from_world.xy + line.px_from_world.zw;
    let to_px = segment.to_m * line.px_from_world.xy + line.px_from_world.zw;
    let length_px = distance(from_px, to_px);
    var forward = vec2f(1.0, 0.0);
    if length_px > 1e-4 {
        forward = (to_px - from_px) / length_px;
    }
    let left = vec2f(-forward.y, forward.x);
    // One pixel more than the line is wide, for its soft edge.
    let reach = line.half_width_px + 1.0;
    let along = select(-reach, length_px + reach, (index & 1u) == 1u);
    let across = select(-reach, reach, (index & 2u) == 2u);
    let at_px = from_px + forward * along + left * across;
    let ndc = at_px / line.size_px * 2.0 - 1.0;
    var corner: Corner;
    corner.clip = vec4f(ndc.x, -ndc.y, 0.5, 1.0);
    corner.along_across_px = vec2f(along, across);
    corner.length_px = length_px;
    corner.from_colour = segment.from_colour;
    corner.to_colour = segment.to_colour;
    if segment.from_colour.a == 0.0 || segment.to_colour.a == 0.0 {
        // All corners in one place, out of the picture.
        corner.clip = vec4f(2.0, 2.0, 0.5, 1.0);
    }
    return corner;
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4f {
    let along = corner.along_across_px.x;
    let past_end = along - clamp(along, 0.0, corner.length_px);
    let off_px = length(vec2f(past_end, corner.along_across_px.y));
    let coverage = clamp(line.half_width_px + 0.5 - off_px, 0.0, 1.0);
    if coverage <= 0.0 {
        discard;
    }
    let share = clamp(along / max(corner.length_px, 1e-4), 0.0, 1.0);
    let own = mix(corner.from_colour, corner.to_colour, share);
    let colour = select(own, line.colour, line.plain > 0.0);
    // Premultiplied, as the window blends.
    let alpha = colour.a * coverage;
    return vec4f(colour.rgb * alpha, alpha);
}
