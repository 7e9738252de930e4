//! The program `grimace`: everything it does stands in the library of the same name.

fn main() -> std::process::ExitCode {
    grimace::main()
}
