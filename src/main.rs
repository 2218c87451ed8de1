//! The `bathyscope` program; everything it does is in the library.

fn main() -> std::process::ExitCode {
    bathyscope::cli::main()
}
