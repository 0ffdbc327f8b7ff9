//! The exports of the shared library, loaded as a host loads it, and the errors of their calls.

use std::ffi::c_char;
use std::path::PathBuf;
use std::sync::OnceLock;

use libloading::Library;
use seidel_c::*;

type Lens = *const SeidelLens;
type Settings = *const SeidelSettings;
type Plate = *const SeidelPlate;
type Image = *const SeidelImage;
type Callbacks = *const SeidelCallbacks;
/// An export that copies the name of an index to a buffer of a size, and tells the size that it needs.
pub(crate) type CopyName =
    unsafe extern "C" fn(Lens, u32, *mut c_char, usize, *mut usize) -> SeidelStatus;

/// Declares [`Exports`]: for each export the field, the name in the library and the type.
macro_rules! exports {
    ($($field:ident = $name:literal, fn($($argument:ty),*) -> $result:ty;)*) => {
        /// The exports of the loaded library.
        pub(crate) struct Exports {
            $(pub(crate) $field: unsafe extern "C" fn($($argument),*) -> $result,)*
        }

        impl Exports {
            fn load(library: &Library) -> Self {
                Self {
                    $($field: {
                        let name = concat!($name, "\0").as_bytes();
                        // SAFETY: the types are those of the exports.
                        *unsafe { library.get(name) }.expect($name)
                    },)*
                }
            }
        }
    };
}

exports! {
    abi_version = "seidel_abi_version", fn() -> u32;
    version = "seidel_version", fn() -> *const c_char;
    last_error = "seidel_last_error", fn(*mut c_char, usize) -> usize;
    shutdown = "seidel_shutdown", fn() -> SeidelStatus;
    settings_init = "seidel_settings_init", fn(*mut SeidelSettings) -> SeidelStatus;
    open = "seidel_lens_open", fn(*const c_char, *mut *mut SeidelLens) -> SeidelStatus;
    read = "seidel_lens_read", fn(*const c_char, usize, *mut *mut SeidelLens) -> SeidelStatus;
    retain = "seidel_lens_retain", fn(Lens) -> SeidelStatus;
    release = "seidel_lens_release", fn(Lens) -> SeidelStatus;
    info = "seidel_lens_info", fn(Lens, *mut SeidelLensInfo) -> SeidelStatus;
    channel = "seidel_lens_channel", fn(Lens, u32, *mut c_char, usize, *mut usize) -> SeidelStatus;
    model = "seidel_lens_model", fn(Lens, u32, *mut c_char, usize, *mut usize) -> SeidelStatus;
    apply = "seidel_apply",
        fn(Lens, Settings, Plate, Image, Image, Callbacks) -> SeidelStatus;
    remove = "seidel_remove",
        fn(Lens, Settings, Plate, Image, Image, *mut SeidelFindings, Callbacks) -> SeidelStatus;
    relens = "seidel_relens",
        fn(Lens, Lens, Settings, Plate, Image, Image, Callbacks) -> SeidelStatus;
    match_colours = "seidel_match_colours",
        fn(Lens, Settings, Plate, Image, Image, Callbacks) -> SeidelStatus;
    region_of_interest = "seidel_region_of_interest",
        fn(Lens, Settings, Plate, *const SeidelRect, *mut SeidelRect) -> SeidelStatus;
    kernel = "seidel_kernel",
        fn(Lens, Settings, Plate, u32, f64, f64, f64, *mut SeidelKernel) -> SeidelStatus;
    distance_at = "seidel_distance_at",
        fn(Lens, Settings, Plate, i32, i32, *mut f64) -> SeidelStatus;
    depth_findings = "seidel_depth_findings",
        fn(Lens, Settings, Plate, *mut c_char, usize, *mut usize) -> SeidelStatus;
    memory = "seidel_memory_needed", fn(Settings, Plate, u32, *mut u64) -> SeidelStatus;
}

/// Returns the path of the shared library of this build, which lies beside the tests.
pub(crate) fn library() -> PathBuf {
    let tests = std::env::current_exe().expect("the path of the test");
    let name = libloading::library_filename("seidel_c");
    tests.with_file_name(name)
}

/// Returns the exports of the library, which is loaded once and never unloaded.
pub(crate) fn exports() -> &'static Exports {
    static EXPORTS: OnceLock<Exports> = OnceLock::new();
    EXPORTS.get_or_init(|| {
        // SAFETY: the library of this project runs no code when it is loaded.
        let library = unsafe { Library::new(library()) }.expect("the built library");
        Exports::load(Box::leak(Box::new(library)))
    })
}

/// Returns the last error of this thread.
pub(crate) fn last_error() -> String {
    let mut bytes = vec![0_u8; 4096];
    // SAFETY: the buffer has the length passed.
    let length = unsafe { (exports().last_error)(bytes.as_mut_ptr().cast(), bytes.len()) };
    String::from_utf8(bytes[..length - 1].to_vec()).expect("UTF-8")
}

/// Asserts that a call succeeded.
#[track_caller]
pub(crate) fn assert_ok(status: SeidelStatus) {
    assert_eq!(status, SeidelStatus::Ok, "{}", last_error());
}

/// Asserts that a call returned `status` with an error that contains `text`.
#[track_caller]
pub(crate) fn assert_refused(got: SeidelStatus, status: SeidelStatus, text: &str) {
    let error = last_error();
    assert_eq!(got, status, "{error}");
    assert!(error.contains(text), "`{text}` is missing in: {error}");
}
