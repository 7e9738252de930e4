//! The program `grimace`, as the whole-system tests run it.

fn main() -> std::process::ExitCode {
    grimace::main()
}
