//! `Bathyscope.exe` of the packages for Windows: starts `bin\bathyscope.exe` with its own
//! arguments, and no console window comes with it. It is a program of its own, for Windows lets a
//! program either have a console or not. `build` beside it compiles it.
#![windows_subsystem = "windows"]

use std::ffi::c_void;
use std::os::windows::process::CommandExt as _;
use std::process::{Command, ExitCode};
use std::{env, io, ptr};

const CREATE_NO_WINDOW: u32 = 0x0800_0000;
const MB_ICONERROR: u32 = 0x10;

#[link(name = "user32")]
unsafe extern "system" {
    fn MessageBoxW(owner: *const c_void, text: *const u16, title: *const u16, kind: u32) -> i32;
}

fn main() -> ExitCode {
    match start() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!(
                "Bathyscope cannot be started: {error} Install it again, or unpack the whole archive: the folder bin is a part of it."
            ));
            ExitCode::FAILURE
        }
    }
}

/// Starts the program, which reports later errors itself.
fn start() -> io::Result<()> {
    let program = env::current_exe()?
        .with_file_name("bin")
        .join("bathyscope.exe");
    let mut command = Command::new(program);
    command
        .args(env::args_os().skip(1))
        // What it cannot do it says in a box: src/cli/mod.rs.
        .env("BATHYSCOPE_NO_CONSOLE", "1")
        .creation_flags(CREATE_NO_WINDOW)
        .spawn()?;
    Ok(())
}

fn say(sentence: &str) {
    let [text, title] =
        [sentence, "Bathyscope"].map(|text| text.encode_utf16().chain([0]).collect::<Vec<u16>>());
    // SAFETY: both texts end with a zero and outlive the call.
    unsafe {
        MessageBoxW(ptr::null(), text.as_ptr(), title.as_ptr(), MB_ICONERROR);
    }
}
