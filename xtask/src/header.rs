//! The header of the C ABI, made from what the plugin exports.

use std::fs;
use std::path::Path;

/// Where it is kept, from the root.
pub(crate) const HEADER: &str = "plugin/include/seidel.h";

const HEAD: &str = "/* Seidel's C ABI: real lens blur, learned from measured point-spread functions.
 *
 * Made from plugin/src by `cargo xtask header`; do not edit.
 *
 * Every call answers a SeidelStatus; seidel_last_error tells in words why the last call on the same thread failed. All
 * calls may come from any number of threads at once. Structs begin with their size, which the caller sets, so that they
 * can grow. Buffers stay the caller's: nothing is kept of them after a call. No panic leaves the library, and nothing is
 * printed but what Rust itself says of a panic on stderr. */";

/// The header as it should be.
///
/// # Errors
/// Sources that cannot be read as Rust, in words.
pub(crate) fn made(root: &Path) -> Result<String, String> {
    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        cpp_compat: true,
        include_guard: Some("SEIDEL_H".to_owned()),
        header: Some(HEAD.to_owned()),
        usize_is_size_t: true,
        line_length: 110,
        no_includes: true,
        sys_includes: vec!["stddef.h".to_owned(), "stdint.h".to_owned()],
        enumeration: cbindgen::EnumConfig {
            rename_variants: cbindgen::RenameRule::QualifiedScreamingSnakeCase,
            ..cbindgen::EnumConfig::default()
        },
        ..cbindgen::Config::default()
    };
    // The modules that it names are read as well.
    let source = root.join("plugin/src/lib.rs");
    let builder = cbindgen::Builder::new().with_config(config);
    let bindings = builder.with_src(source).generate();
    let mut text = Vec::new();
    bindings.map_err(|e| e.to_string())?.write(&mut text);
    let text = String::from_utf8(text).map_err(|e| e.to_string())?;
    // What Rust calls safety is what C calls the contract.
    Ok(text.replace(" * # Safety\n", " * Pointers:\n"))
}

/// Writes it.
pub(crate) fn write(root: &Path) -> Result<(), String> {
    let text = made(root)?;
    fs::write(root.join(HEADER), text).map_err(|e| format!("{HEADER}: {e}"))
}
