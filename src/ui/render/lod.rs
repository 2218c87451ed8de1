//! Builds levels of detail of a long coloured line, so that the number of drawn segments does not
//! grow with the length of the recording.

use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// A place on the line and its colour, as the shader reads it; a NaN place breaks the line.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Metres, relative to an origin near the line.
    pub place: [f32; 2],
    /// sRGB and alpha; an alpha of 0 breaks the line on the GPU.
    pub colour: [u8; 4],
}

impl Vertex {
    /// Break of the line.
    pub(crate) const BREAK: Self = Self { place: [f32::NAN; 2], colour: [0; 4] };
}

/// A box: low x, low y, high x, high y.
pub(super) type LayerBounds = [f32; 4];

/// Segments of a chunk.
const CHUNK: usize = 512;
/// Spacing of the vertices of the finest level, metres: below what a position fix resolves.
const FINEST_M: f32 = 0.02;
/// Ratio of the spacing of a level to that of the next finer one.
const COARSER: f32 = 2.0;
/// Vertices that one straight piece replaces, at most.
const STRAIGHT: usize = 24;
/// Largest difference of colour that is not visible along a line, of 255.
const EVEN_COLOUR: f32 = 6.0;
/// Least extent of a piece that is more than a speck, in tolerances of its level.
const SPECK: f32 = 2.0;
/// Number of vertices at or below which no coarser level is built.
const FEW: usize = 256;

/// One level: the line with fewer vertices than it was recorded with. The vertices themselves are
/// on the GPU.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LineLevel {
    /// Largest distance of the drawn line from the recorded one, metres.
    pub tolerance_m: f32,
    /// Number of straight pieces that join one vertex to the next, breaks included.
    pub segments: u32,
    /// The box of each chunk of segments, in order.
    pub chunks: Vec<LayerBounds>,
}

impl LineLevel {
    /// Returns the runs of segments whose chunks touch the view; adjacent runs are joined.
    pub(crate) fn visible(&self, view: LayerBounds) -> Vec<Range<u32>> {
        let mut runs: Vec<Range<u32>> = Vec::new();
        for (index, chunk) in self.chunks.iter().enumerate() {
            if !touches(*chunk, view) {
                continue;
            }
            let start = (index * CHUNK) as u32;
            let end = (start + CHUNK as u32).min(self.segments);
            match runs.last_mut() {
                Some(last) if last.end == start => last.end = end,
                _ => runs.push(start..end),
            }
        }
        runs
    }

    fn new(tolerance_m: f32, vertices: &[Vertex]) -> Self {
        let segments = vertices.len().saturating_sub(1);
        // A chunk's last segment ends where the next chunk begins.
        let chunk = |start: usize| bounds(&vertices[start..vertices.len().min(start + CHUNK + 1)]);
        Self {
            tolerance_m,
            segments: segments as u32,
            chunks: (0..segments).step_by(CHUNK).map(chunk).collect(),
        }
    }
}

/// All levels, finest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LinePyramid {
    /// The levels.
    pub levels: Vec<LineLevel>,
}

/// Treatment of pieces that are smaller than a level resolves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Specks {
    /// Pieces stay, as a dot: a boat at anchor was there.
    Kept,
    /// Pieces are left out: many of them, as the isobaths of a rough bed have, would fill every
    /// level.
    Dropped,
}

impl LinePyramid {
    /// Builds all levels of a line and hands the vertices of each to `keep`.
    pub(crate) fn new(
        vertices: Vec<Vertex>,
        specks: Specks,
        mut keep: impl FnMut(&[Vertex]),
    ) -> Self {
        let mut tolerance_m = FINEST_M;
        let mut thinned = thin(&vertices, tolerance_m);
        drop(vertices);
        let mut levels = vec![LineLevel::new(tolerance_m, &thinned)];
        keep(&thinned);
        while thinned.len() > FEW {
            tolerance_m *= COARSER;
            let mut fewer = thin(&thinned, tolerance_m);
            if specks == Specks::Dropped {
                fewer = without_specks(&fewer, SPECK * tolerance_m);
            }
            // A level is worth its memory when it is much smaller than the one before.
            if 4 * fewer.len() < 3 * thinned.len() {
                levels.push(LineLevel::new(tolerance_m, &fewer));
                keep(&fewer);
                thinned = fewer;
            }
            if tolerance_m > 1e6 {
                break;
            }
        }
        Self { levels }
    }

    /// Returns the index of the level to draw when a pixel covers `metres_per_px`, and its visible
    /// runs. The tolerance of the level is a pixel and a half at most, unless more than `most`
    /// segments would be drawn.
    pub(crate) fn choose(
        &self,
        metres_per_px: f32,
        view: LayerBounds,
        most: u32,
    ) -> (usize, Vec<Range<u32>>) {
        let fine_enough = self
            .levels
            .iter()
            .rposition(|level| level.tolerance_m <= 1.5 * metres_per_px)
            .unwrap_or(0);
        let mut chosen = (fine_enough, Vec::new());
        for (index, level) in self.levels.iter().enumerate().skip(fine_enough) {
            let runs = level.visible(view);
            let count: u32 = runs.iter().map(|run| run.end - run.start).sum();
            chosen = (index, runs);
            if count <= most {
                break;
            }
        }
        chosen
    }
}

fn is_place(vertex: &Vertex) -> bool {
    vertex.place.iter().all(|c| c.is_finite())
}

/// Returns the line with fewer vertices: none nearer to the one before than `tolerance_m`, except
/// at breaks, and none on a straight piece of even colour.
fn thin(vertices: &[Vertex], tolerance_m: f32) -> Vec<Vertex> {
    straighten(&space_out(vertices, tolerance_m), 0.5 * tolerance_m)
}

/// Returns the pieces that extend over at least `least_m`.
fn without_specks(vertices: &[Vertex], least_m: f32) -> Vec<Vertex> {
    let extends = |piece: &&[Vertex]| {
        let [west, south, east, north] = bounds(piece);
        (east - west).max(north - south) >= least_m
    };
    let pieces = vertices.split(|vertex| !is_place(vertex));
    pieces
        .filter(extends)
        .flat_map(|piece| std::iter::once(Vertex::BREAK).chain(piece.iter().copied()))
        .collect()
}

/// Joins vertices nearer than `spacing_m` to the first of them, which takes their mean colour;
/// keeps breaks.
fn space_out(vertices: &[Vertex], spacing_m: f32) -> Vec<Vertex> {
    let mut kept: Vec<Vertex> = Vec::new();
    let mut colours = MeanColour::default();
    for (index, vertex) in vertices.iter().enumerate() {
        let near = kept.last().is_some_and(|last| distance(last, vertex) < spacing_m);
        // The end of a piece stays, however near: a break must not shorten the line.
        let ends = vertices.get(index + 1).is_none_or(|next| !is_place(next));
        if near && !ends {
            colours.add(vertex.colour);
            continue;
        }
        colours.give_to(kept.last_mut());
        if is_place(vertex) || kept.last().is_some_and(is_place) {
            let vertex = if is_place(vertex) { *vertex } else { Vertex::BREAK };
            kept.push(vertex);
            colours.add(vertex.colour);
        }
    }
    colours.give_to(kept.last_mut());
    kept
}

#[derive(Default)]
struct MeanColour {
    sum: [u32; 4],
    count: u32,
}

impl MeanColour {
    fn add(&mut self, colour: [u8; 4]) {
        for (sum, channel) in self.sum.iter_mut().zip(colour) {
            *sum += u32::from(channel);
        }
        self.count += 1;
    }

    fn give_to(&mut self, vertex: Option<&mut Vertex>) {
        if let Some(vertex) = vertex
            && self.count > 0
        {
            vertex.colour = self.sum.map(|sum| (sum / self.count) as u8);
        }
        *self = Self::default();
    }
}

/// Leaves out vertices that are within `off_m` of the straight line between their neighbours and
/// have the colour of this line there.
fn straighten(vertices: &[Vertex], off_m: f32) -> Vec<Vertex> {
    let Some(first) = vertices.first() else {
        return Vec::new();
    };
    let mut kept = vec![*first];
    let mut anchor = 0;
    while anchor + 1 < vertices.len() {
        let mut end = anchor + 1;
        while end + 1 < vertices.len()
            && end + 1 - anchor <= STRAIGHT
            && is_straight(&vertices[anchor..=end + 1], off_m)
        {
            end += 1;
        }
        kept.push(vertices[end]);
        anchor = end;
    }
    kept
}

fn is_straight(piece: &[Vertex], off_m: f32) -> bool {
    let [from, inner @ .., to] = piece else {
        return true;
    };
    if !is_place(from) || !is_place(to) {
        return false;
    }
    let [dx, dy] = [0, 1].map(|axis| to.place[axis] - from.place[axis]);
    let squared = (dx * dx + dy * dy).max(f32::MIN_POSITIVE);
    inner.iter().all(|vertex| {
        let [x, y] = [0, 1].map(|axis| vertex.place[axis] - from.place[axis]);
        let share = ((x * dx + y * dy) / squared).clamp(0.0, 1.0);
        let off = (x - share * dx).hypot(y - share * dy);
        let even = (0..4).all(|channel| {
            let [a, b, own] = [from, to, vertex].map(|v| f32::from(v.colour[channel]));
            (a + share * (b - a) - own).abs() <= EVEN_COLOUR
        });
        off <= off_m && even
    })
}

fn distance(a: &Vertex, b: &Vertex) -> f32 {
    (b.place[0] - a.place[0]).hypot(b.place[1] - a.place[1])
}

fn bounds(vertices: &[Vertex]) -> LayerBounds {
    let places = vertices.iter().filter(|vertex| is_place(vertex));
    places.fold(
        [f32::MAX, f32::MAX, f32::MIN, f32::MIN],
        |[l, b, r, t], Vertex { place: [x, y], .. }| [l.min(*x), b.min(*y), r.max(*x), t.max(*y)],
    )
}

fn touches(a: LayerBounds, b: LayerBounds) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: LayerBounds = [-1e9, -1e9, 1e9, 1e9];

    /// Returns the track of a weaving boat, on lines of 1000 vertices, 5 m apart.
    fn track(count: usize) -> Vec<Vertex> {
        (0..count)
            .map(|i| {
                let (line, along) = (i / 1000, (i % 1000) as f32 * 0.1);
                let weave = 0.4 * (i as f32 * 0.07).sin();
                Vertex {
                    place: [along, 5.0 * line as f32 + weave],
                    colour: [(i / 300 % 200) as u8, 0, 0, 255],
                }
            })
            .collect()
    }

    #[test]
    fn rings_too_small_to_see_go_where_they_would_be_specks() {
        // 400 rings of 0.3 m and one of 50 m.
        let ring = |east_m: f32, radius_m: f32| {
            let place = move |step: i32| {
                let (sin, cos) = (step as f32 * std::f32::consts::TAU / 40.0).sin_cos();
                Vertex { place: [east_m + radius_m * cos, radius_m * sin], colour: [255; 4] }
            };
            std::iter::once(Vertex::BREAK).chain((0..=40).map(place))
        };
        let small = (0..400).flat_map(|index| ring(index as f32, 0.15));
        let line: Vec<Vertex> = small.chain(ring(0.0, 25.0)).collect();
        let segments = |specks| {
            let pyramid = LinePyramid::new(line.clone(), specks, |_| ());
            let (level, runs) = pyramid.choose(1.0, ALL, u32::MAX);
            assert!(pyramid.levels[level].tolerance_m <= 1.5);
            runs.iter().map(|run| run.end - run.start).sum::<u32>()
        };
        let (all, seen) = (segments(Specks::Kept), segments(Specks::Dropped));
        assert!(all > 800, "{all}");
        assert!((20..100).contains(&seen), "{seen}");
    }

    /// Returns the pyramid, and the vertices of each of its levels.
    fn pyramid(line: &[Vertex]) -> (LinePyramid, Vec<Vec<Vertex>>) {
        let mut kept = Vec::new();
        let pyramid =
            LinePyramid::new(line.to_vec(), Specks::Kept, |vertices| kept.push(vertices.to_vec()));
        assert_eq!(kept.len(), pyramid.levels.len());
        (pyramid, kept)
    }

    fn off(segment: &[Vertex], [x, y]: [f32; 2]) -> f32 {
        let (from, to) = (segment[0].place, segment[1].place);
        let [dx, dy] = [0, 1].map(|axis| to[axis] - from[axis]);
        let [px, py] = [x - from[0], y - from[1]];
        let share = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (px - share * dx).hypot(py - share * dy)
    }

    #[test]
    fn a_straight_line_of_even_colour_needs_few_pieces_and_a_step_in_colour_stays() {
        let line: Vec<Vertex> = (0..10_000)
            .map(|i| Vertex {
                place: [0.1 * i as f32, 0.0],
                colour: if i < 5_000 { [0, 0, 0, 255] } else { [200, 0, 0, 255] },
            })
            .collect();
        let (pyramid, kept) = pyramid(&line);
        let coarsest = pyramid.levels.last().unwrap();
        assert!(coarsest.segments < 40, "{}", coarsest.segments);
        for (level, vertices) in pyramid.levels.iter().zip(&kept) {
            let step = vertices.iter().find(|v| v.colour[0] > 100).unwrap();
            assert!((step.place[0] - 500.0).abs() <= 2.0 * level.tolerance_m, "{step:?}");
        }
    }

    #[test]
    fn every_level_stays_within_its_tolerance_of_the_line() {
        let line = track(20_000);
        let (pyramid, kept) = pyramid(&line);
        assert!(pyramid.levels.len() > 3, "{}", pyramid.levels.len());
        for (level, vertices) in pyramid.levels.iter().zip(&kept) {
            for vertex in line.iter().step_by(37) {
                let nearest = vertices
                    .windows(2)
                    .map(|segment| off(segment, vertex.place))
                    .fold(f32::MAX, f32::min);
                assert!(nearest <= level.tolerance_m, "{nearest}");
            }
        }
    }

    #[test]
    fn what_is_drawn_does_not_grow_with_the_line() {
        let (pyramid, _) = pyramid(&track(300_000));
        let (_, runs) = pyramid.choose(0.001, ALL, 5_000);
        let drawn: u32 = runs.iter().map(|run| run.end - run.start).sum();
        assert!((500..=5_000).contains(&drawn), "{drawn}");
        let (level, runs) = pyramid.choose(0.001, [10.0, 10.0, 20.0, 20.0], 5_000);
        assert_eq!(level, 0);
        assert!(!runs.is_empty());
    }

    #[test]
    fn a_missing_place_breaks_the_line_in_every_level() {
        let mut line = track(2_000);
        line[500].place = [f32::NAN, f32::NAN];
        let (pyramid, kept) = pyramid(&line);
        for (level, vertices) in pyramid.levels.iter().zip(&kept) {
            let breaks = vertices.iter().filter(|vertex| !is_place(vertex));
            assert_eq!(breaks.count(), 1);
            let drawn = vertices.iter().filter(|vertex| vertex.colour[3] > 0);
            assert!(drawn.clone().all(is_place));
            assert_eq!(drawn.count() + 1, vertices.len());
            assert!(level.chunks.iter().flatten().all(|side| side.is_finite()));
        }
    }

    #[test]
    fn a_boat_at_anchor_and_an_empty_line_are_no_trouble() {
        let still = vec![Vertex { place: [1.0, 1.0], colour: [0; 4] }; 1_000];
        assert!(pyramid(&still).0.levels[0].segments <= 1);
        assert_eq!(pyramid(&[]).0.levels[0].segments, 0);
    }
}
