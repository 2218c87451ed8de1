//! Searches for the parameters with the least cost.

use super::problem::{FitState, OutlineEdge, Problem};

/// Changes one parameter after the other, with a larger step after an improvement and a smaller one
/// otherwise, and then repeats the change of the whole round (Hooke and Jeeves). No derivatives are
/// used, because predictions have kinks.
pub(super) fn search(problem: &Problem<'_>, state: &mut FitState, rounds: usize) {
    let mut trial = state.clone();
    for _ in 0..rounds {
        let before = state.numbers.clone();
        for number in (0..before.len()).filter(|number| !problem.is_fixed(*number)) {
            let step = state.steps[number];
            let better = try_both_ways(state, &mut trial, step, |trial, by| {
                problem.change(trial, number, by);
            });
            state.steps[number] = step * if better { 1.3 } else { 0.5 };
        }
        for (index, edge) in OutlineEdge::ALL.into_iter().enumerate() {
            let step = state.edge_steps[index];
            let move_edge = |trial: &mut FitState, by: f64| problem.move_edge(trial, edge, by);
            let better = step > 0.0 && try_both_ways(state, &mut trial, step, move_edge);
            state.edge_steps[index] = step * if better { 1.3 } else { 0.5 };
        }
        // If the round changed nothing, there is no direction to continue in.
        if state.numbers != before {
            go_on(problem, state, &mut trial, &before);
        }
        if state.is_settled() {
            break;
        }
    }
}

/// Moves all numbers once more as they have moved since `before`, if that lowers the cost.
fn go_on(problem: &Problem<'_>, state: &mut FitState, trial: &mut FitState, before: &[f64]) {
    trial.copy_from(state);
    for (number, before) in trial.numbers.iter_mut().zip(before) {
        *number += *number - before;
    }
    problem.all(trial);
    if trial.cost < state.cost {
        std::mem::swap(state, trial);
    }
}

/// Changes a state by a step, or by the same step in the other direction, if that lowers the cost.
/// Returns true if the state was changed.
fn try_both_ways(
    state: &mut FitState,
    trial: &mut FitState,
    step: f64,
    change: impl Fn(&mut FitState, f64),
) -> bool {
    let better = [step, -step].into_iter().any(|by| {
        trial.copy_from(state);
        change(trial, by);
        trial.cost < state.cost
    });
    if better {
        std::mem::swap(state, trial);
    }
    better
}

/// Searches on from the `most` best states for some rounds, and drops the others. The states are
/// then sorted, the best first.
pub(super) fn follow(
    problem: &Problem<'_>,
    states: &mut Vec<FitState>,
    most: usize,
    rounds: usize,
) {
    let by_cost = |a: &FitState, b: &FitState| a.cost.total_cmp(&b.cost);
    states.sort_by(by_cost);
    states.truncate(most);
    for state in &mut *states {
        search(problem, state, rounds);
    }
    states.sort_by(by_cost);
}
