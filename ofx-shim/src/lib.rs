//! The room for Seidel's OpenFX plugin: actions, parameters, clips and host suites on top of the C
//! ABI of `seidel-plugin`, built as one `.ofx` bundle.
//!
//! Nothing is exported yet: a bundle that loads and does nothing would mislead a host. The crate
//! stands here so that the edges of the house are fixed: it will depend on `seidel-plugin` alone.
