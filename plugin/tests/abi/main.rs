//! Tests of the C ABI. They load the shared library as a host does, and call its exports only.

mod apply;
mod arguments;
mod examples;
mod images;
mod lenses;
mod pick;
mod remove;
mod support;
mod threads;
