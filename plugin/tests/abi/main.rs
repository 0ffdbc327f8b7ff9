//! The C ABI by its own doors: the shared library is loaded as a host would load it.

mod applying;
mod arguments;
mod examples;
mod lenses;
mod pictures;
mod removing;
mod support;
mod working;
