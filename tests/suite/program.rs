//! The program starts and names its commands.

use std::process::Command;

#[test]
fn the_program_names_its_commands() {
    let output = Command::new(env!("CARGO_BIN_EXE_bathyscope"))
        .arg("--help")
        .output()
        .expect("the program starts");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success());
    for command in
        ["info", "process", "snapshot", "simulate", "filter", "compare", "detect", "evaluate"]
    {
        assert!(text.contains(&format!("\n  {command} ")), "no {command}: {text}");
    }
}
