//! Whether a network runs on a graphics card: one picture is computed by both, and compared.

use super::device::Card;
use super::replace_layers;
use crate::detection::model::tract::Network;
use crate::detection::model::{Inference, Output, Unusable};
use crate::support::catch_panic::catch_panic;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};
use tract_onnx::prelude::TypedModel;

/// Pictures from which a card is looked for. To find and try one takes half a second, in which four cores compute 25.
pub(super) const MANY: usize = 100;
/// By how much of an output's greatest number what the card computes may differ from what the processor does. Sizes of boxes are exponentials:
/// on noise, those of the shipped network differ by 0.2 %.
const AGREES: f32 = 1e-2;
/// Pictures that a card is timed on, and how long at most: it takes some to leave its rest.
const TRIALS: usize = 10;
const TRIALS_TIME: Duration = Duration::from_millis(200);
/// `off` in it leaves the network to the processor, `on` asks for a card whatever the number of pictures, and however slow.
const SWITCH: &str = "BATHYSCOPE_GRAPHICS_CARD";

/// Which card is used, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// One that takes less time for many pictures.
    Worthwhile,
    /// One that there is.
    Any,
    /// The first adapter, even one that is made of software, for tests.
    #[cfg(test)]
    Software,
}

/// The network, which looks for a card before many pictures, unless the user has said otherwise. `graph` makes its graph once more.
pub(in super::super) fn placed(
    processor: Network,
    graph: impl FnOnce() -> Result<TypedModel, Unusable> + Send + 'static,
) -> Box<dyn Inference> {
    let switch = std::env::var_os(SWITCH);
    let choice = match switch.as_ref().and_then(|value| value.to_str()) {
        Some("off") => return Box::new(processor),
        Some("on") => Choice::Any,
        _ => Choice::Worthwhile,
    };
    Box::new(Placed::new(processor, graph, choice))
}

/// A network on the processor, or on a card once one was found to be worth it.
pub(super) struct Placed {
    processor: Network,
    graph: Mutex<Option<Graph>>,
    choice: Choice,
    /// What came of the look for a card; `None` in it where the computer has none.
    found: OnceLock<Option<Found>>,
}

type Graph = Box<dyn FnOnce() -> Result<TypedModel, Unusable> + Send>;

/// A card of the computer.
pub(super) struct Found {
    pub(super) name: String,
    pub(super) network: Option<Network>,
    /// Why it is not used.
    pub(super) fault: Mutex<Option<String>>,
}

impl Placed {
    pub(super) fn new(
        processor: Network,
        graph: impl FnOnce() -> Result<TypedModel, Unusable> + Send + 'static,
        choice: Choice,
    ) -> Self {
        Self {
            processor,
            graph: Mutex::new(Some(Box::new(graph))),
            choice,
            found: OnceLock::new(),
        }
    }

    /// The same with what came of a look for a card.
    #[cfg(test)]
    pub(super) fn with(self, found: Found) -> Self {
        Self {
            found: OnceLock::from(Some(found)),
            ..self
        }
    }

    fn look(&self) -> Option<Found> {
        let card = match card(self.choice) {
            Some(card) => card,
            None if self.choice == Choice::Worthwhile => return None,
            None => {
                return Some(Found::unused(
                    "a graphics card",
                    "none was found".to_owned(),
                ));
            }
        };
        let name = card.name().to_owned();
        let graph = self
            .graph
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        // A driver may fail in any way.
        let tried = catch_panic(|| graph.map(|graph| self.tried(graph, card)));
        Some(match tried.flatten() {
            Some(Ok(network)) => Found {
                name,
                network: Some(network),
                fault: Mutex::default(),
            },
            Some(Err(fault)) => Found::unused(&name, fault),
            None => Found::unused(&name, "its driver failed".to_owned()),
        })
    }

    /// The network on a card that computes what the processor does, in less time; else why not.
    fn tried(&self, graph: Graph, card: Arc<Card>) -> Result<Network, String> {
        let mut graph = graph().map_err(|error| error.to_string())?;
        let in_words = |error: Unusable| error.to_string();
        replace_layers(&mut graph, card).map_err(|error| format!("{error:#}"))??;
        let network = self
            .processor
            .with(graph)
            .map_err(|error| format!("{error:#}"))?;
        let trial: Vec<f32> = (0..self.processor.count()).map(trial_number).collect();
        let start = Instant::now();
        let expected = self.processor.run(trial.clone()).map_err(in_words)?;
        let processor_s = start.elapsed().as_secs_f64() / rayon::current_num_threads() as f64;
        let found = network.run(trial.clone()).map_err(in_words)?;
        let share = difference(&expected, &found);
        if share > AGREES {
            return Err(format!("its numbers differ by {:.2} %", 100.0 * share));
        }
        let card_s = least_time(|| network.run(trial.clone())).map_err(in_words)?;
        match card_s < processor_s || self.choice != Choice::Worthwhile {
            true => Ok(network),
            false => Err(format!(
                "it takes {:.1} ms a picture, the processor {:.1} ms",
                1e3 * card_s,
                1e3 * processor_s
            )),
        }
    }
}

impl Found {
    fn unused(name: &str, fault: String) -> Self {
        Self {
            name: name.to_owned(),
            network: None,
            fault: Mutex::new(Some(fault)),
        }
    }

    fn fault(&self) -> Option<String> {
        self.fault
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl Inference for Placed {
    fn run(&self, input: Vec<f32>) -> Result<Vec<Output>, Unusable> {
        let found = self.found.get().and_then(Option::as_ref);
        let used = found.filter(|found| found.fault().is_none());
        let Some((found, network)) = used.and_then(|used| Some((used, used.network.as_ref()?)))
        else {
            return self.processor.run(input);
        };
        network.run(input.clone()).or_else(|error| {
            let mut fault = found.fault.lock().unwrap_or_else(PoisonError::into_inner);
            *fault = Some(error.to_string());
            drop(fault);
            self.processor.run(input)
        })
    }

    fn prepare(&self, pictures: usize) {
        if pictures >= MANY || self.choice != Choice::Worthwhile {
            self.found.get_or_init(|| self.look());
        }
    }

    #[cfg(feature = "bench")]
    fn keep_to_processor(&self) {
        self.found.set(None).ok();
    }

    fn runs_on(&self) -> Option<String> {
        let found = self.found.get()?.as_ref()?;
        let name = &found.name;
        Some(match found.fault() {
            Some(fault) => format!("run by the processor, not by {name}: {fault}"),
            None => format!("run by {name}"),
        })
    }
}

/// The card of a choice.
pub(super) fn card(choice: Choice) -> Option<Arc<Card>> {
    // Opened once: a driver takes a tenth of a second.
    static HARDWARE: LazyLock<Option<Arc<Card>>> = LazyLock::new(|| {
        let open = || Card::may_be_there().then(|| Card::open(Card::is_hardware));
        catch_panic(open).flatten().flatten().map(Arc::new)
    });
    match choice {
        Choice::Worthwhile | Choice::Any => HARDWARE.clone(),
        #[cfg(test)]
        Choice::Software => Card::open(|_| true).map(Arc::new),
    }
}

/// Numbers of a picture that shows something everywhere.
pub(super) fn trial_number(at: usize) -> f32 {
    (at.wrapping_mul(2_654_435_761) >> 16 & 255) as f32 / 255.0
}

/// The least time of some runs, seconds.
fn least_time<T, E>(run: impl Fn() -> Result<T, E>) -> Result<f64, E> {
    let start = Instant::now();
    let mut least = Duration::MAX;
    for _ in 0..TRIALS {
        let begun = Instant::now();
        run()?;
        least = least.min(begun.elapsed());
        if start.elapsed() > TRIALS_TIME {
            break;
        }
    }
    Ok(least.as_secs_f64())
}

/// By how much of an output's greatest number others differ from it, at most; infinity where one is no number.
pub(super) fn difference(expected: &[Output], found: &[Output]) -> f32 {
    let greatest = |most: f32, number: f32| match number.is_nan() {
        true => f32::INFINITY,
        false => most.max(number.abs()),
    };
    let of_output = |(one, other): (&Output, &Output)| {
        let pairs = one.values.iter().zip(&other.values);
        let differ = pairs.map(|(a, b)| a - b).fold(0.0, greatest);
        let most = one.values.iter().copied().fold(f32::MIN_POSITIVE, greatest);
        differ / most
    };
    expected
        .iter()
        .zip(found)
        .map(of_output)
        .fold(0.0, greatest)
}
