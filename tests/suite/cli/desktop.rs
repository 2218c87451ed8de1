//! `bathyscope desktop`, in a user's folder of its own.

use std::fs;
use std::path::Path;
use std::process::Command;

fn desktop(data: &Path, args: &[&str]) -> String {
    let run = Command::new(env!("CARGO_BIN_EXE_bathyscope"))
        .arg("desktop")
        .args(args)
        .env("XDG_DATA_HOME", data)
        .output()
        .expect("the program");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    String::from_utf8(run.stdout).expect("text")
}

#[test]
fn an_entry_and_file_types_are_written_and_removed() {
    let temporary = tempfile::tempdir().expect("a folder");
    let data = temporary.path();
    let [entry, types] = [
        "applications/bathyscope.desktop",
        "mime/packages/bathyscope.xml",
    ];
    let text = desktop(data, &[]);
    assert!(text.contains(entry) && text.contains(types), "{text}");
    let text = fs::read_to_string(data.join(entry)).expect("an entry");
    let program = fs::canonicalize(env!("CARGO_BIN_EXE_bathyscope")).expect("the program");
    let program = program.display();
    assert!(text.contains(&format!("Exec=\"{program}\" %F\n")), "{text}");
    let xml = fs::read_to_string(data.join(types)).expect("types");
    let named: Vec<&str> = xml
        .split("mime-type type=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    let of_entry = text
        .lines()
        .find_map(|line| line.strip_prefix("MimeType="))
        .expect("types");
    assert_eq!(
        of_entry
            .trim_end_matches(';')
            .split(';')
            .collect::<Vec<_>>(),
        named
    );
    // Where the desktop's own programs are there, they are asked.
    if let Ok(checked) = Command::new("desktop-file-validate")
        .arg(data.join(entry))
        .output()
    {
        assert!(
            checked.status.success(),
            "{}",
            String::from_utf8_lossy(&checked.stdout)
        );
    }
    if Command::new("update-mime-database")
        .arg("-v")
        .output()
        .is_ok()
    {
        let globs = fs::read_to_string(data.join("mime/globs2")).expect("file types");
        assert!(
            globs.contains("application/x-bathyscope:*.bathyscope"),
            "{globs}"
        );
    }
    desktop(data, &[]);
    desktop(data, &["--remove"]);
    assert!(!data.join(entry).exists() && !data.join(types).exists());
    desktop(data, &["--remove"]);
}
