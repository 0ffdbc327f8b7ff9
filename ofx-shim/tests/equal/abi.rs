//! Calls of the C ABI with the pictures of the host.

use std::ptr::{null, null_mut};

use seidel_c::*;

use crate::lenses::{LENS, OTHER_LENS};
use crate::picture::Picture;
use crate::{HEIGHT, WIDTH};

/// Two lenses, settings and inputs of the C ABI.
pub(crate) struct Abi {
    lens: *mut SeidelLens,
    other_lens: *mut SeidelLens,
    pub(crate) settings: SeidelSettings,
    pub(crate) depth: Option<Picture>,
    pub(crate) matte: Option<Picture>,
    pub(crate) matte_depth: Option<Picture>,
    pub(crate) mask: Option<Picture>,
}

impl Drop for Abi {
    fn drop(&mut self) {
        seidel_lens_release(self.lens);
        seidel_lens_release(self.other_lens);
    }
}

fn open_lens(path: &std::path::Path) -> *mut SeidelLens {
    let json = std::fs::read_to_string(path).expect("readable");
    let mut lens = null_mut();
    // SAFETY: the length is that of the text.
    let status = unsafe { seidel_lens_read(json.as_ptr().cast(), json.len(), &raw mut lens) };
    assert_eq!(status, SeidelStatus::Ok);
    lens
}

/// Describes a picture for the C ABI, whose rows run down.
fn image(picture: &Picture) -> SeidelImage {
    image_at(picture, picture.samples.as_ptr().cast_mut())
}

/// Describes a picture whose samples are at `data`.
fn image_at(picture: &Picture, data: *mut f32) -> SeidelImage {
    let [x1, y1, x2, y2] = picture.bounds;
    let row = i64::from(x2 - x1) * i64::from(picture.channels) * 4;
    let top = i64::from(y2 - y1 - 1) * row;
    let first = data.cast::<u8>();
    SeidelImage {
        size: size_of::<SeidelImage>() as u64,
        data: first.wrapping_offset(top as isize).cast(),
        row_bytes: -row,
        pixel_bytes: 0,
        channels: picture.channels as u32,
        sample: SEIDEL_FLOAT,
        reserved: 0,
        rect: SeidelRect {
            left: x1,
            top: HEIGHT - y2,
            width: x2 - x1,
            height: y2 - y1,
        },
    }
}

impl Abi {
    pub(crate) fn new() -> Self {
        // SAFETY: zero is valid for numbers and raw pointers.
        let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
        settings.size = size_of::<SeidelSettings>() as u64;
        // SAFETY: `size` is the size of the struct.
        unsafe { seidel_settings_init(&raw mut settings) };
        Self {
            lens: open_lens(&LENS),
            other_lens: open_lens(&OTHER_LENS),
            settings,
            depth: None,
            matte: None,
            matte_depth: None,
            mask: None,
        }
    }

    fn call(
        &self,
        source: &Picture,
        window: [i32; 4],
        call: impl FnOnce(&SeidelPlate, &SeidelImage) -> SeidelStatus,
    ) -> Picture {
        let mut out = Picture::new(window, source.channels, |_, _, _| f32::NAN);
        let data = out.samples.as_mut_ptr();
        let target = image_at(&out, data);
        let all = SeidelRect {
            left: 0,
            top: 0,
            width: WIDTH,
            height: HEIGHT,
        };
        let source = image(source);
        let inputs = [&self.depth, &self.matte, &self.matte_depth, &self.mask];
        let inputs = inputs.map(|input| input.as_ref().map(image));
        let input = |k: usize| inputs[k].as_ref().map_or(null(), |image| &raw const *image);
        let plate = SeidelPlate {
            size: size_of::<SeidelPlate>() as u64,
            format: all,
            extent: all,
            source: &source,
            depth: input(0),
            matte: input(1),
            matte_depth: input(2),
            alphas: null(),
            mask: input(3),
        };
        assert_eq!(call(&plate, &target), SeidelStatus::Ok);
        out
    }

    pub(crate) fn apply(&self, source: &Picture, window: [i32; 4]) -> Picture {
        // SAFETY: all pointers are valid until the call returns, here and below.
        self.call(source, window, |plate, out| unsafe {
            seidel_apply(self.lens, &self.settings, plate, out, null(), null())
        })
    }

    pub(crate) fn remove(&self, source: &Picture, window: [i32; 4]) -> Picture {
        // SAFETY: as above.
        self.call(source, window, |plate, out| unsafe {
            let settings = &self.settings;
            seidel_remove(self.lens, settings, plate, out, null(), null_mut(), null())
        })
    }

    pub(crate) fn relens(&self, source: &Picture, window: [i32; 4]) -> Picture {
        // SAFETY: as above.
        self.call(source, window, |plate, out| unsafe {
            let (from, to) = (self.lens, self.other_lens);
            seidel_relens(from, to, &self.settings, plate, out, null(), null())
        })
    }
}
