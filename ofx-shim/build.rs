//! Hides the C ABI in the plugin: hosts are to find the entry points of OpenFX and nothing else. Fusion refuses binaries
//! that export more.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let system = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    // Linkers of these have no such switch; what it would do there is in docs/guide/hosts.md.
    if ["macos", "windows"].contains(&system.as_str()) {
        return;
    }
    // The library's exports come out of an archive, those of the plugin do not.
    println!("cargo::rustc-cdylib-link-arg=-Wl,--exclude-libs,ALL");
    // What threads and thread-local values leave behind must not run in a library that is gone.
    println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        // Line tables are most of the binary.
        println!("cargo::rustc-cdylib-link-arg=-Wl,--strip-debug");
    }
}
