// Points of the cloud as instanced quads of a fixed size on screen, cut to discs with hard edges: the same pixels on every
// device, and no blending, so that the depth buffer alone decides what is in front.

struct View {
    clip_from_world: mat4x4f,
    // Size of the picture in pixels.
    size_px: vec2f,
    radius_px: f32,
    // By this share of their distance the points count as nearer than they are.
    nearer: f32,
    // Corners of the box outside of which nothing is drawn.
    low: vec4f,
    high: vec4f,
    // Upright plane beyond which nothing is drawn: unit vector east and north, and how far along it stands.
    cut: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;

struct Point {
    @location(0) place_m: vec3f,
    @location(1) colour: vec4f,
}

struct Corner {
    @builtin(position) clip: vec4f,
    // -1 to 1 across the disc.
    @location(0) within: vec2f,
    @location(1) @interpolate(flat) colour: vec4f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, point: Point) -> Corner {
    let within = vec2f(
        select(-1.0, 1.0, (index & 1u) == 1u),
        select(-1.0, 1.0, (index & 2u) == 2u),
    );
    let centre = view.clip_from_world * vec4f(point.place_m, 1.0);
    let offset = within * view.radius_px * 2.0 / view.size_px * centre.w;
    var corner: Corner;
    // Reverse-Z: the depth falls with the distance.
    corner.clip = vec4f(centre.xy + offset, centre.z * (1.0 + view.nearer), centre.w);
    if any(point.place_m < view.low.xyz) || any(point.place_m > view.high.xyz)
        || dot(point.place_m.xy, view.cut.xy) > view.cut.z {
        // Behind all that is seen.
        corner.clip = vec4f(0.0, 0.0, -1.0, 1.0);
    }
    corner.within = within;
    corner.colour = point.colour;
    return corner;
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4f {
    if dot(corner.within, corner.within) > 1.0 {
        discard;
    }
    return vec4f(corner.colour.rgb, 1.0);
}
