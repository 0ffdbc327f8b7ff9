//! The header of the C ABI, generated from the exports of `plugin/src` and the table of knobs.

use std::fs;
use std::path::Path;

use crate::knobs;

/// Its path from the root.
pub(crate) const PATH: &str = "plugin/include/seidel.h";

/// The comment at its top.
const COMMENT: &str = "/* Seidel's C ABI: real lens blur, learned from measured point-spread functions.
 *
 * Generated from plugin/src by `cargo xtask header`; do not edit.
 *
 * Open a lens with seidel_lens_open, fill a SeidelSettings with seidel_settings_init, describe the images of a plate in
 * a SeidelPlate, and call seidel_apply, seidel_remove, seidel_match_colours or seidel_relens. plugin/examples/apply.c is a
 * complete program.
 *
 * Errors: functions that can fail return a SeidelStatus; seidel_last_error describes the last failure on the calling
 * thread. No panic leaves the library, and it prints nothing but Rust's own panic message on stderr.
 * Threads: all functions may be called from any number of threads at once.
 * Memory: buffers belong to the caller, and the library keeps no pointer to them after a call.
 * Versions: structs begin with their size, which the caller sets, so that later versions can add members.
 * Units: positions are plate pixels, x to the right, y down. Samples are scene-linear. Distances are metres along the
 * optical axis from the entrance pupil; vergence is 1 / distance. */";

/// The header as the sources define it.
///
/// # Errors
/// Sources that are not valid Rust.
pub(crate) fn generate(root: &Path) -> Result<String, String> {
    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        cpp_compat: true,
        include_guard: Some("SEIDEL_H".to_owned()),
        header: Some(COMMENT.to_owned()),
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
    // cbindgen follows the module declarations.
    let source = root.join("plugin/src/lib.rs");
    let builder = cbindgen::Builder::new().with_config(config);
    let bindings = builder.with_src(source).generate();
    let mut text = Vec::new();
    bindings.map_err(|e| e.to_string())?.write(&mut text);
    let text = String::from_utf8(text).map_err(|e| e.to_string())?;
    // Rust's section on safety is the contract for pointers in C.
    let text = text.replace(" * # Safety\n", " * Pointers:\n");
    Ok(knobs::header::with_comments(&text))
}

/// Writes the header; returns a report.
pub(crate) fn write(root: &Path) -> Result<String, String> {
    let text = generate(root)?;
    fs::write(root.join(PATH), text).map_err(|e| format!("{PATH}: {e}"))?;
    Ok(format!("header: wrote {PATH}"))
}
