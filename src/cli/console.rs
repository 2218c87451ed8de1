//! The console that Windows opens for this program where it is started from the desktop, and that nobody needs.

#[cfg(windows)]
#[allow(unsafe_code)]
#[link(name = "kernel32")]
unsafe extern "system" {
    /// How many processes share this one's console; as many numbers of them as there is room for. None where there is no console.
    fn GetConsoleProcessList(processes: *mut u32, room: u32) -> u32;
    /// Takes this process from its console, which closes when nobody is left.
    fn FreeConsole() -> i32;
}

/// Whether nobody reads what is written to the console: it is this program's own, and closes with it. Never so but on Windows.
pub(super) fn is_own() -> bool {
    #[cfg(windows)]
    {
        let mut processes = [0; 2];
        // SAFETY: the system writes no more numbers than it is told that there is room for.
        #[allow(unsafe_code)]
        let sharing = unsafe { GetConsoleProcessList(processes.as_mut_ptr(), 2) };
        sharing <= 1
    }
    #[cfg(not(windows))]
    false
}

/// Closes the console if it is this program's own. What is written from then on goes nowhere.
pub(super) fn leave_own() {
    #[cfg(windows)]
    if is_own() {
        // SAFETY: nothing is handed over, and nothing here keeps a handle of the console.
        #[allow(unsafe_code)]
        unsafe {
            FreeConsole();
        }
    }
}
