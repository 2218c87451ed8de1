//! The real window, on a virtual X display whose framebuffer the test reads: the one test that goes
//! through the window system, the swap chain and the event loop, which the harness of the other UI
//! tests replaces.

use std::collections::HashSet;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A process that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Starts Xvfb with its framebuffer in `folder`; `None` where it is not installed.
fn virtual_display(folder: &Path) -> Option<(Running, String)> {
    let spawned = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-fbdir"])
        .arg(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let Ok(mut child) = spawned else {
        eprintln!("skipped: Xvfb is not installed");
        return None;
    };
    let stdout = child.stdout.take().expect("a piped stdout");
    let server = Running(child);
    let mut number = String::new();
    BufReader::new(stdout).read_line(&mut number).expect("Xvfb tells its display");
    Some((server, format!(":{}", number.trim())))
}

/// Distinct colours on the screen: the XWD file has a header of big-endian u32 words, a colour
/// table, then the pixels.
fn colours_on_screen(folder: &Path) -> Option<usize> {
    let dump = std::fs::read(folder.join("Xvfb_screen0")).ok()?;
    let word = |index: usize| {
        Some(u32::from_be_bytes(dump.get(4 * index..4 * index + 4)?.try_into().ok()?))
    };
    let (header_size, colour_entries) = (word(0)? as usize, word(19)? as usize);
    let pixels = dump.get(header_size + 12 * colour_entries..)?;
    let colours: HashSet<&[u8]> = pixels.chunks_exact(4).map(|pixel| &pixel[..3]).collect();
    Some(colours.len())
}

#[test]
fn the_window_opens_on_the_demo_and_draws_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some((_server, display)) = virtual_display(folder.path()) else {
        return;
    };
    let mut window = Running(
        Command::new(crate::support::program())
            .arg("--demo")
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_DATA_HOME", folder.path())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts"),
    );
    // A waterfall in copper, depth colours and text: far more colours than an empty window has.
    let deadline = Instant::now() + bathyscope_test_support::PATIENCE;
    let mut seen = 0;
    while Instant::now() < deadline && seen < 500 {
        assert!(window.0.try_wait().expect("a child").is_none(), "the window closed by itself");
        std::thread::sleep(Duration::from_millis(300));
        seen = colours_on_screen(folder.path()).unwrap_or(0);
    }
    assert!(seen >= 500, "only {seen} colours on the screen");
}
