//! The room for Seidel's C ABI: opaque handles, status codes and caller-owned buffers around
//! `seidel-core`, so that any host that can call C can load a lens, predict PSFs and render.
//!
//! Nothing is exported yet. The crate stands here so that the edges of the house are fixed: it will
//! depend on `seidel-core` alone, and every export will pass through one guard that checks pointers
//! and keeps panics from crossing the boundary.
