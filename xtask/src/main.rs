//! Chores of the project: `cargo xtask tidy` checks the rules of the house.

fn main() {}
