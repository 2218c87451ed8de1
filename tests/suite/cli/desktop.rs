//! `bathyscope desktop`, in a user's folder of its own.

use std::fs;
use std::path::Path;
use std::process::Command;

fn desktop(data: &Path, args: &[&str]) -> String {
    let run = Command::new(crate::support::program())
        .arg("desktop")
        .args(args)
        .env("XDG_DATA_HOME", data)
        .output()
        .expect("the program");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).expect("text")
}

#[test]
fn an_entry_and_file_types_are_written_and_removed() {
    let temporary = tempfile::tempdir().expect("a folder");
    let data = temporary.path();
    let [entry, types] = ["applications/bathyscope.desktop", "mime/packages/bathyscope.xml"];
    let text = desktop(data, &[]);
    assert!(text.contains(entry) && text.contains(types), "{text}");
    let text = fs::read_to_string(data.join(entry)).expect("an entry");
    let program = fs::canonicalize(crate::support::program()).expect("the program");
    let program = program.display();
    assert!(text.contains(&format!("Exec=\"{program}\" %F\n")), "{text}");
    let xml = fs::read_to_string(data.join(types)).expect("types");
    let named: Vec<&str> =
        xml.split("mime-type type=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let of_entry = text.lines().find_map(|line| line.strip_prefix("MimeType=")).expect("types");
    assert_eq!(of_entry.trim_end_matches(';').split(';').collect::<Vec<_>>(), named);
    // Where the desktop's own programs are there, they are asked.
    if let Ok(checked) = Command::new("desktop-file-validate").arg(data.join(entry)).output() {
        assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
    }
    if Command::new("update-mime-database").arg("-v").output().is_ok() {
        let globs = fs::read_to_string(data.join("mime/globs2")).expect("file types");
        assert!(globs.contains("application/x-bathyscope:*.bathyscope"), "{globs}");
    }
    desktop(data, &[]);
    desktop(data, &["--remove"]);
    assert!(!data.join(entry).exists() && !data.join(types).exists());
    assert_eq!(ours(data), [""; 0], "nothing is left");
    desktop(data, &["--remove"]);
}

/// The files in a folder and below that are ours, by their names.
fn ours(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        match entry.path().is_dir() {
            true => names.extend(ours(&entry.path())),
            false if name.contains("bathyscope") => names.push(name),
            false => {}
        }
    }
    names.sort();
    names
}

#[test]
fn a_package_gets_the_same_files_with_the_program_from_the_path() {
    let temporary = tempfile::tempdir().expect("a folder");
    let [user, share] = ["user", "share"].map(|name| temporary.path().join(name));
    desktop(&user, &[]);
    desktop(&temporary.path().join("unused"), &["--into", &share.to_string_lossy()]);
    assert!(!temporary.path().join("unused").exists());
    // The user's desktop adds an index of the types.
    let mut of_user = ours(&user);
    of_user.retain(|name| !name.starts_with("x-bathyscope"));
    assert_eq!(of_user, ours(&share));
    let entry =
        fs::read_to_string(share.join("applications/bathyscope.desktop")).expect("an entry");
    assert!(entry.contains("\nExec=bathyscope %F\n") && entry.contains("\nIcon=bathyscope\n"));
    for name in ["bathyscope.1", "bathyscope-process.1", "_bathyscope", "bathyscope.fish"] {
        assert!(of_user.iter().any(|file| file == name), "{name}");
    }
    // Where `man` is there, it finds no mistake in the pages.
    let page = share.join("man/man1/bathyscope-process.1");
    let man = Command::new("man").args(["--warnings", "-l"]).arg(page).output();
    if let Ok(shown) = man.as_ref().map(|shown| String::from_utf8_lossy(&shown.stdout))
        && !shown.is_empty()
    {
        assert!(shown.contains("first_return.threshold"), "{shown}");
    }
}
