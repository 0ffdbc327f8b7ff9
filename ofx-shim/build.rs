//! Linker arguments of the plugin, which must export only the entry points of OpenFX: Fusion rejects binaries that export
//! more.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    // Their linkers have no such options.
    if ["macos", "windows"].contains(&system.as_str()) {
        return;
    }
    if std::env::var_os("CARGO_FEATURE_OCIO_NATIVE").is_some() {
        // Hides the symbols of OpenColorIO's C++ library. Those of Rust are hidden by rustc, and zig's linker, which builds for
        // older C libraries, has no such option.
        println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
    }
    // Destructors of thread-local values must not run in a library that was unloaded.
    println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
}
