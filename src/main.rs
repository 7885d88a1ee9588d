//! The program `hvi-flow`.
use std::process::ExitCode;

fn main() -> ExitCode {
    hvi_flow::cli::main()
}
