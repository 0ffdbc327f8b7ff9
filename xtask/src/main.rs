//! Chores of the project: `cargo xtask tidy` checks the rules of the house, `cargo xtask header` writes the header of
//! the C ABI, `cargo xtask bundle` makes the OpenFX bundle, `cargo xtask luts` the config and tables of colour.

mod bundle;
mod header;
mod luts;
mod tidy;

use std::process::ExitCode;

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("tidy") => {
            let problems = tidy::problems(&tidy::root());
            for problem in &problems {
                eprintln!("tidy: {problem}");
            }
            if problems.is_empty() {
                println!("tidy: the house is in order");
                ExitCode::SUCCESS
            } else {
                ExitCode::FAILURE
            }
        }
        Some("header") => match header::write(&tidy::root()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => {
                eprintln!("header: {why}");
                ExitCode::FAILURE
            }
        },
        Some("bundle") => match bundle::run(&tidy::root(), std::env::args().skip(2)) {
            Ok(said) => {
                println!("{said}");
                ExitCode::SUCCESS
            }
            Err(why) => {
                eprintln!("bundle: {why}");
                ExitCode::FAILURE
            }
        },
        Some("luts") => match luts::run(&tidy::root(), std::env::args().skip(2)) {
            Ok(said) => {
                println!("{said}");
                ExitCode::SUCCESS
            }
            Err(why) => {
                eprintln!("luts: {why}");
                ExitCode::FAILURE
            }
        },
        _ => {
            eprintln!("usage: cargo xtask tidy|header|bundle|luts [--check]");
            ExitCode::from(2)
        }
    }
}
