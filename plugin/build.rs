//! Gives the shared library its name for the loader (SONAME), so that programs do not store the path it was linked by.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libseidel_c.so");
    }
}
