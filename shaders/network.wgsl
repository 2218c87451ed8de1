// Layers of a network over pictures of f32, channel by channel and row by row. One step is one dispatch.

// What a step is over; those that a layer has no use for are 0. `Numbers` in detection/model/graphics/program.rs.
struct Numbers {
    channels_in: u32,
    height_in: u32,
    width_in: u32,
    channels_out: u32,
    height_out: u32,
    width_out: u32,
    // Numbers of the window, from one window to the next, and how far the first one begins before the picture.
    window_y: u32,
    window_x: u32,
    step_y: u32,
    step_x: u32,
    before_y: u32,
    before_x: u32,
    // Where the input begins in its buffer, and the other input in its own.
    first: u32,
    first_other: u32,
    // One of the constants below, and its parameter.
    function: u32,
    slope: f32,
}

const AS_IT_IS: u32 = 0u;
const LEAKY: u32 = 1u;
const SIGMOID: u32 = 2u;
const SILU: u32 = 3u;
const SUM: u32 = 4u;

@group(0) @binding(0) var<uniform> numbers: Numbers;
@group(0) @binding(1) var<storage, read> input: array<f32>;
// Weights and biases of a convolution, or another input.
@group(0) @binding(2) var<storage, read> other: array<f32>;
@group(0) @binding(3) var<storage, read_write> output: array<f32>;
// What lies under the window of a convolution. `Weights` in detection/model/graphics/convolution.rs.
@group(0) @binding(4) var<storage, read> under: array<vec2<u32>>;

fn applied(value: f32) -> f32 {
    switch numbers.function {
        case LEAKY: { return select(numbers.slope * value, value, value >= 0.0); }
        case SIGMOID: { return 1.0 / (1.0 + exp(-value)); }
        case SILU: { return value / (1.0 + exp(-value)); }
        default: { return value; }
    }
}

// A convolution is a product of matrices, of weights and of what lies under the windows. A group computes SIDE x SIDE numbers of it, of as many
// output channels and pixels, each invocation 8 x 4 of them. It fetches DEPTH numbers of each sum at once, and the next ones meanwhile.
const SIDE: u32 = 64u;
const DEPTH: u32 = 16u;
// Of four numbers, in a row of what is fetched.
const QUADS: u32 = 16u;
var<workgroup> weights_here: array<vec4<f32>, 256>;
var<workgroup> inputs_here: array<vec4<f32>, 256>;

// Where the windows of four pixels begin: row, column and number of the input.
struct Corners {
    top: vec4<i32>,
    left: vec4<i32>,
    first: vec4<i32>,
}

fn corners(pixel: u32) -> Corners {
    let pixels = pixel + vec4<u32>(0u, 1u, 2u, 3u);
    let top = vec4<i32>(pixels / numbers.width_out * numbers.step_y) - i32(numbers.before_y);
    let left = vec4<i32>(pixels % numbers.width_out * numbers.step_x) - i32(numbers.before_x);
    let first = i32(numbers.first) + top * i32(numbers.width_in) + left;
    // No row of the input lies under a window that begins there.
    let nowhere = vec4<i32>(-65536);
    let is_pixel = pixels < vec4<u32>(numbers.height_out * numbers.width_out);
    return Corners(select(nowhere, top, is_pixel), left, first);
}

fn input_at(top: i32, left: i32, first: i32, place: vec2<u32>) -> f32 {
    // A row before the first is larger than any as a number without a sign.
    let y = u32(top + i32(place.y >> 16u));
    let x = u32(left + i32(place.y & 65535u));
    if y < numbers.height_in && x < numbers.width_in {
        return input[u32(first + i32(place.x))];
    }
    return 0.0;
}

fn inputs_at(at: Corners, term: u32) -> vec4<f32> {
    let place = under[term];
    return vec4<f32>(
        input_at(at.top.x, at.left.x, at.first.x, place),
        input_at(at.top.y, at.left.y, at.first.y, place),
        input_at(at.top.z, at.left.z, at.first.z, place),
        input_at(at.top.w, at.left.w, at.first.w, place),
    );
}

fn weights_at(first: u32) -> vec4<f32> {
    return vec4<f32>(other[first], other[first + 1u], other[first + 2u], other[first + 3u]);
}

fn put(channel: u32, bias: u32, pixel: u32, sums: vec4<f32>) {
    if channel >= numbers.channels_out {
        return;
    }
    let pixels = numbers.height_out * numbers.width_out;
    let values = sums + other[bias + channel];
    for (var column = 0u; column < min(4u, max(pixel, pixels) - pixel); column++) {
        output[channel * pixels + pixel + column] = applied(values[column]);
    }
}

@compute @workgroup_size(16, 8)
fn convolve(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let terms = numbers.channels_in * numbers.window_y * numbers.window_x;
    let depth = (terms + DEPTH - 1u) / DEPTH * DEPTH;
    let across = (numbers.channels_out + SIDE - 1u) / SIDE * SIDE;
    // This invocation fetches four pixels and four channels of two of the DEPTH numbers.
    let quad = index % QUADS;
    let line = index / QUADS;
    let at = corners(group.x * SIDE + 4u * quad);
    let weights = group.y * SIDE + 4u * quad;
    var weights_next = array(weights_at(line * across + weights), weights_at((line + 8u) * across + weights));
    var inputs_next = array(inputs_at(at, line), inputs_at(at, line + 8u));
    var sums = array<vec4<f32>, 8>();
    for (var start = 0u; start < depth; start += DEPTH) {
        weights_here[index] = weights_next[0];
        weights_here[index + 128u] = weights_next[1];
        inputs_here[index] = inputs_next[0];
        inputs_here[index + 128u] = inputs_next[1];
        workgroupBarrier();
        let next = start + DEPTH + line;
        if next < depth {
            weights_next[0] = weights_at(next * across + weights);
            weights_next[1] = weights_at((next + 8u) * across + weights);
            inputs_next[0] = inputs_at(at, next);
            inputs_next[1] = inputs_at(at, next + 8u);
        }
        for (var row = 0u; row < DEPTH; row++) {
            let values = inputs_here[row * QUADS + local.x];
            let one = weights_here[row * QUADS + 2u * local.y];
            let two = weights_here[row * QUADS + 2u * local.y + 1u];
            sums[0] += one.x * values;
            sums[1] += one.y * values;
            sums[2] += one.z * values;
            sums[3] += one.w * values;
            sums[4] += two.x * values;
            sums[5] += two.y * values;
            sums[6] += two.z * values;
            sums[7] += two.w * values;
        }
        workgroupBarrier();
    }
    let channel = group.y * SIDE + 8u * local.y;
    let pixel = group.x * SIDE + 4u * local.x;
    let biases = depth * across;
    put(channel, biases, pixel, sums[0]);
    put(channel + 1u, biases, pixel, sums[1]);
    put(channel + 2u, biases, pixel, sums[2]);
    put(channel + 3u, biases, pixel, sums[3]);
    put(channel + 4u, biases, pixel, sums[4]);
    put(channel + 5u, biases, pixel, sums[5]);
    put(channel + 6u, biases, pixel, sums[6]);
    put(channel + 7u, biases, pixel, sums[7]);
}

// Invocations of a group of a layer that is no convolution.
const THREADS: u32 = 256u;

// The number of the output that an invocation begins with, and from one of its numbers to the next.
struct Share {
    first: u32,
    step: u32,
}

fn share(id: vec3<u32>, groups: vec3<u32>) -> Share {
    return Share(id.x, groups.x * THREADS);
}

fn count_out() -> u32 {
    return numbers.channels_out * numbers.height_out * numbers.width_out;
}

@compute @workgroup_size(256)
fn pool(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let mine = share(id, groups);
    for (var at = mine.first; at < count_out(); at += mine.step) {
        let pixel = at % (numbers.height_out * numbers.width_out);
        let channel = at / (numbers.height_out * numbers.width_out);
        let top = i32(pixel / numbers.width_out * numbers.step_y) - i32(numbers.before_y);
        let left = i32(pixel % numbers.width_out * numbers.step_x) - i32(numbers.before_x);
        let picture = numbers.first + channel * numbers.height_in * numbers.width_in;
        var greatest = -3.4028234e38;
        for (var y = max(top, 0); y < min(top + i32(numbers.window_y), i32(numbers.height_in)); y++) {
            for (var x = max(left, 0); x < min(left + i32(numbers.window_x), i32(numbers.width_in)); x++) {
                greatest = max(greatest, input[picture + u32(y) * numbers.width_in + u32(x)]);
            }
        }
        output[at] = greatest;
    }
}

// Each number as often as the steps say, down and across.
@compute @workgroup_size(256)
fn enlarge(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let mine = share(id, groups);
    for (var at = mine.first; at < count_out(); at += mine.step) {
        let x = at % numbers.width_out / numbers.step_x;
        let row = at / numbers.width_out;
        let y = row % numbers.height_out / numbers.step_y;
        let channel = row / numbers.height_out;
        output[at] = input[numbers.first + (channel * numbers.height_in + y) * numbers.width_in + x];
    }
}

@compute @workgroup_size(256)
fn apply(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let mine = share(id, groups);
    for (var at = mine.first; at < count_out(); at += mine.step) {
        output[at] = applied(input[numbers.first + at]);
    }
}

// The sum or the product of two inputs.
@compute @workgroup_size(256)
fn combine(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let mine = share(id, groups);
    for (var at = mine.first; at < count_out(); at += mine.step) {
        let one = input[numbers.first + at];
        let another = other[numbers.first_other + at];
        output[at] = select(one * another, one + another, numbers.function == SUM);
    }
}
