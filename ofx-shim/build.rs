//! Linker arguments of the plugin, which must export only the entry points of OpenFX: Fusion rejects binaries that export
//! more.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    // Their linkers have no such options.
    if ["macos", "windows"].contains(&system.as_str()) {
        return;
    }
    // Hides symbols of dependencies, such as those of OpenColorIO's C++ library, but not those of the plugin.
    println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
    // Destructors of thread-local values must not run in a library that was unloaded.
    println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        // Line tables are most of the binary's size.
        println!("cargo::rustc-cdylib-link-arg=-Wl,--strip-debug");
    }
}
