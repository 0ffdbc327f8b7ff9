//! Images fetched by plugins: guarded memory, with the properties of an OpenFX image.

use std::collections::BTreeMap;
use std::ffi::CStr;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::action::current_action;
use super::effect::Clip;
pub(crate) use super::guarded::GuardedBuffer;
use super::profile::RowLayout;
use super::properties::{PropertySet, Schema, Value, Values, property_name};
use super::render_time::timed;
use super::{Host, locked};
use crate::picture::{Picture, Rect, Region};
use crate::scene::{Feed, Scene, components};

/// A render in progress.
pub(crate) struct ActiveRender {
    pub(crate) time: f64,
    pub(crate) scale: (f64, f64),
    pub(crate) rows: RowLayout,
    /// Regions to which input images are cropped, by clip, in pixels; `None` gives whole images.
    pub(crate) crops: Option<BTreeMap<String, Rect>>,
    pub(crate) output: Arc<GuardedBuffer>,
    /// Region of definition of Output, in pixels.
    pub(crate) rod: Rect,
    pub(crate) field: &'static CStr,
    /// Clips whose images were fetched.
    pub(crate) fetched_clips: Mutex<Vec<String>>,
}

/// An image that the plugin has fetched and not released.
pub(crate) struct FetchedImage {
    clip: String,
    buffer: Option<Arc<GuardedBuffer>>,
    is_output: bool,
    /// Identifies the render that it was fetched for; 0 for none.
    render: usize,
}

/// Implements `clipGetImage`. Returns a handle, or 0 for success without an image.
pub(crate) fn fetch(
    host: &Host,
    clip: &Clip,
    time: f64,
    region: Option<Region>,
) -> Result<usize, OfxStatus> {
    timed(&host.image_work, || make(host, clip, time, region))
}

fn make(host: &Host, clip: &Clip, time: f64, region: Option<Region>) -> Result<usize, OfxStatus> {
    let Some(effect) = clip.effect.upgrade() else {
        return Err(kOfxStatErrBadHandle);
    };
    let scene = locked(&effect.scene).clone();
    // On threads of the plugin's own, the render of that time is assumed.
    let render = current_action()
        .and_then(|action| action.render)
        .or_else(|| {
            let renders = locked(&effect.renders);
            (renders.iter().find(|r| r.time.to_bits() == time.to_bits()))
                .or(renders.first())
                .cloned()
        });
    if let Some(render) = &render {
        locked(&render.fetched_clips).push(clip.name.clone());
    }
    let is_output = clip.name == "Output";
    let (buffer, rod) = if is_output {
        let Some(render) = &render else {
            host.record_misuse("the image of Output was fetched outside a render");
            return Err(kOfxStatFailed);
        };
        (Some(Arc::clone(&render.output)), render.rod)
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
                    input_image(host, clip, &scene, &picture, render.as_deref(), region);
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
        render.as_deref(),
    );
    let name = format!("an image of {}", clip.name);
    let set = host.property_set("image", &name, properties, Schema::Fixed);
    host.counters.images_fetched.fetch_add(1, Ordering::SeqCst);
    host.counters.images_held.fetch_add(1, Ordering::SeqCst);
    locked(&host.images).insert(
        set.handle(),
        FetchedImage {
            clip: clip.name.clone(),
            buffer,
            is_output,
            render: render.as_ref().map_or(0, identity),
        },
    );
    Ok(set.handle())
}

/// Returns the part of a clip's picture that the host gives, and the clip's region of definition in pixels.
fn input_image(
    host: &Host,
    clip: &Clip,
    scene: &Scene,
    picture: &Picture,
    render: Option<&ActiveRender>,
    region: Option<Region>,
) -> (GuardedBuffer, Rect) {
    let scale = render.map_or((1.0, 1.0), |r| r.scale);
    let is_half_scale = (scale.0 - 0.5).abs() < 1e-9 && (scale.1 - 0.5).abs() < 1e-9;
    let half = is_half_scale.then(|| picture.half_scale());
    let picture = half.as_ref().unwrap_or(picture);
    let mut bounds = picture.bounds;
    if let Some(crops) = render.and_then(|r| r.crops.as_ref())
        && let Some(crop) = crops.get(&clip.name)
    {
        bounds = bounds.intersection(crop);
    }
    if let Some(region) = region {
        bounds = bounds.intersection(&region.pixels(scale, scene.par));
    }
    let rows = render.map_or(host.profile.rows, |r| r.rows);
    let buffer = GuardedBuffer::input(bounds, rows, scene.samples, picture);
    (buffer, picture.bounds)
}

fn image_properties(
    host: &Host,
    clip: &Clip,
    scene: &Scene,
    buffer: Option<&GuardedBuffer>,
    rod: Rect,
    render: Option<&ActiveRender>,
) -> Values {
    let ints = |list: [i32; 4]| list.map(Value::Int).to_vec();
    let text = |value: &CStr| vec![Value::Text(value.to_owned())];
    let bounds = buffer.map_or(rod, GuardedBuffer::bounds);
    let channels = buffer.map_or(4, GuardedBuffer::channels);
    let bit_depth = (host.profile.false_bit_depth).unwrap_or(scene.samples.bit_depth());
    let identifier = format!(
        "{} {}",
        clip.name,
        host.counters.images_fetched.load(Ordering::SeqCst)
    );
    let mut rows: Vec<(&CStr, Vec<Value>)> = vec![
        (kOfxPropType, text(kOfxTypeImage)),
        (kOfxImageEffectPropPixelDepth, text(bit_depth)),
        (kOfxImageEffectPropComponents, text(components(channels))),
        (
            kOfxImageEffectPropPreMultiplication,
            text(scene.input(&clip.name).premultiplication(channels)),
        ),
        (
            kOfxImagePropPixelAspectRatio,
            vec![Value::Double(scene.par)],
        ),
        (
            kOfxImagePropData,
            vec![Value::Pointer(buffer.map_or(0, GuardedBuffer::data))],
        ),
        (kOfxImagePropBounds, ints(bounds.corners())),
        (kOfxImagePropRegionOfDefinition, ints(rod.corners())),
        (
            kOfxImagePropRowBytes,
            vec![Value::Int(buffer.map_or(0, GuardedBuffer::row_bytes))],
        ),
        (
            kOfxImagePropField,
            text(render.map_or(kOfxImageFieldNone, |r| r.field)),
        ),
        (
            kOfxImagePropUniqueIdentifier,
            vec![Value::text(&identifier)],
        ),
    ];
    let factor = host.profile.image_scale_factor;
    if factor != 0.0 {
        let scale = render.map_or((1.0, 1.0), |r| r.scale);
        rows.push((
            kOfxImageEffectPropRenderScale,
            vec![
                Value::Double(scale.0 * factor),
                Value::Double(scale.1 * factor),
            ],
        ));
    }
    rows.into_iter()
        .map(|(name, values)| (property_name(name), values))
        .collect()
}

/// Implements `clipReleaseImage`.
pub(crate) fn release(host: &Host, set: &PropertySet) -> OfxStatus {
    let Some(image) = locked(&host.images).remove(&set.handle()) else {
        host.record_misuse(format!(
            "clipReleaseImage was given {}, which is not an image",
            set.name
        ));
        return kOfxStatErrBadHandle;
    };
    host.invalidate(set.handle());
    host.counters.images_held.fetch_sub(1, Ordering::SeqCst);
    if let Some(buffer) = &image.buffer
        && !image.is_output
    {
        timed(&host.image_work, || {
            if buffer.has_changed() {
                host.record_misuse(format!("the input image of {} was written to", image.clip));
            }
            buffer.overwrite();
        });
    }
    kOfxStatOK
}

/// Releases the images that the plugin still holds from a render, or from no render. Returns their clips.
pub(crate) fn reclaim(host: &Host, render: Option<&Arc<ActiveRender>>) -> Vec<String> {
    let render = render.map_or(0, identity);
    let mut images = locked(&host.images);
    let held: Vec<usize> = (images.iter().filter(|(_, image)| image.render == render))
        .map(|(handle, _)| *handle)
        .collect();
    held.into_iter()
        .filter_map(|handle| {
            host.invalidate(handle);
            host.counters.images_held.fetch_sub(1, Ordering::SeqCst);
            images.remove(&handle).map(|image| image.clip)
        })
        .collect()
}

/// Returns a number that no other render in progress has.
fn identity(render: &Arc<ActiveRender>) -> usize {
    Arc::as_ptr(render) as usize
}
