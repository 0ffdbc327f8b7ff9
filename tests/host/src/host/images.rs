//! Images as plugins get them: poisoned, padded, upside down, cut to what was asked for, and watched.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::effect::Clip;
use super::profile::Rows;
use super::properties::{PropertySet, Value, Values};
use super::{Host, locked, under};
use crate::picture::{Picture, Rect, Region};
use crate::scene::{Feed, Scene};

/// A quiet NaN that no arithmetic makes: what pixels hold that nobody has written.
const POISON: u32 = 0x7fc0_dead;
/// What bytes hold that belong to no pixel.
const CANARY: u8 = 0xa5;
/// Bytes before and after an image that are watched.
const GUARD: usize = 4096;

/// The memory of one image.
pub(crate) struct Buffer {
    memory: *mut u8,
    bytes: usize,
    /// Offset of the pixel at the lower left.
    origin: usize,
    pub(crate) row_bytes: i32,
    pub(crate) bounds: Rect,
    pub(crate) channels: usize,
    /// What it held when it was handed out.
    before: Vec<u8>,
}

// SAFETY: the memory is reached by copies of whole bytes alone; plugins are given no more than that.
unsafe impl Send for Buffer {}
// SAFETY: as above.
unsafe impl Sync for Buffer {}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: made from a vector of so many bytes, and given up here alone.
        drop(unsafe { Vec::from_raw_parts(self.memory, self.bytes, self.bytes) });
    }
}

impl Buffer {
    /// With the samples of `picture` in it, or poison; outside the picture 0.
    pub(crate) fn new(
        bounds: Rect,
        channels: usize,
        rows: Rows,
        picture: Option<&Picture>,
    ) -> Self {
        let (width, height) = (bounds.width(), bounds.height());
        let gap = match rows {
            Rows::Tight | Rows::Negative => 0,
            Rows::Padded => 64,
            Rows::Odd | Rows::NegativeOdd => 4 * (3 - width * channels % 2),
            Rows::Unaligned => 5,
        };
        let stride = width * channels * 4 + gap;
        let down = matches!(rows, Rows::Negative | Rows::NegativeOdd);
        let bytes = 2 * GUARD + stride * height.max(1) + 16;
        let mut memory = Vec::with_capacity(bytes);
        memory.resize(bytes, CANARY);
        memory.shrink_to_fit();
        // A multiple of 16, as hosts align what they allocate.
        let start = GUARD + memory.as_ptr().align_offset(16);
        let origin = if down {
            start + stride * height.saturating_sub(1)
        } else {
            start
        };
        let signed = i32::try_from(stride).unwrap_or(i32::MAX);
        let row_bytes = if down { -signed } else { signed };
        for (x, y) in bounds.pixels() {
            let at = place(origin, row_bytes, bounds, channels, x, y);
            for c in 0..channels {
                let bits = match picture {
                    Some(picture) => picture.pixel(x, y).get(c).copied().unwrap_or(0.0).to_bits(),
                    None => POISON,
                };
                memory[at + 4 * c..at + 4 * c + 4].copy_from_slice(&bits.to_ne_bytes());
            }
        }
        let before = memory.clone();
        let bytes = memory.capacity();
        memory.resize(bytes, CANARY);
        let mut memory = std::mem::ManuallyDrop::new(memory);
        Self {
            memory: memory.as_mut_ptr(),
            bytes,
            origin,
            row_bytes,
            bounds,
            channels,
            before,
        }
    }

    /// The address of the pixel at the lower left.
    pub(crate) fn data(&self) -> usize {
        self.memory as usize + self.origin
    }

    /// All bytes as they are now.
    fn now(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.before.len()];
        // SAFETY: the memory has as many bytes, and nobody writes to it: its action is over.
        unsafe {
            self.memory
                .copy_to_nonoverlapping(bytes.as_mut_ptr(), bytes.len())
        };
        bytes
    }

    /// Overwrites every byte: whoever goes on reading it gets no numbers.
    pub(crate) fn spoil(&self) {
        // SAFETY: so many bytes belong to it, and it has been given back.
        unsafe { self.memory.write_bytes(0xff, self.before.len()) };
    }

    /// What it holds, as a picture.
    pub(crate) fn picture(&self) -> Picture {
        let bytes = self.now();
        Picture::made(self.bounds, self.channels, |x, y, c| {
            let at = place(
                self.origin,
                self.row_bytes,
                self.bounds,
                self.channels,
                x,
                y,
            ) + 4 * c;
            let mut four = [0; 4];
            four.copy_from_slice(&bytes[at..at + 4]);
            f32::from_ne_bytes(four)
        })
    }

    /// Whether any byte was changed since it was handed out.
    pub(crate) fn changed(&self) -> bool {
        self.now() != self.before
    }

    /// Faults of who was to write the pixels of `wanted` and nothing else.
    pub(crate) fn faults(&self, wanted: impl Fn(i32, i32) -> bool) -> Vec<String> {
        let now = self.now();
        let mut pixel_of = BTreeMap::new();
        let mut unwritten = Vec::new();
        let mut not_finite = Vec::new();
        for (x, y) in self.bounds.pixels() {
            let at = place(
                self.origin,
                self.row_bytes,
                self.bounds,
                self.channels,
                x,
                y,
            );
            pixel_of.insert(at, (x, y));
            if !wanted(x, y) {
                continue;
            }
            let samples = now[at..at + 4 * self.channels].chunks_exact(4).map(|four| {
                let mut bytes = [0; 4];
                bytes.copy_from_slice(four);
                u32::from_ne_bytes(bytes)
            });
            for bits in samples {
                if bits == POISON {
                    unwritten.push((x, y));
                    break;
                }
                if !f32::from_bits(bits).is_finite() {
                    not_finite.push((x, y));
                    break;
                }
            }
        }
        let mut outside = Vec::new();
        let mut padding = 0;
        let size = 4 * self.channels;
        let differing = (0..now.len()).filter(|i| now[*i] != self.before[*i]);
        for i in differing {
            match pixel_of.range(..=i).next_back() {
                Some((at, (x, y))) if i < at + size => {
                    if !wanted(*x, *y) && outside.last() != Some(&(*x, *y)) {
                        outside.push((*x, *y));
                    }
                }
                _ => padding += 1,
            }
        }
        let mut faults = Vec::new();
        let rows = [
            ("not written", &unwritten),
            ("written with what is not finite", &not_finite),
            ("written outside what was to be rendered", &outside),
        ];
        for (what, list) in rows {
            if let Some(first) = list.first() {
                faults.push(format!("{} pixels {what}, the first {first:?}", list.len()));
            }
        }
        if padding > 0 {
            faults.push(format!("{padding} bytes written that belong to no pixel"));
        }
        faults
    }
}

/// Offset of a pixel's samples.
fn place(origin: usize, row_bytes: i32, bounds: Rect, channels: usize, x: i32, y: i32) -> usize {
    let row = i64::from(y - bounds.y1) * i64::from(row_bytes);
    let column = i64::from(x - bounds.x1) * 4 * channels as i64;
    usize::try_from(origin as i64 + row + column).unwrap_or(0)
}

/// A render under way.
pub(crate) struct Rendering {
    pub(crate) time: f64,
    pub(crate) scale: (f64, f64),
    pub(crate) rows: Rows,
    /// What of each clip there is, in pixels; nothing: all of it.
    pub(crate) crops: Option<BTreeMap<String, Rect>>,
    pub(crate) output: Arc<Buffer>,
    /// Where Output has pixels.
    pub(crate) rod: Rect,
    pub(crate) field: &'static CStr,
    /// Clips whose images were fetched.
    pub(crate) fetched: Mutex<Vec<String>>,
}

/// An image that the plugin has.
pub(crate) struct Fetched {
    clip: String,
    buffer: Option<Arc<Buffer>>,
    output: bool,
    /// The render it was fetched for, 0 for none.
    of: usize,
}

/// What `clipGetImage` gives: a handle, or 0 where there is success without an image.
pub(crate) fn fetch(
    host: &Host,
    clip: &Clip,
    time: f64,
    region: Option<Region>,
) -> Result<usize, OfxStatus> {
    let Some(effect) = clip.effect.upgrade() else {
        return Err(kOfxStatErrBadHandle);
    };
    let scene = locked(&effect.scene).clone();
    let rendering = under::now().and_then(|under| under.rendering).or_else(|| {
        let all = locked(&effect.renderings);
        (all.iter().find(|r| r.time.to_bits() == time.to_bits()))
            .or(all.first())
            .cloned()
    });
    let scale = rendering.as_ref().map_or((1.0, 1.0), |r| r.scale);
    if let Some(rendering) = &rendering {
        locked(&rendering.fetched).push(clip.name.clone());
    }
    let (buffer, rod) = if clip.name == "Output" {
        let Some(rendering) = &rendering else {
            host.misused("the image of Output was fetched when nothing is rendered".to_owned());
            return Err(kOfxStatFailed);
        };
        (Some(Arc::clone(&rendering.output)), rendering.rod)
    } else {
        let input = scene.input(&clip.name);
        match &input.feed {
            Feed::Unconnected if !host.profile.all_connected => return Err(kOfxStatFailed),
            Feed::Fails => return Err(kOfxStatFailed),
            Feed::NullHandle => return Ok(0),
            Feed::Unconnected | Feed::NullData => (None, Rect::new(0, 0, 1, 1)),
            Feed::Pictures(_) => {
                let Some(picture) = input.picture(time) else {
                    return Err(kOfxStatFailed);
                };
                let (buffer, rod) =
                    input_image(host, clip, &scene, &picture, rendering.as_deref(), region);
                (Some(Arc::new(buffer)), rod)
            }
        }
    };
    let properties = image_properties(
        host,
        clip,
        &scene,
        buffer.as_deref(),
        rod,
        scale,
        rendering.as_deref(),
    );
    let set = host.property_set(
        "image",
        &format!("an image of {}", clip.name),
        properties,
        false,
    );
    host.counts.images.fetch_add(1, Ordering::SeqCst);
    host.counts.images_out.fetch_add(1, Ordering::SeqCst);
    locked(&host.images).insert(
        set.handle(),
        Fetched {
            clip: clip.name.clone(),
            buffer,
            output: clip.name == "Output",
            of: rendering.as_ref().map_or(0, identity),
        },
    );
    Ok(set.handle())
}

/// The part of a clip's picture that the host gives, and where the clip has pixels.
fn input_image(
    host: &Host,
    clip: &Clip,
    scene: &Scene,
    picture: &Picture,
    rendering: Option<&Rendering>,
    region: Option<Region>,
) -> (Buffer, Rect) {
    let scale = rendering.map_or((1.0, 1.0), |r| r.scale);
    let reduced = (scale.0 - 0.5).abs() < 1e-9 && (scale.1 - 0.5).abs() < 1e-9;
    let half = reduced.then(|| picture.halved());
    let picture = half.as_ref().unwrap_or(picture);
    let mut bounds = picture.bounds;
    if let Some(crops) = rendering.and_then(|r| r.crops.as_ref())
        && let Some(crop) = crops.get(&clip.name)
    {
        bounds = bounds.and(crop);
    }
    if let Some(region) = region {
        bounds = bounds.and(&region.pixels(scale, scene.par));
    }
    let rows = rendering.map_or(host.profile.rows, |r| r.rows);
    let buffer = Buffer::new(bounds, picture.channels, rows, Some(picture));
    (buffer, picture.bounds)
}

fn image_properties(
    host: &Host,
    clip: &Clip,
    scene: &Scene,
    buffer: Option<&Buffer>,
    rod: Rect,
    scale: (f64, f64),
    rendering: Option<&Rendering>,
) -> Values {
    let ints = |list: [i32; 4]| list.map(Value::Int).to_vec();
    let text = |value: &CStr| vec![Value::Text(value.to_owned())];
    let bounds = buffer.map_or(rod, |b| b.bounds);
    let channels = buffer.map_or(4, |b| b.channels);
    let premultiplication =
        (scene.input(&clip.name).premultiplication).unwrap_or(if channels == 3 {
            kOfxImageOpaque
        } else {
            kOfxImagePreMultiplied
        });
    let unique = format!(
        "{} {}",
        clip.name,
        host.counts.images.load(Ordering::SeqCst)
    );
    let mut rows: Vec<(&CStr, Vec<Value>)> = vec![
        (kOfxPropType, text(kOfxTypeImage)),
        (kOfxImageEffectPropPixelDepth, text(host.profile.samples)),
        (
            kOfxImageEffectPropComponents,
            text(Scene::components(channels)),
        ),
        (
            kOfxImageEffectPropPreMultiplication,
            text(premultiplication),
        ),
        (
            kOfxImagePropPixelAspectRatio,
            vec![Value::Double(scene.par)],
        ),
        (
            kOfxImagePropData,
            vec![Value::Pointer(buffer.map_or(0, Buffer::data))],
        ),
        (kOfxImagePropBounds, ints(bounds.corners())),
        (kOfxImagePropRegionOfDefinition, ints(rod.corners())),
        (
            kOfxImagePropRowBytes,
            vec![Value::Int(buffer.map_or(0, |b| b.row_bytes))],
        ),
        (
            kOfxImagePropField,
            text(rendering.map_or(kOfxImageFieldNone, |r| r.field)),
        ),
        (kOfxImagePropUniqueIdentifier, vec![Value::text(&unique)]),
    ];
    let factor = host.profile.image_scale_factor;
    if factor != 0.0 {
        rows.push((
            kOfxImageEffectPropRenderScale,
            vec![
                Value::Double(scale.0 * factor),
                Value::Double(scale.1 * factor),
            ],
        ));
    }
    rows.into_iter()
        .map(|(name, values)| (name.to_string_lossy().into_owned(), values))
        .collect()
}

/// `clipReleaseImage`.
pub(crate) fn release(host: &Host, set: &PropertySet) -> OfxStatus {
    let Some(image) = locked(&host.images).remove(&set.handle()) else {
        host.misused(format!(
            "clipReleaseImage was given {}, which is no image",
            set.name
        ));
        return kOfxStatErrBadHandle;
    };
    host.end(set.handle());
    host.counts.images_out.fetch_sub(1, Ordering::SeqCst);
    if let Some(buffer) = &image.buffer
        && !image.output
    {
        if buffer.changed() {
            host.misused(format!("the image of {} was written to", image.clip));
        }
        buffer.spoil();
    }
    kOfxStatOK
}

/// Images of a render, or of no render, that are still out when it ends, by clip: they are taken away.
pub(crate) fn left_out(host: &Host, rendering: Option<&Arc<Rendering>>) -> Vec<String> {
    let of = rendering.map_or(0, identity);
    let mut images = locked(&host.images);
    let left: Vec<usize> = (images.iter().filter(|(_, i)| i.of == of))
        .map(|(h, _)| *h)
        .collect();
    left.into_iter()
        .filter_map(|handle| {
            host.end(handle);
            host.counts.images_out.fetch_sub(1, Ordering::SeqCst);
            images.remove(&handle).map(|image| image.clip)
        })
        .collect()
}

/// A number that no other render under way has.
fn identity(rendering: &Arc<Rendering>) -> usize {
    Arc::as_ptr(rendering) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_wrongly_is_seen() {
        for rows in Rows::ALL {
            let bounds = Rect::new(-2, 3, 5, 8);
            let buffer = Buffer::new(bounds, 4, rows, None);
            let write = |x: i32, y: i32, value: f32| {
                let at = place(buffer.origin, buffer.row_bytes, bounds, 4, x, y);
                for c in 0..4 {
                    // SAFETY: inside the buffer's own memory.
                    unsafe {
                        buffer
                            .memory
                            .add(at + 4 * c)
                            .cast::<f32>()
                            .write_unaligned(value)
                    };
                }
            };
            let window = Rect::new(-2, 3, 5, 7);
            let wanted = |x, y| window.contains(x, y);
            assert!(buffer.faults(wanted)[0].starts_with("28 pixels not written"));
            for (x, y) in window.pixels() {
                write(x, y, 0.5);
            }
            assert!(buffer.faults(wanted).is_empty(), "{rows:?}");
            write(0, 4, f32::INFINITY);
            write(1, 7, 0.5);
            let faults = buffer.faults(wanted);
            assert!(faults[0].contains("not finite") && faults[0].contains("(0, 4)"));
            assert!(faults[1].contains("outside") && faults[1].contains("(1, 7)"));
            write(-2, 9, 0.5);
            let beyond = buffer.faults(wanted);
            assert!(beyond.len() == 3, "{rows:?}: {beyond:?}");
            assert_eq!(buffer.picture().pixel(3, 5), &[0.5; 4]);
        }
    }

    #[test]
    fn rows_are_as_said() {
        let bounds = Rect::new(0, 0, 3, 2);
        assert_eq!(Buffer::new(bounds, 4, Rows::Tight, None).row_bytes, 48);
        assert_eq!(Buffer::new(bounds, 4, Rows::Negative, None).row_bytes, -48);
        let odd = Buffer::new(bounds, 3, Rows::Odd, None).row_bytes;
        assert!(odd % 4 == 0 && odd / 4 % 2 == 1);
        assert_ne!(
            Buffer::new(bounds, 4, Rows::Unaligned, None).row_bytes % 4,
            0
        );
        assert_eq!(Buffer::new(bounds, 4, Rows::Tight, None).data() % 16, 0);
    }
}
