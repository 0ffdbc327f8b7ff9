//! The `seidel` command.

fn main() {}
