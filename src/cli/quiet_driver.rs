//! Keeps a graphics driver's remarks off stderr.

/// Mesa's environment variable that leaves out its layer for choosing among adapters. Without a
/// display there is nothing that it could ask, and it complains about a missing `XDG_RUNTIME_DIR`
/// at every look.
#[cfg(target_os = "linux")]
const NO_CHOICE: &str = "NODEVICE_SELECT";

/// Starts the program anew in the same process, with the same arguments and the variable set, where
/// the driver would complain. Returns where it would not, or where starting anew fails: then it
/// complains, and all else works.
pub(super) fn restart_if_noisy() {
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::process::CommandExt as _;
        let is_set = |name: &str| std::env::var_os(name).is_some();
        if is_set("XDG_RUNTIME_DIR") || is_set(NO_CHOICE) {
            return;
        }
        let mut arguments = std::env::args_os();
        let name = arguments.next().unwrap_or_default();
        // Whatever has become of the file that it was started from meanwhile.
        let error = std::process::Command::new("/proc/self/exe")
            .arg0(name)
            .args(arguments)
            .env(NO_CHOICE, "1")
            .exec();
        drop(error);
    }
}
