//! Hides the C ABI in the plugin: hosts are to find the entry points of OpenFX and nothing else. Fusion refuses binaries
//! that export more.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    // The library's exports come out of an archive, those of the plugin do not.
    if !["macos", "windows"].contains(&system.as_str()) {
        println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
        // What threads and thread-local values leave behind must not run in a library that is gone.
        println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}
