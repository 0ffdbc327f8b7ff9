//! Lens handles: opening, description, reference counts.

use std::ptr::null_mut;

use seidel_c::*;

use crate::support::{CopyName, LensHandle, assert_ok, assert_refused, c_path, exports, profile};

fn info(lens: *const SeidelLens) -> SeidelLensInfo {
    // SAFETY: all bytes zero are a valid value.
    let mut info: SeidelLensInfo = unsafe { std::mem::zeroed() };
    info.size = size_of::<SeidelLensInfo>() as u64;
    // SAFETY: the struct has the size that it states.
    assert_ok(unsafe { (exports().info)(lens, &mut info) });
    info
}

/// Returns name `index` of a lens by the export `copy_name`.
fn name(copy_name: CopyName, lens: &LensHandle, index: u32) -> String {
    let mut needed = 0;
    // SAFETY: only the size is written.
    let status = unsafe { copy_name(lens.0, index, null_mut(), 0, &mut needed) };
    assert_refused(status, SeidelStatus::TooSmall, "give room for");
    let mut bytes = vec![0_u8; needed];
    // SAFETY: the buffer has the size passed.
    assert_ok(unsafe { copy_name(lens.0, index, bytes.as_mut_ptr().cast(), needed, null_mut()) });
    assert_eq!(bytes.pop(), Some(0));
    String::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn a_lens_is_described() {
    let lens = LensHandle::new(2.0);
    let info = info(lens.0);
    assert_eq!(
        (info.kind, info.channels, info.knows_depth),
        (SEIDEL_LENS_RAYS, 3, 1)
    );
    assert_eq!((info.frame_width, info.frame_height), (300, 200));
    assert_eq!((info.axis_x, info.axis_y), (150.0, 100.0));
    assert_eq!((info.focal_length_mm, info.f_number), (50.0, 2.0));
    assert_eq!((info.farthest, info.pixel_pitch_um), (f64::INFINITY, 6.0));
    assert!((info.nearest - 1.2).abs() < 1e-12 && info.focus_distance.is_nan());
    let names: Vec<String> = (0..3).map(|k| name(exports().channel, &lens, k)).collect();
    assert_eq!(names, ["R", "G", "B"]);
    let models: Vec<String> = (0..info.models)
        .map(|k| name(exports().model, &lens, k))
        .collect();
    assert_eq!(models[0], "pupil");
    assert!(models.contains(&"gaussian".to_owned()) && models.len() >= 4);
    // SAFETY: NULL is allowed for both outputs.
    let status = unsafe { (exports().channel)(lens.0, 3, null_mut(), 0, null_mut()) };
    assert_refused(status, SeidelStatus::Argument, "channel 3");
}

#[test]
fn no_byte_is_written_beyond_the_size_of_a_struct() {
    let lens = LensHandle::new(2.0);
    let whole = size_of::<SeidelLensInfo>();
    let mut bytes = vec![0xab_u8; whole + 8];
    bytes[..8].copy_from_slice(&(whole as u64).to_ne_bytes());
    // SAFETY: the memory is larger than the size that it states.
    assert_ok(unsafe { (exports().info)(lens.0, bytes.as_mut_ptr().cast()) });
    assert_eq!(bytes[whole..], [0xab; 8]);
}

#[test]
fn files_that_are_not_lens_profiles_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let open = |file: &str| {
        let mut lens = null_mut();
        let path = c_path(&folder.path().join(file));
        // SAFETY: both pointers are valid.
        let status = unsafe { (exports().open)(path.as_ptr(), &mut lens) };
        assert!(status == SeidelStatus::Ok || lens.is_null());
        (status, LensHandle(lens))
    };
    assert_refused(
        open("none.json").0,
        SeidelStatus::Lens,
        "none.json: could not be read",
    );
    std::fs::write(folder.path().join("bad.json"), "{\"format\": 3}").expect("writable");
    assert_refused(open("bad.json").0, SeidelStatus::Lens, "bad.json");
    std::fs::write(folder.path().join("bytes.json"), [0xff, 0xfe]).expect("writable");
    assert_refused(open("bytes.json").0, SeidelStatus::Lens, "UTF-8");
    std::fs::write(folder.path().join("gläs %s.json"), profile(2.0).to_json()).expect("writable");
    let (status, lens) = open("gläs %s.json");
    assert_ok(status);
    assert_eq!(info(lens.0).channels, 3);
    // SAFETY: both pointers are valid; the path is not UTF-8.
    let status = unsafe { (exports().open)(c"\xff".as_ptr(), &mut null_mut()) };
    assert_refused(status, SeidelStatus::Argument, "path: is not UTF-8");
}

#[test]
fn handles_are_counted_and_released_ones_refused() {
    let lens = LensHandle::new(2.0);
    let handle = lens.0;
    // SAFETY: any value is safe as a handle.
    unsafe {
        assert_ok((exports().retain)(handle));
        assert_ok((exports().release)(handle));
        assert_eq!(info(handle).channels, 3);
        drop(lens);
        for status in [(exports().retain)(handle), (exports().release)(handle)] {
            assert_refused(status, SeidelStatus::Argument, "not a handle");
        }
        let invented = 12345_usize as *const SeidelLens;
        assert_refused(
            (exports().release)(invented),
            SeidelStatus::Argument,
            "not a handle",
        );
    }
}
