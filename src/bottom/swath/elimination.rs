//! The order in which the unknowns of a tile are eliminated: nested dissection (George 1973).
//!
//! Equations tie nodes at most two steps apart, so two rows or columns of nodes part the others
//! into sides that share no equation. Each side is eliminated first, in the same way, and the two
//! rows after both. What is of no node, which is tied to many, comes last.

use super::nodes::Nodes;
use std::ops::Range;

/// Rows that part two sides.
const BETWEEN: usize = 2;
/// Parts of no more rows and columns are not parted further.
const LEAST_PARTED: usize = 5;

/// Returns an order of `unknowns` unknowns: `each` of every node come first, those of one kind
/// before those of the next.
pub(super) fn order(nodes: &Nodes, each: usize, unknowns: usize) -> Vec<u32> {
    let mut of_nodes = Vec::with_capacity(nodes.len());
    part(nodes, nodes.counts.map(|count| 0..count), &mut of_nodes);
    let of_node = |node: usize| (0..each).map(move |kind| kind * nodes.len() + node);
    let all = of_nodes.into_iter().flat_map(of_node);
    all.chain(each * nodes.len()..unknowns).map(|unknown| unknown as u32).collect()
}

/// Adds the nodes of some columns and rows.
fn part(nodes: &Nodes, spans: [Range<usize>; 2], order: &mut Vec<usize>) {
    let axis = usize::from(spans[1].len() > spans[0].len());
    let Range { start, end } = spans[axis];
    let with = |span: Range<usize>| {
        let mut spans = spans.clone();
        spans[axis] = span;
        spans
    };
    let mut last = start..end;
    if end - start > LEAST_PARTED {
        let from = start + (end - start - BETWEEN) / 2;
        last = from..from + BETWEEN;
        part(nodes, with(start..last.start), order);
        part(nodes, with(last.end..end), order);
    }
    let [columns, rows] = with(last);
    for row in rows {
        order.extend(columns.clone().map(|column| row * nodes.counts[0] + column));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::{Equations, Pattern};

    const NODES: Nodes = Nodes { zero_m: [0.0; 2], first: [0; 2], step_m: 0.8, counts: [64, 50] };

    #[test]
    fn all_unknowns_are_eliminated_and_little_is_filled_in() {
        let (each, gains) = (2 * NODES.len(), 10);
        let mut equations = Equations::default();
        for node in 0..NODES.len() {
            let around = NODES.neighbours(node).map(|other| (other, -1.0));
            equations.add([(node, 4.6)].into_iter().chain(around), 0.0, 1.0);
            let echo = [(node, 1.0), (NODES.len() + node, 1.0)];
            let gain = (each + node % gains, 1.0);
            equations.add(echo.into_iter().chain([gain]), 0.0, 1.0);
        }
        let found = order(&NODES, 2, each + gains);
        let mut sorted = found.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..(each + gains) as u32));
        let in_rows: Vec<u32> = (0..NODES.len())
            .flat_map(|node| [node, NODES.len() + node])
            .chain(each..each + gains)
            .map(|unknown| unknown as u32)
            .collect();
        let [found, in_rows] = [found, in_rows]
            .map(|order| Pattern::in_order(&equations, order).unwrap().factor_len());
        assert!(3 * found < 2 * in_rows, "{found} {in_rows}");
    }
}
