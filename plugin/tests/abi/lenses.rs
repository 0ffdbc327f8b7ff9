//! Lenses: opened, asked, retained, released.

use std::ptr::null_mut;

use seidel_c::*;

use crate::support::{Held, c_path, doors, profile, refused, well};

fn info(lens: *const SeidelLens) -> SeidelLensInfo {
    // SAFETY: zeros are numbers.
    let mut info: SeidelLensInfo = unsafe { std::mem::zeroed() };
    info.size = size_of::<SeidelLensInfo>() as u64;
    // SAFETY: the place is as large as it says.
    well(unsafe { (doors().info)(lens, &mut info) });
    info
}

fn name(
    of: unsafe extern "C" fn(
        *const SeidelLens,
        u32,
        *mut std::ffi::c_char,
        usize,
        *mut usize,
    ) -> SeidelStatus,
    lens: &Held,
    index: u32,
) -> String {
    let mut needed = 0;
    // SAFETY: nothing but the length is written.
    let status = unsafe { of(lens.0, index, null_mut(), 0, &mut needed) };
    refused(status, SeidelStatus::TooSmall, "give room for");
    let mut bytes = vec![0_u8; needed];
    // SAFETY: the buffer is as long as is said.
    well(unsafe { of(lens.0, index, bytes.as_mut_ptr().cast(), needed, null_mut()) });
    assert_eq!(bytes.pop(), Some(0));
    String::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn a_lens_tells_what_it_is() {
    let lens = Held::new(2.0);
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
    let names: Vec<String> = (0..3).map(|k| name(doors().channel, &lens, k)).collect();
    assert_eq!(names, ["R", "G", "B"]);
    let models: Vec<String> = (0..info.models)
        .map(|k| name(doors().model, &lens, k))
        .collect();
    assert_eq!(models[0], "pupil");
    assert!(models.contains(&"gaussian".to_owned()) && models.len() >= 4);
    // SAFETY: nothing is written.
    let beyond = unsafe { (doors().channel)(lens.0, 3, null_mut(), 0, null_mut()) };
    refused(beyond, SeidelStatus::Argument, "channel 3");
}

#[test]
fn an_older_caller_gets_what_it_knows_of() {
    let lens = Held::new(2.0);
    let whole = size_of::<SeidelLensInfo>();
    let mut places = vec![0xab_u8; whole + 8];
    places[..8].copy_from_slice(&(whole as u64).to_ne_bytes());
    // SAFETY: the place is larger than it says.
    well(unsafe { (doors().info)(lens.0, places.as_mut_ptr().cast()) });
    assert_eq!(places[whole..], [0xab; 8]);
}

#[test]
fn files_that_are_no_lens_are_told_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let open = |file: &str| {
        let mut lens = null_mut();
        let path = c_path(&folder.path().join(file));
        // SAFETY: both are good.
        let status = unsafe { (doors().open)(path.as_ptr(), &mut lens) };
        assert!(status == SeidelStatus::Ok || lens.is_null());
        (status, Held(lens))
    };
    refused(
        open("none.json").0,
        SeidelStatus::Lens,
        "none.json: could not be read",
    );
    std::fs::write(folder.path().join("bad.json"), "{\"format\": 3}").expect("writable");
    refused(open("bad.json").0, SeidelStatus::Lens, "bad.json");
    std::fs::write(folder.path().join("bytes.json"), [0xff, 0xfe]).expect("writable");
    refused(open("bytes.json").0, SeidelStatus::Lens, "UTF-8");
    std::fs::write(folder.path().join("gläs %s.json"), profile(2.0).to_json()).expect("writable");
    let (status, lens) = open("gläs %s.json");
    well(status);
    assert_eq!(info(lens.0).channels, 3);
    // SAFETY: a text that is not UTF-8, and a place.
    let status = unsafe { (doors().open)(c"\xff".as_ptr(), &mut null_mut()) };
    refused(status, SeidelStatus::Argument, "path: is not UTF-8");
}

#[test]
fn handles_are_counted_and_stale_ones_told() {
    let lens = Held::new(2.0);
    let stale = lens.0;
    // SAFETY: handles may be anything.
    unsafe {
        well((doors().retain)(stale));
        well((doors().release)(stale));
        assert_eq!(info(stale).channels, 3);
        drop(lens);
        for status in [(doors().retain)(stale), (doors().release)(stale)] {
            refused(status, SeidelStatus::Argument, "not a handle");
        }
        let made_up = 12345_usize as *const SeidelLens;
        refused(
            (doors().release)(made_up),
            SeidelStatus::Argument,
            "not a handle",
        );
    }
}
