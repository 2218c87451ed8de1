//! Isobaths: the cuts of one level, joined.

use super::march::{CellEdge, crossing, square};
use crate::bathymetry::Surface;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;

/// A line of equal depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Isobath {
    /// Its depth, metres.
    pub depth_m: f64,
    /// East and north, metres, with the deeper side on the left; a ring ends where it began.
    pub points: Vec<[f64; 2]>,
}

impl Isobath {
    /// Returns true if it ends where it began.
    pub fn is_ring(&self) -> bool {
        self.points.len() > 3 && self.points.first() == self.points.last()
    }

    /// Metres along it.
    pub fn length_m(&self) -> f64 {
        let steps = self.points.windows(2);
        steps.map(|step| (step[1][0] - step[0][0]).hypot(step[1][1] - step[0][1])).sum()
    }
}

/// The isobaths of a surface at some depths, in the order of these. Lines end where the surface
/// ends: none follows its edge.
///
/// # Errors
/// When the work was cancelled.
pub fn isobaths(
    surface: &Surface,
    levels_m: &[f64],
    progress: &Progress,
) -> Result<Vec<Isobath>, Cancelled> {
    progress.start(levels_m.len() as u64);
    let drawn: Vec<Vec<Isobath>> = levels_m
        .par_iter()
        .map(|&level_m| {
            let cuts = cuts(surface, level_m, progress)?;
            progress.advance(1);
            let lines = join(&cuts).into_iter();
            Ok(lines.filter_map(|edges| place(surface, level_m, &edges)).collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(drawn.into_iter().flatten().collect())
}

fn cuts(
    surface: &Surface,
    level_m: f64,
    progress: &Progress,
) -> Result<Vec<[CellEdge; 2]>, Cancelled> {
    let mut cuts = Vec::new();
    for row in 0..surface.grid.rows {
        progress.check()?;
        for column in 0..surface.grid.columns {
            if let Some(square) = square(surface, row, column) {
                cuts.extend(square.cuts(level_m).into_iter().flatten());
            }
        }
    }
    Ok(cuts)
}

/// Cuts joined at the edges that they share. On every edge at most one cut ends and one begins.
pub(super) fn join<E: Copy + Eq + Hash>(cuts: &[[E; 2]]) -> Vec<Vec<E>> {
    let mut next: HashMap<E, E> = cuts.iter().map(|[from, to]| (*from, *to)).collect();
    let ends: HashSet<E> = cuts.iter().map(|[_, to]| *to).collect();
    let begins = || cuts.iter().map(|[from, _]| *from);
    let mut lines = Vec::new();
    // Open lines first, so that what is left is rings.
    for begin in begins().filter(|from| !ends.contains(from)).chain(begins()) {
        let mut line = vec![begin];
        let mut at = begin;
        while let Some(to) = next.remove(&at) {
            line.push(to);
            at = to;
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

/// `None` where all of a ring is one place: a summit that just touches the level.
fn place(surface: &Surface, level_m: f64, edges: &[CellEdge]) -> Option<Isobath> {
    let mut points: Vec<[f64; 2]> =
        edges.iter().map(|edge| crossing(surface, *edge, level_m)).collect();
    // A line through the centre of a cell crosses several edges there.
    points.dedup();
    (points.len() > 1).then_some(Isobath { depth_m: level_m, points })
}
