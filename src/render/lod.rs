//! Levels of detail of a long coloured line: what is drawn does not grow with what was recorded.

use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// A place on the line and its colour; a NaN place breaks the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Metres, relative to an origin near the line.
    pub place: [f32; 2],
    /// sRGB and alpha.
    pub colour: [u8; 4],
}

/// One straight piece, as the shader reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Segment {
    /// From, metres.
    pub from: [f32; 2],
    /// To, metres.
    pub to: [f32; 2],
    /// Colour at the start.
    pub from_colour: [u8; 4],
    /// Colour at the end.
    pub to_colour: [u8; 4],
}

/// A box: low x, low y, high x, high y.
pub type Bounds = [f32; 4];

/// Segments of a chunk.
const CHUNK: usize = 512;
/// Spacing of the vertices of the finest level, metres: below what a position fix can tell.
const FINEST_M: f32 = 0.02;
/// From level to level.
const COARSER: f32 = 2.0;
/// Levels stop here.
const FEW: usize = 256;

/// The line with vertices no nearer to each other than its tolerance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineLevel {
    /// Distance that was dropped, metres.
    pub tolerance_m: f32,
    /// All pieces in order.
    pub segments: Vec<Segment>,
    /// Box of each [`CHUNK`] segments.
    pub chunks: Vec<Bounds>,
}

impl LineLevel {
    /// The runs of segments whose chunks touch the view; neighbours are joined.
    pub fn visible(&self, view: Bounds) -> Vec<Range<u32>> {
        let mut runs: Vec<Range<u32>> = Vec::new();
        for (index, chunk) in self.chunks.iter().enumerate() {
            if !touches(*chunk, view) {
                continue;
            }
            let start = (index * CHUNK) as u32;
            let end = (start + CHUNK as u32).min(self.segments.len() as u32);
            match runs.last_mut() {
                Some(last) if last.end == start => last.end = end,
                _ => runs.push(start..end),
            }
        }
        runs
    }

    fn new(tolerance_m: f32, vertices: &[Vertex]) -> Self {
        let segments: Vec<Segment> = vertices
            .windows(2)
            .filter(|pair| is_place(&pair[0]) && is_place(&pair[1]))
            .map(|pair| Segment {
                from: pair[0].place,
                to: pair[1].place,
                from_colour: pair[0].colour,
                to_colour: pair[1].colour,
            })
            .collect();
        let chunks = segments.chunks(CHUNK).map(bounds).collect();
        Self {
            tolerance_m,
            segments,
            chunks,
        }
    }
}

/// All levels, finest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinePyramid {
    /// The levels.
    pub levels: Vec<LineLevel>,
}

impl LinePyramid {
    /// Builds all levels of a line.
    pub fn new(vertices: &[Vertex]) -> Self {
        let mut tolerance_m = FINEST_M;
        let mut thinned = thin(vertices, tolerance_m);
        let mut levels = vec![LineLevel::new(tolerance_m, &thinned)];
        while thinned.len() > FEW {
            tolerance_m *= COARSER;
            let fewer = thin(&thinned, tolerance_m);
            // A level is worth its memory when it is much smaller than the one before.
            if 4 * fewer.len() < 3 * thinned.len() {
                levels.push(LineLevel::new(tolerance_m, &fewer));
                thinned = fewer;
            }
            if tolerance_m > 1e6 {
                break;
            }
        }
        Self { levels }
    }

    /// Index of the level to draw when a pixel covers `metres_per_px`, and its visible runs: nothing coarser than a pixel
    /// unless more than `most` segments would be drawn.
    pub fn choose(&self, metres_per_px: f32, view: Bounds, most: u32) -> (usize, Vec<Range<u32>>) {
        let fine_enough = self
            .levels
            .iter()
            .rposition(|level| level.tolerance_m <= metres_per_px)
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

/// Drops vertices nearer than `tolerance_m` to the last one kept; keeps breaks, and the last vertex before each.
fn thin(vertices: &[Vertex], tolerance_m: f32) -> Vec<Vertex> {
    let mut kept: Vec<Vertex> = Vec::new();
    let mut dropped: Option<Vertex> = None;
    for vertex in vertices {
        let last = kept.last().copied();
        let near = last.is_some_and(|last| {
            let [dx, dy] = [0, 1].map(|axis| vertex.place[axis] - last.place[axis]);
            dx * dx + dy * dy < tolerance_m * tolerance_m
        });
        if near {
            dropped = Some(*vertex);
            continue;
        }
        if !is_place(vertex) {
            if last.is_none_or(|last| !is_place(&last)) {
                continue;
            }
            kept.extend(dropped);
        }
        dropped = None;
        kept.push(*vertex);
    }
    kept.extend(dropped);
    kept
}

fn bounds(segments: &[Segment]) -> Bounds {
    let ends = segments
        .iter()
        .flat_map(|segment| [segment.from, segment.to]);
    ends.fold(
        [f32::MAX, f32::MAX, f32::MIN, f32::MIN],
        |[l, b, r, t], [x, y]| [l.min(x), b.min(y), r.max(x), t.max(y)],
    )
}

fn touches(a: Bounds, b: Bounds) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Bounds = [-1e9, -1e9, 1e9, 1e9];

    fn spiral(count: usize) -> Vec<Vertex> {
        (0..count)
            .map(|i| {
                let turn = i as f32 * 0.001;
                Vertex {
                    place: [turn * turn.cos(), turn * turn.sin()],
                    colour: [0, 0, 0, 255],
                }
            })
            .collect()
    }

    #[test]
    fn every_level_stays_within_its_tolerance_of_the_line() {
        let line = spiral(20_000);
        let pyramid = LinePyramid::new(&line);
        assert!(pyramid.levels.len() > 3);
        for level in &pyramid.levels {
            for vertex in line.iter().step_by(37) {
                let nearest = level
                    .segments
                    .iter()
                    .flat_map(|s| [s.from, s.to])
                    .map(|p| (p[0] - vertex.place[0]).hypot(p[1] - vertex.place[1]))
                    .fold(f32::MAX, f32::min);
                assert!(nearest <= 2.0 * level.tolerance_m, "{nearest}");
            }
        }
    }

    #[test]
    fn what_is_drawn_does_not_grow_with_the_line() {
        let pyramid = LinePyramid::new(&spiral(300_000));
        let (_, runs) = pyramid.choose(0.001, ALL, 5_000);
        let drawn: u32 = runs.iter().map(|run| run.end - run.start).sum();
        assert!((500..=5_000).contains(&drawn), "{drawn}");
        let (level, runs) = pyramid.choose(0.001, [0.0, 0.0, 0.5, 0.5], 5_000);
        assert_eq!(level, 0);
        assert!(runs.iter().all(|run| run.end > run.start));
    }

    #[test]
    fn a_missing_place_breaks_the_line_in_every_level() {
        let mut line = spiral(2_000);
        line[1_000].place = [f32::NAN, f32::NAN];
        let pyramid = LinePyramid::new(&line);
        for level in &pyramid.levels {
            let ends = level.segments.iter().flat_map(|s| [s.from, s.to]);
            assert!(ends.flatten().all(f32::is_finite));
        }
        let finest = &pyramid.levels[0];
        let breaks = finest
            .segments
            .windows(2)
            .filter(|pair| pair[0].to != pair[1].from);
        assert_eq!(breaks.count(), 1);
    }

    #[test]
    fn a_boat_at_anchor_and_an_empty_line_are_no_trouble() {
        let still = vec![
            Vertex {
                place: [1.0, 1.0],
                colour: [0; 4]
            };
            1_000
        ];
        assert!(LinePyramid::new(&still).levels[0].segments.len() <= 1);
        assert!(LinePyramid::new(&[]).levels[0].segments.is_empty());
    }
}
