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
// Weights by output channel, input channel, row and column, and a bias for each output channel after them; or another input.
@group(0) @binding(2) var<storage, read> other: array<f32>;
@group(0) @binding(3) var<storage, read_write> output: array<f32>;

fn applied(value: f32) -> f32 {
    switch numbers.function {
        case LEAKY: { return select(numbers.slope * value, value, value >= 0.0); }
        case SIGMOID: { return 1.0 / (1.0 + exp(-value)); }
        case SILU: { return value / (1.0 + exp(-value)); }
        default: { return value; }
    }
}

// A convolution is a product of matrices, of weights and of what lies under the windows. A group computes SIDE x SIDE numbers of it, of as many
// output channels and pixels, each invocation 4 x 4 of them.
const SIDE: u32 = 64u;
const DEPTH: u32 = 16u;
const THREADS: u32 = 256u;
var<workgroup> weights_here: array<f32, 1024>;
var<workgroup> inputs_here: array<f32, 1024>;

@compute @workgroup_size(16, 16)
fn convolve(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let window = numbers.window_y * numbers.window_x;
    let depth = numbers.channels_in * window;
    let pixels = numbers.height_out * numbers.width_out;
    let area = numbers.height_in * numbers.width_in;
    let first_pixel = group.x * SIDE;
    let first_channel = group.y * SIDE;
    // The pixel that this invocation fetches inputs for.
    let pixel = first_pixel + index % SIDE;
    let top = i32(pixel / numbers.width_out * numbers.step_y) - i32(numbers.before_y);
    let left = i32(pixel % numbers.width_out * numbers.step_x) - i32(numbers.before_x);
    var sums = array<vec4<f32>, 4>();
    for (var start = 0u; start < depth; start += DEPTH) {
        for (var part = index; part < SIDE * DEPTH; part += THREADS) {
            let row = start + part % DEPTH;
            let channel = first_channel + part / DEPTH;
            var weight = 0.0;
            if row < depth && channel < numbers.channels_out {
                weight = other[channel * depth + row];
            }
            weights_here[part % DEPTH * SIDE + part / DEPTH] = weight;

            let under = start + part / SIDE;
            let y = top + i32(under % window / numbers.window_x);
            let x = left + i32(under % numbers.window_x);
            var value = 0.0;
            if under < depth && pixel < pixels && y >= 0 && y < i32(numbers.height_in) && x >= 0 && x < i32(numbers.width_in) {
                value = input[numbers.first + under / window * area + u32(y) * numbers.width_in + u32(x)];
            }
            inputs_here[part] = value;
        }
        workgroupBarrier();
        for (var row = 0u; row < DEPTH; row++) {
            let at = row * SIDE + 4u * local.x;
            let values = vec4<f32>(inputs_here[at], inputs_here[at + 1u], inputs_here[at + 2u], inputs_here[at + 3u]);
            let line = row * SIDE + 4u * local.y;
            for (var channel = 0u; channel < 4u; channel++) {
                sums[channel] += weights_here[line + channel] * values;
            }
        }
        workgroupBarrier();
    }
    for (var row = 0u; row < 4u; row++) {
        let channel = first_channel + 4u * local.y + row;
        if channel >= numbers.channels_out {
            break;
        }
        let bias = other[numbers.channels_out * depth + channel];
        for (var column = 0u; column < 4u; column++) {
            let at = first_pixel + 4u * local.x + column;
            if at < pixels {
                output[channel * pixels + at] = applied(sums[row][column] + bias);
            }
        }
    }
}

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
