//! Chooses the graphics adapter: the first that opens a device. A driver may be listed and then
//! fail to open one, as DirectX 12 does over some software drivers, where Vulkan on the same
//! computer works.

use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use std::future::Future;
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll, Wake, Waker};
use wgpu::{Adapter, DeviceType, PowerPreference, Surface};

/// Returns the graphics setup for the window and for pictures drawn without it.
pub(super) fn setup() -> WgpuSetup {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    let descriptor = Arc::clone(&setup.device_descriptor);
    let preference = setup.power_preference;
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let shows =
            |surface: &Surface<'_>, adapter: &Adapter| adapter.is_surface_supported(surface);
        let mut usable: Vec<Adapter> = adapters.to_vec();
        usable.retain(|adapter| surface.is_none_or(|surface| shows(surface, adapter)));
        usable.sort_by_key(|adapter| rank(adapter.get_info().device_type, preference));
        first_that_opens(usable, |adapter| {
            let device = block_on(adapter.request_device(&descriptor(adapter)));
            device.map(drop).map_err(|error| {
                let info = adapter.get_info();
                format!("{} ({}): {error}", info.name, info.backend)
            })
        })
    }));
    setup.into()
}

/// Returns the rank of an adapter: lower ranks are tried first, and adapters of the same rank in
/// the order in which the drivers list them.
fn rank(kind: DeviceType, preference: PowerPreference) -> u8 {
    match (kind, preference) {
        (DeviceType::DiscreteGpu, PowerPreference::LowPower) => 2,
        (DeviceType::DiscreteGpu, _) => 0,
        (DeviceType::IntegratedGpu, _) => 1,
        (DeviceType::VirtualGpu | DeviceType::Other, _) => 3,
        (DeviceType::Cpu, _) => 4,
    }
}

/// Returns the first candidate that `opens` accepts. A single candidate is returned without a
/// trial: whoever opens it later reports its fault.
///
/// # Errors
/// When no candidate opens: the faults of all of them.
fn first_that_opens<T>(
    mut candidates: Vec<T>,
    opens: impl Fn(&T) -> Result<(), String>,
) -> Result<T, String> {
    if candidates.len() == 1 {
        return Ok(candidates.remove(0));
    }
    let mut faults = Vec::new();
    for candidate in candidates {
        match opens(&candidate) {
            Ok(()) => return Ok(candidate),
            Err(fault) => faults.push(fault),
        }
    }
    Err(match faults.as_slice() {
        [] => "no driver was found".to_owned(),
        faults => faults.join("; "),
    })
}

/// Blocks this thread until a future is ready and returns its output. No async runtime is needed:
/// only requests for adapters and devices are async here.
pub(super) fn block_on<F: Future>(future: F) -> F::Output {
    struct Unpark(std::thread::Thread);
    impl Wake for Unpark {
        fn wake(self: Arc<Self>) {
            self.0.unpark();
        }
    }
    let waker = Waker::from(Arc::new(Unpark(std::thread::current())));
    let mut context = Context::from_waker(&waker);
    let mut future = pin!(future);
    loop {
        match future.as_mut().poll(&mut context) {
            Poll::Ready(value) => return value,
            Poll::Pending => std::thread::park(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_that_opens_is_taken_and_the_faults_of_all_are_told() {
        let opens =
            |name: &&str| if name.contains("good") { Ok(()) } else { Err(format!("{name} fails")) };
        let choose = |names: &[&'static str]| first_that_opens(names.to_vec(), opens);
        assert_eq!(choose(&["bad", "good", "good too"]), Ok("good"));
        assert_eq!(choose(&["bad"]), Ok("bad"), "nothing to choose");
        assert_eq!(choose(&["bad", "worse"]), Err("bad fails; worse fails".to_owned()));
        assert_eq!(choose(&[]), Err("no driver was found".to_owned()));
    }

    #[test]
    fn a_card_is_tried_before_the_processor_and_the_one_that_is_preferred_first() {
        let (high, low) = (PowerPreference::HighPerformance, PowerPreference::LowPower);
        assert!(rank(DeviceType::DiscreteGpu, high) < rank(DeviceType::IntegratedGpu, high));
        assert!(rank(DeviceType::IntegratedGpu, low) < rank(DeviceType::DiscreteGpu, low));
        assert!(rank(DeviceType::DiscreteGpu, low) < rank(DeviceType::Cpu, low));
    }
}
