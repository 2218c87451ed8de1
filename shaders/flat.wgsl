// Flat parts of a pass of the window: an area of one colour, and a picture, texel by pixel.

struct Tint {
    colour: vec4f,      // gamma-encoded, multiplied by its alpha
    linear_target: u32, // 1: the target converts to sRGB on writing
}

@group(0) @binding(0) var<uniform> tint: Tint;
@group(1) @binding(0) var picture: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) share: vec2f, // of the area, from its upper left corner
}

// A triangle that covers the viewport.
@vertex
fn vs_main(@builtin(vertex_index) vertex: u32) -> Corner {
    let share = vec2f(f32((vertex << 1u) & 2u), f32(vertex & 2u));
    var corner: Corner;
    corner.share = share;
    corner.position = vec4f(2.0 * share.x - 1.0, 1.0 - 2.0 * share.y, 0.0, 1.0);
    return corner;
}

fn linear_from_gamma(colour: vec3f) -> vec3f {
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, colour < vec3f(0.04045));
}

fn encoded(colour: vec4f) -> vec4f {
    if tint.linear_target == 1u {
        return vec4f(linear_from_gamma(colour.rgb), colour.a);
    }
    return colour;
}

@fragment
fn fs_fill() -> @location(0) vec4f {
    return encoded(tint.colour);
}

@fragment
fn fs_picture(corner: Corner) -> @location(0) vec4f {
    let size = vec2f(textureDimensions(picture));
    let texel = textureLoad(picture, vec2u(corner.share * size), 0);
    // Blocks of pixels that are all empty are not blended.
    if texel.a == 0.0 {
        discard;
    }
    return encoded(tint.colour * texel);
}
