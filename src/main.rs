//! The `dynident` program.

fn main() -> std::process::ExitCode {
    dynident::cli::main()
}
