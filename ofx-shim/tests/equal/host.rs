//! A host with only what these tests need. Handles are addresses of objects, and an object is also its own property
//! set and parameter set.

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::mem::{transmute, zeroed};
use std::ptr::null_mut;
use std::sync::{Arc, LazyLock, Mutex};

use seidel_ofx::sys::effect::OfxImageEffectSuiteV1;
use seidel_ofx::sys::message::OfxMessageSuiteV2;
use seidel_ofx::sys::param::OfxParameterSuiteV1;
use seidel_ofx::sys::property::OfxPropertySuiteV1;
use seidel_ofx::sys::{Handle, OfxEntry, OfxHost, OfxRectD, OfxStatus};

use crate::lenses::{LENS, OTHER_LENS};
use crate::picture::Picture;
use crate::{HEIGHT, WIDTH};

#[derive(Clone, Debug)]
enum Value {
    Int(c_int),
    Double(f64),
    Text(CString),
    Pointer(usize),
}

type Table<T> = Mutex<BTreeMap<String, T>>;

/// An object behind a handle: effect, clip, parameter, image or arguments.
#[derive(Default)]
struct Object {
    properties: Table<Vec<Value>>,
    clips: Table<Box<Object>>,
    params: Table<Box<Object>>,
    /// Value of a parameter; its default if `None`.
    value: Mutex<Option<Vec<Value>>>,
    picture: Mutex<Option<Picture>>,
    /// Images that the plugin fetched.
    images: Mutex<Vec<Arc<Object>>>,
    /// Texts of messages.
    messages: Mutex<Vec<String>>,
}

fn name_of(name: *const c_char) -> String {
    // SAFETY: plugins pass C strings.
    let name = unsafe { CStr::from_ptr(name) };
    name.to_string_lossy().into_owned()
}

/// Returns the object of a handle.
fn object<'a>(handle: Handle) -> &'a Object {
    assert!(!handle.is_null());
    // SAFETY: handles are addresses of objects that live as long as the host of a test.
    unsafe { &*handle.cast::<Object>() }
}

fn handle(object: &Object) -> Handle {
    (&raw const *object).cast_mut().cast()
}

impl Object {
    fn set(&self, name: &str, index: usize, value: Value) {
        let mut properties = self.properties.lock().expect("no panic");
        let values = properties.entry(name.to_owned()).or_default();
        values.resize(values.len().max(index + 1), value.clone());
        values[index] = value;
    }

    fn get(&self, name: &str, index: usize) -> Option<Value> {
        let properties = self.properties.lock().expect("no panic");
        properties.get(name)?.get(index).cloned()
    }

    fn set_all(&self, name: &str, values: impl IntoIterator<Item = Value>) {
        for (index, value) in values.into_iter().enumerate() {
            self.set(name, index, value);
        }
    }

    fn text(name: &CStr) -> Value {
        Value::Text(name.to_owned())
    }
}

unsafe extern "C" fn set_int(h: Handle, name: *const c_char, index: c_int, value: c_int) -> c_int {
    object(h).set(&name_of(name), index as usize, Value::Int(value));
    0
}

unsafe extern "C" fn set_double(h: Handle, name: *const c_char, index: c_int, value: f64) -> c_int {
    object(h).set(&name_of(name), index as usize, Value::Double(value));
    0
}

unsafe extern "C" fn set_string(
    h: Handle,
    name: *const c_char,
    index: c_int,
    value: *const c_char,
) -> c_int {
    let value = CString::new(name_of(value)).expect("no zero");
    object(h).set(&name_of(name), index as usize, Value::Text(value));
    0
}

/// Writes the value of a property that `pick` accepts to `out`.
unsafe fn write_property<T>(
    h: Handle,
    name: *const c_char,
    index: c_int,
    out: *mut T,
    pick: impl Fn(&Value) -> Option<T>,
) -> c_int {
    let properties = object(h).properties.lock().expect("no panic");
    let values = properties.get(&name_of(name));
    let value = values.and_then(|values| values.get(index as usize));
    match value.and_then(pick) {
        Some(value) => {
            // SAFETY: plugins pass memory for a value.
            unsafe { out.write(value) };
            0
        }
        None => 3,
    }
}

unsafe extern "C" fn get_int(h: Handle, n: *const c_char, i: c_int, out: *mut c_int) -> c_int {
    let pick = |value: &Value| match value {
        Value::Int(value) => Some(*value),
        _ => None,
    };
    // SAFETY: the plugin passes memory for a value, here and below.
    unsafe { write_property(h, n, i, out, pick) }
}

unsafe extern "C" fn get_double(h: Handle, n: *const c_char, i: c_int, out: *mut f64) -> c_int {
    let pick = |value: &Value| match value {
        Value::Double(value) => Some(*value),
        _ => None,
    };
    // SAFETY: as above.
    unsafe { write_property(h, n, i, out, pick) }
}

unsafe extern "C" fn get_string(
    h: Handle,
    n: *const c_char,
    i: c_int,
    out: *mut *mut c_char,
) -> c_int {
    let pick = |value: &Value| match value {
        Value::Text(value) => Some(value.as_ptr().cast_mut()),
        _ => None,
    };
    // SAFETY: as above.
    unsafe { write_property(h, n, i, out, pick) }
}

unsafe extern "C" fn get_pointer(
    h: Handle,
    n: *const c_char,
    i: c_int,
    out: *mut *mut c_void,
) -> c_int {
    let pick = |value: &Value| match value {
        Value::Pointer(value) => Some(std::ptr::with_exposed_provenance_mut(*value)),
        _ => None,
    };
    // SAFETY: as above.
    unsafe { write_property(h, n, i, out, pick) }
}

/// Writes a handle to `out`, unless that is NULL.
unsafe fn write_handle(out: *mut Handle, value: Handle) {
    if !out.is_null() {
        // SAFETY: plugins pass memory for a handle.
        unsafe { out.write(value) };
    }
}

/// Returns the property set or parameter set of an object: the object itself.
unsafe extern "C" fn own_set(h: Handle, out: *mut Handle) -> c_int {
    // SAFETY: as above.
    unsafe { write_handle(out, h) };
    0
}

unsafe extern "C" fn clip_define(h: Handle, name: *const c_char, out: *mut Handle) -> c_int {
    let mut clips = object(h).clips.lock().expect("no panic");
    let clip = clips.entry(name_of(name)).or_default();
    // SAFETY: as above.
    unsafe { write_handle(out, handle(clip)) };
    0
}

unsafe extern "C" fn clip_handle(
    h: Handle,
    name: *const c_char,
    out: *mut Handle,
    properties: *mut Handle,
) -> c_int {
    let clips = object(h).clips.lock().expect("no panic");
    let Some(clip) = clips.get(&name_of(name)) else {
        return 3;
    };
    // SAFETY: as above.
    unsafe {
        write_handle(out, handle(clip));
        write_handle(properties, handle(clip));
    }
    0
}

unsafe extern "C" fn clip_image(
    h: Handle,
    _time: f64,
    _region: *const OfxRectD,
    out: *mut Handle,
) -> c_int {
    let clip = object(h);
    let mut picture = clip.picture.lock().expect("no panic");
    let Some(picture) = picture.as_mut() else {
        return 1;
    };
    let image = Arc::new(Object::default());
    let row = picture.row_samples();
    let last = picture.samples.len() - row;
    let data = picture.samples.as_mut_ptr();
    let (bottom, step) = if picture.is_top_down {
        (data.wrapping_add(last), -1)
    } else {
        (data, 1)
    };
    image.set(
        "OfxImagePropData",
        0,
        Value::Pointer(bottom.expose_provenance()),
    );
    image.set_all("OfxImagePropBounds", picture.bounds.map(Value::Int));
    image.set(
        "OfxImagePropRowBytes",
        0,
        Value::Int(step * 4 * row as c_int),
    );
    let components = match picture.channels {
        1 => c"OfxImageComponentAlpha",
        3 => c"OfxImageComponentRGB",
        _ => c"OfxImageComponentRGBA",
    };
    image.set("OfxImageEffectPropComponents", 0, Object::text(components));
    image.set(
        "OfxImageEffectPropPixelDepth",
        0,
        Object::text(c"OfxBitDepthFloat"),
    );
    // SAFETY: as above.
    unsafe { write_handle(out, handle(&image)) };
    clip.images.lock().expect("no panic").push(image);
    0
}

unsafe extern "C" fn release_image(_: Handle) -> c_int {
    // Images are dropped with their clip.
    0
}

unsafe extern "C" fn region(h: Handle, _time: f64, out: *mut OfxRectD) -> c_int {
    let picture = object(h).picture.lock().expect("no panic");
    let Some(picture) = picture.as_ref() else {
        return 1;
    };
    let scale = match object(h).get("scale", 0) {
        Some(Value::Double(scale)) => scale,
        _ => 1.0,
    };
    let [x1, y1, x2, y2] = picture.bounds.map(|v| f64::from(v) / scale);
    // SAFETY: plugins pass memory for a rectangle.
    unsafe { out.write(OfxRectD { x1, y1, x2, y2 }) };
    0
}

unsafe extern "C" fn is_aborted(_: Handle) -> c_int {
    0
}

unsafe extern "C" fn define(
    h: Handle,
    kind: *const c_char,
    name: *const c_char,
    out: *mut Handle,
) -> c_int {
    let mut params = object(h).params.lock().expect("no panic");
    let param = params.entry(name_of(name)).or_default();
    let kind = CString::new(name_of(kind)).expect("no zero");
    param.set("OfxParamPropType", 0, Value::Text(kind));
    // SAFETY: as above.
    unsafe { write_handle(out, handle(param)) };
    0
}

unsafe extern "C" fn param_handle(
    h: Handle,
    name: *const c_char,
    out: *mut Handle,
    properties: *mut Handle,
) -> c_int {
    let params = object(h).params.lock().expect("no panic");
    let Some(param) = params.get(&name_of(name)) else {
        return 3;
    };
    // SAFETY: as above.
    unsafe {
        write_handle(out, handle(param));
        write_handle(properties, handle(param));
    }
    0
}

/// Writes one or two values, as many as the parameter has.
unsafe extern "C" fn value_at_time(h: Handle, _: f64, a: *mut c_void, b: *mut c_void) -> c_int {
    let param = object(h);
    let value = param.value.lock().expect("no panic");
    let default = || {
        let defaults = (0..2).map_while(|k| param.get("OfxParamPropDefault", k));
        defaults.collect()
    };
    let values = value.clone().unwrap_or_else(default);
    for (out, own) in [a, b].into_iter().zip(&values) {
        // SAFETY: plugins pass memory for the values of the parameter's type.
        unsafe {
            match own {
                Value::Int(value) => out.cast::<c_int>().write(*value),
                Value::Double(value) => out.cast::<f64>().write(*value),
                Value::Text(_) | Value::Pointer(_) => {
                    let Some(Value::Text(text)) = value.as_ref().map(|v| &v[0]) else {
                        out.cast::<*const c_char>().write(c"".as_ptr());
                        continue;
                    };
                    out.cast::<*const c_char>().write(text.as_ptr());
                }
            }
        }
    }
    if values.is_empty() { 3 } else { 0 }
}

unsafe extern "C" fn message(
    h: Handle,
    _kind: *const c_char,
    _id: *const c_char,
    format: *const c_char,
) -> c_int {
    let text = name_of(format).replace("%%", "%");
    object(h).messages.lock().expect("no panic").push(text);
    0
}

/// The suites and the host, which all tests share. The host has no properties.
struct Suites {
    property: OfxPropertySuiteV1,
    effect: OfxImageEffectSuiteV1,
    param: OfxParameterSuiteV1,
    message: OfxMessageSuiteV2,
    host: OfxHost,
}

// SAFETY: the struct holds functions and NULL pointers.
unsafe impl Sync for Suites {}
// SAFETY: as above.
unsafe impl Send for Suites {}

static SUITES: LazyLock<Suites> = LazyLock::new(|| {
    // SAFETY: zeroed functions and pointers are `None` and NULL. On the platforms of these tests, functions with a fixed
    // number of pointers get the same arguments from variadic calls.
    unsafe {
        Suites {
            property: OfxPropertySuiteV1 {
                set_string: Some(set_string),
                set_double: Some(set_double),
                set_int: Some(set_int),
                get_pointer: Some(get_pointer),
                get_string: Some(get_string),
                get_double: Some(get_double),
                get_int: Some(get_int),
                ..zeroed()
            },
            effect: OfxImageEffectSuiteV1 {
                property_set: Some(own_set),
                param_set: Some(own_set),
                clip_define: Some(clip_define),
                clip_handle: Some(clip_handle),
                clip_property_set: Some(own_set),
                clip_image: Some(clip_image),
                release_image: Some(release_image),
                clip_region_of_definition: Some(region),
                abort: Some(is_aborted),
                ..zeroed()
            },
            param: OfxParameterSuiteV1 {
                define: Some(define),
                handle: Some(param_handle),
                value_at_time: Some(transmute::<
                    unsafe extern "C" fn(Handle, f64, *mut c_void, *mut c_void) -> c_int,
                    unsafe extern "C" fn(Handle, f64, ...) -> c_int,
                >(value_at_time)),
                ..zeroed()
            },
            message: OfxMessageSuiteV2 {
                set_persistent: Some(transmute::<
                    unsafe extern "C" fn(
                        Handle,
                        *const c_char,
                        *const c_char,
                        *const c_char,
                    ) -> c_int,
                    unsafe extern "C" fn(
                        Handle,
                        *const c_char,
                        *const c_char,
                        *const c_char,
                        ...
                    ) -> c_int,
                >(message)),
                ..zeroed()
            },
            host: OfxHost {
                host: null_mut(),
                fetch_suite: Some(fetch),
            },
        }
    }
});

unsafe extern "C" fn fetch(_: Handle, name: *const c_char, version: c_int) -> *const c_void {
    match (name_of(name).as_str(), version) {
        ("OfxPropertySuite", 1) => (&raw const SUITES.property).cast(),
        ("OfxImageEffectSuite", 1) => (&raw const SUITES.effect).cast(),
        ("OfxParameterSuite", 1) => (&raw const SUITES.param).cast(),
        ("OfxMessageSuite", 2) => (&raw const SUITES.message).cast(),
        _ => std::ptr::null(),
    }
}

/// The loaded plugin with an instance.
pub(crate) struct Host {
    entry: OfxEntry,
    effect: Box<Object>,
}

impl Drop for Host {
    fn drop(&mut self) {
        self.perform(c"OfxActionDestroyInstance", &Object::default());
        self.perform(c"OfxActionUnload", &Object::default());
    }
}

impl Host {
    pub(crate) fn new() -> Self {
        let plugin = seidel_ofx::OfxGetPlugin(0);
        // SAFETY: the plugin is static.
        let plugin = unsafe { &*plugin };
        let host = &raw const SUITES.host;
        let set_host = plugin.set_host.expect("set");
        // SAFETY: the host lives as long as the process.
        unsafe { set_host(host.cast_mut()) };
        let host = Self {
            entry: plugin.main_entry.expect("set"),
            effect: Box::default(),
        };
        for action in [
            c"OfxActionLoad",
            c"OfxActionDescribe",
            c"OfxImageEffectActionDescribeInContext",
            c"OfxActionCreateInstance",
        ] {
            assert_eq!(host.perform(action, &Object::default()), 0, "{action:?}");
        }
        host.set_project(1.0);
        host.choose("lens", "Lens File");
        host.set_text("profile", &LENS.to_string_lossy());
        host.choose("toLens", "Lens File");
        host.set_text("toProfile", &OTHER_LENS.to_string_lossy());
        host
    }

    fn perform(&self, action: &CStr, arguments: &Object) -> OfxStatus {
        let effect = handle(&self.effect);
        // SAFETY: the objects live until the action returns.
        unsafe { (self.entry)(action.as_ptr(), effect, handle(arguments), null_mut()) }
    }

    fn set_project(&self, scale: f64) {
        let size = [f64::from(WIDTH) / scale, f64::from(HEIGHT) / scale];
        let effect = &self.effect;
        effect.set_all("OfxImageEffectPropProjectSize", size.map(Value::Double));
        effect.set_all(
            "OfxImageEffectPropProjectOffset",
            [0.0; 2].map(Value::Double),
        );
    }

    fn set_values(&self, name: &str, values: Vec<Value>) {
        let params = self.effect.params.lock().expect("no panic");
        let param = params.get(name).unwrap_or_else(|| panic!("{name}"));
        *param.value.lock().expect("no panic") = Some(values);
    }

    pub(crate) fn set(&self, name: &str, value: f64) {
        self.set_values(name, vec![Value::Double(value)]);
    }

    pub(crate) fn set_pair(&self, name: &str, x: f64, y: f64) {
        self.set_values(name, vec![Value::Double(x), Value::Double(y)]);
    }

    /// Sets a menu to the option with this label.
    pub(crate) fn choose(&self, name: &str, label: &str) {
        let params = self.effect.params.lock().expect("no panic");
        let options = params[name].properties.lock().expect("no panic");
        let options = &options["OfxParamPropChoiceOption"];
        let is_wanted = |option: &Value| matches!(option, Value::Text(text) if text.to_bytes() == label.as_bytes());
        let index = options.iter().position(is_wanted);
        let index = index.unwrap_or_else(|| panic!("{name} has no {label}: {options:?}"));
        *params[name].value.lock().expect("no panic") = Some(vec![Value::Int(index as c_int)]);
    }

    pub(crate) fn set_text(&self, name: &str, value: &str) {
        let value = CString::new(value).expect("no zero");
        self.set_values(name, vec![Value::Text(value)]);
    }

    /// Connects a clip to a picture, or disconnects it.
    pub(crate) fn connect(&self, clip: &str, picture: Option<Picture>) {
        let clips = self.effect.clips.lock().expect("no panic");
        let connected = c_int::from(picture.is_some());
        clips[clip].set("OfxImageClipPropConnected", 0, Value::Int(connected));
        *clips[clip].picture.lock().expect("no panic") = picture;
    }

    pub(crate) fn messages(&self) -> Vec<String> {
        self.effect.messages.lock().expect("no panic").clone()
    }

    pub(crate) fn render(&self, source: &Picture, window: [i32; 4]) -> Picture {
        self.render_at(source, window, 1.0)
    }

    /// Renders a picture that has `scale` times the full resolution.
    pub(crate) fn render_at(&self, source: &Picture, window: [i32; 4], scale: f64) -> Picture {
        let result = self.try_render_at(source, window, scale);
        result.unwrap_or_else(|status| panic!("{status}: {:?}", self.messages()))
    }

    pub(crate) fn try_render(&self, source: &Picture, window: [i32; 4]) -> Result<(), OfxStatus> {
        self.try_render_at(source, window, 1.0).map(|_| ())
    }

    fn try_render_at(
        &self,
        source: &Picture,
        window: [i32; 4],
        scale: f64,
    ) -> Result<Picture, OfxStatus> {
        self.set_project(scale);
        self.connect("Source", Some(source.clone()));
        let empty = Picture::new(window, source.channels, |_, _, _| f32::NAN);
        self.connect("Output", Some(empty));
        for clip in self.effect.clips.lock().expect("no panic").values() {
            clip.set("scale", 0, Value::Double(scale));
        }
        let arguments = Object::default();
        arguments.set("OfxPropTime", 0, Value::Double(1.0));
        arguments.set_all("OfxImageEffectPropRenderWindow", window.map(Value::Int));
        arguments.set_all(
            "OfxImageEffectPropRenderScale",
            [scale; 2].map(Value::Double),
        );
        let status = self.perform(c"OfxImageEffectActionRender", &arguments);
        let clips = self.effect.clips.lock().expect("no panic");
        let out = clips["Output"].picture.lock().expect("no panic").take();
        match status {
            0 => Ok(out.expect("connected")),
            status => Err(status),
        }
    }
}
