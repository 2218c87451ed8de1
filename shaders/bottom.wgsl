// The bottom as a mesh: lit from one side, with lines of equal depth of one width on the screen. Unknown corners carry no alpha, and
// whatever touches one is left out.

struct View {
    clip_from_world: mat4x4f,
    // Towards the light, of length 1: east, north, up.
    light: vec3f,
    // Factor on elevations.
    exaggeration: f32,
    // Metres from one isobath to the next, 0 for none, and the depth of one of them.
    isobath_m: f32,
    first_m: f32,
    // Half the width of an isobath, pixels.
    half_line_px: f32,
    padding: f32,
    // Corners of the box outside of which nothing is drawn.
    low: vec4f,
    high: vec4f,
    // Upright plane beyond which nothing is drawn: unit vector east and north, and how far along it stands.
    cut: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;

struct Vertex {
    @location(0) place_m: vec3f,
    // East and north of the direction that the bottom faces; up is what is left of 1.
    @location(1) faces: vec2f,
    @location(2) colour: vec4f,
}

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) faces: vec3f,
    @location(1) colour: vec4f,
    @location(2) place_m: vec3f,
}

// Of a bottom turned away from the light, and how much brighter than level ground one square to it may be.
const SHADED = 0.25;
const BRIGHTEST = 1.35;

@vertex
fn vertex(vertex: Vertex) -> Corner {
    let up = sqrt(max(1.0 - dot(vertex.faces, vertex.faces), 1e-4));
    var corner: Corner;
    corner.clip = view.clip_from_world * vec4f(vertex.place_m, 1.0);
    corner.faces = vec3f(vertex.faces * view.exaggeration, up);
    corner.colour = vertex.colour;
    corner.place_m = vertex.place_m;
    return corner;
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4f {
    // Derivatives before anything is left out: neighbours must all have taken part.
    let lines = (-corner.place_m.z - view.first_m) / max(view.isobath_m, 1e-6);
    let a_pixel = fwidth(lines);
    let is_out = any(corner.place_m < view.low.xyz) || any(corner.place_m > view.high.xyz)
        || dot(corner.place_m.xy, view.cut.xy) > view.cut.z;
    if corner.colour.a < 0.999 || is_out {
        discard;
    }
    let lit = max(dot(normalize(corner.faces), view.light), 0.0) / max(view.light.z, 0.05);
    var colour = corner.colour.rgb * min(SHADED + (1.0 - SHADED) * lit, BRIGHTEST);
    if view.isobath_m > 0.0 {
        let away_px = abs(fract(lines - 0.5) - 0.5) / max(a_pixel, 1e-6);
        let line = 1.0 - smoothstep(view.half_line_px - 0.5, view.half_line_px + 0.5, away_px);
        // Lines nearer to each other than some pixels would be one grey sheet.
        let apart = 1.0 - smoothstep(0.1, 0.25, a_pixel);
        colour = mix(colour, vec3f(0.0), 0.6 * line * apart);
    }
    return vec4f(min(colour, vec3f(1.0)), 1.0);
}
