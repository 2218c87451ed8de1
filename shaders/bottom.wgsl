// The bottom as a mesh: lit from one side, with lines of equal depth of one width on the screen. Corners where nothing is drawn carry no alpha,
// and whatever touches one is left out.

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
    // Brightness of a bottom turned away from the light.
    darkest: f32,
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
    // The mean around it, and as alpha whether it is lit.
    @location(3) far_colour: vec4f,
    // Squares are 2 to this of the finest ones long.
    @builtin(instance_index) level: u32,
}

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) faces: vec3f,
    @location(1) colour: vec4f,
    @location(2) place_m: vec3f,
    @location(3) is_lit: f32,
}

// How much brighter than level ground a bottom square to the light may be.
const BRIGHTEST = 1.35;
// Level at which squares are as long as what the colours from far away are means of.
const FAR_LEVEL = 2.0;

@vertex
fn vertex(vertex: Vertex) -> Corner {
    let up = sqrt(max(1.0 - dot(vertex.faces, vertex.faces), 1e-4));
    var corner: Corner;
    corner.clip = view.clip_from_world * vec4f(vertex.place_m, 1.0);
    corner.faces = vec3f(vertex.faces * view.exaggeration, up);
    let far = min(f32(vertex.level) / FAR_LEVEL, 1.0);
    corner.colour = vec4f(mix(vertex.colour.rgb, vertex.far_colour.rgb, far), vertex.colour.a);
    corner.is_lit = vertex.far_colour.a;
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
    let brightness = min(view.darkest + (1.0 - view.darkest) * lit, BRIGHTEST);
    var colour = corner.colour.rgb * mix(1.0, brightness, corner.is_lit);
    if view.isobath_m > 0.0 {
        let away_px = abs(fract(lines - 0.5) - 0.5) / max(a_pixel, 1e-6);
        let line = 1.0 - smoothstep(view.half_line_px - 0.5, view.half_line_px + 0.5, away_px);
        // Lines nearer to each other than some pixels would be one grey sheet.
        let apart = 1.0 - smoothstep(0.1, 0.25, a_pixel);
        colour = mix(colour, vec3f(0.0), 0.6 * line * apart * corner.is_lit);
    }
    return vec4f(min(colour, vec3f(1.0)), 1.0);
}
