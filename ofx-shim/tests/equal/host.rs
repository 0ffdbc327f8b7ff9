//! A host of no more than these tests need. Handles are addresses of objects; an object knows its properties and what
//! it holds.

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

/// Whatever a handle stands for.
#[derive(Default)]
struct Object {
    properties: Table<Vec<Value>>,
    clips: Table<Box<Object>>,
    params: Table<Box<Object>>,
    /// What a parameter is set to.
    value: Mutex<Option<Vec<Value>>>,
    picture: Mutex<Option<Picture>>,
    /// Pictures that are out.
    images: Mutex<Vec<Arc<Object>>>,
    said: Mutex<Vec<String>>,
}

fn name_of(name: *const c_char) -> String {
    // SAFETY: plugins give texts with a zero at their end.
    let name = unsafe { CStr::from_ptr(name) };
    name.to_string_lossy().into_owned()
}

/// The object of a handle.
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

    fn all(&self, name: &str, values: impl IntoIterator<Item = Value>) {
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

/// Puts what `pick` makes of a property to `out`.
unsafe fn give<T>(
    (h, name, index): (Handle, *const c_char, c_int),
    out: *mut T,
    pick: impl Fn(&Value) -> Option<T>,
) -> c_int {
    let properties = object(h).properties.lock().expect("no panic");
    let values = properties.get(&name_of(name));
    let value = values.and_then(|values| values.get(index as usize));
    match value.and_then(pick) {
        Some(value) => {
            // SAFETY: plugins give good places.
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
    // SAFETY: as the caller vouches, here and below.
    unsafe { give((h, n, i), out, pick) }
}

unsafe extern "C" fn get_double(h: Handle, n: *const c_char, i: c_int, out: *mut f64) -> c_int {
    let pick = |value: &Value| match value {
        Value::Double(value) => Some(*value),
        _ => None,
    };
    // SAFETY: as above.
    unsafe { give((h, n, i), out, pick) }
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
    unsafe { give((h, n, i), out, pick) }
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
    unsafe { give((h, n, i), out, pick) }
}

/// Puts a handle where a plugin wants it, if it does.
unsafe fn put(out: *mut Handle, value: Handle) {
    if !out.is_null() {
        // SAFETY: a good place.
        unsafe { out.write(value) };
    }
}

/// Properties, parameters and clips of an object are asked of the object.
unsafe extern "C" fn itself(h: Handle, out: *mut Handle) -> c_int {
    // SAFETY: as above.
    unsafe { put(out, h) };
    0
}

unsafe extern "C" fn clip_define(h: Handle, name: *const c_char, out: *mut Handle) -> c_int {
    let mut clips = object(h).clips.lock().expect("no panic");
    let clip = clips.entry(name_of(name)).or_default();
    // SAFETY: as above.
    unsafe { put(out, handle(clip)) };
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
        put(out, handle(clip));
        put(properties, handle(clip));
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
    let row = picture.row();
    let last = picture.samples.len() - row;
    let data = picture.samples.as_mut_ptr();
    let (bottom, step) = match picture.turned {
        true => (data.wrapping_add(last), -1),
        false => (data, 1),
    };
    image.set(
        "OfxImagePropData",
        0,
        Value::Pointer(bottom.expose_provenance()),
    );
    image.all("OfxImagePropBounds", picture.bounds.map(Value::Int));
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
    unsafe { put(out, handle(&image)) };
    clip.images.lock().expect("no panic").push(image);
    0
}

unsafe extern "C" fn release_image(_: Handle) -> c_int {
    // They go with their clip.
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
    // SAFETY: a good place.
    unsafe { out.write(OfxRectD { x1, y1, x2, y2 }) };
    0
}

unsafe extern "C" fn never(_: Handle) -> c_int {
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
    unsafe { put(out, handle(param)) };
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
        put(out, handle(param));
        put(properties, handle(param));
    }
    0
}

/// As many places as a parameter has values.
unsafe extern "C" fn value_at_time(h: Handle, _: f64, a: *mut c_void, b: *mut c_void) -> c_int {
    let param = object(h);
    let value = param.value.lock().expect("no panic");
    let default = || {
        let defaults = (0..2).map_while(|k| param.get("OfxParamPropDefault", k));
        defaults.collect()
    };
    let values = value.clone().unwrap_or_else(default);
    for (place, own) in [a, b].into_iter().zip(&values) {
        // SAFETY: plugins give places for what parameters hold.
        unsafe {
            match own {
                Value::Int(value) => place.cast::<c_int>().write(*value),
                Value::Double(value) => place.cast::<f64>().write(*value),
                Value::Text(_) | Value::Pointer(_) => {
                    let Some(Value::Text(text)) = value.as_ref().map(|v| &v[0]) else {
                        place.cast::<*const c_char>().write(c"".as_ptr());
                        continue;
                    };
                    place.cast::<*const c_char>().write(text.as_ptr());
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
    text: *const c_char,
) -> c_int {
    assert_eq!(name_of(format), "%s");
    object(h).said.lock().expect("no panic").push(name_of(text));
    0
}

/// What the host is asked for; all tests share it. It has no properties.
struct Suites {
    property: OfxPropertySuiteV1,
    effect: OfxImageEffectSuiteV1,
    param: OfxParameterSuiteV1,
    message: OfxMessageSuiteV2,
    host: OfxHost,
}

// SAFETY: functions, and pointers that are NULL.
unsafe impl Sync for Suites {}
// SAFETY: as above.
unsafe impl Send for Suites {}

static SUITES: LazyLock<Suites> = LazyLock::new(|| {
    // SAFETY: functions and pointers that may be NULL. Getters of a fixed number of places, and messages of one text, take
    // what variadic calls of pointers hand over on the platforms that these tests are for.
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
                property_set: Some(itself),
                param_set: Some(itself),
                clip_define: Some(clip_define),
                clip_handle: Some(clip_handle),
                clip_property_set: Some(itself),
                clip_image: Some(clip_image),
                release_image: Some(release_image),
                clip_region_of_definition: Some(region),
                abort: Some(never),
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

/// The plugin with an instance of it.
pub(crate) struct Host {
    entry: OfxEntry,
    effect: Box<Object>,
}

impl Drop for Host {
    fn drop(&mut self) {
        self.act(c"OfxActionDestroyInstance", &Object::default());
        self.act(c"OfxActionUnload", &Object::default());
    }
}

impl Host {
    pub(crate) fn new() -> Self {
        let plugin = seidel_ofx::OfxGetPlugin(0);
        // SAFETY: the plugin is static.
        let plugin = unsafe { &*plugin };
        let given = &raw const SUITES.host;
        let set_host = plugin.set_host.expect("it has one");
        // SAFETY: the host lives as long as the process.
        unsafe { set_host(given.cast_mut()) };
        let host = Self {
            entry: plugin.main_entry.expect("it has one"),
            effect: Box::default(),
        };
        for action in [
            c"OfxActionLoad",
            c"OfxActionDescribe",
            c"OfxImageEffectActionDescribeInContext",
            c"OfxActionCreateInstance",
        ] {
            assert_eq!(host.act(action, &Object::default()), 0, "{action:?}");
        }
        host.project(1.0);
        host.choose("lens", 0);
        host.set_text("profile", &LENS.to_string_lossy());
        host.choose("toLens", 0);
        host.set_text("toProfile", &OTHER_LENS.to_string_lossy());
        host
    }

    fn act(&self, action: &CStr, arguments: &Object) -> OfxStatus {
        let effect = handle(&self.effect);
        // SAFETY: objects live until the action is done.
        unsafe { (self.entry)(action.as_ptr(), effect, handle(arguments), null_mut()) }
    }

    fn project(&self, scale: f64) {
        let size = [f64::from(WIDTH) / scale, f64::from(HEIGHT) / scale];
        let effect = &self.effect;
        effect.all("OfxImageEffectPropProjectSize", size.map(Value::Double));
        effect.all(
            "OfxImageEffectPropProjectOffset",
            [0.0; 2].map(Value::Double),
        );
    }

    fn value(&self, name: &str, value: Vec<Value>) {
        let params = self.effect.params.lock().expect("no panic");
        let param = params.get(name).unwrap_or_else(|| panic!("{name}"));
        *param.value.lock().expect("no panic") = Some(value);
    }

    pub(crate) fn set(&self, name: &str, value: f64) {
        self.value(name, vec![Value::Double(value)]);
    }

    pub(crate) fn set_pair(&self, name: &str, (x, y): (f64, f64)) {
        self.value(name, vec![Value::Double(x), Value::Double(y)]);
    }

    pub(crate) fn choose(&self, name: &str, value: c_int) {
        self.value(name, vec![Value::Int(value)]);
    }

    pub(crate) fn set_text(&self, name: &str, value: &str) {
        let value = CString::new(value).expect("no zero");
        self.value(name, vec![Value::Text(value)]);
    }

    /// Connects a picture, or none.
    pub(crate) fn connect(&self, clip: &str, picture: Option<Picture>) {
        let clips = self.effect.clips.lock().expect("no panic");
        let connected = c_int::from(picture.is_some());
        clips[clip].set("OfxImageClipPropConnected", 0, Value::Int(connected));
        *clips[clip].picture.lock().expect("no panic") = picture;
    }

    pub(crate) fn said(&self) -> Vec<String> {
        self.effect.said.lock().expect("no panic").clone()
    }

    pub(crate) fn render(&self, source: &Picture, window: [i32; 4]) -> Picture {
        self.render_at(source, window, 1.0)
    }

    /// The same of a picture that is `scale` times as large as it would be at full resolution.
    pub(crate) fn render_at(&self, source: &Picture, window: [i32; 4], scale: f64) -> Picture {
        let rendered = self.rendered(source, window, scale);
        rendered.unwrap_or_else(|status| panic!("{status}: {:?}", self.said()))
    }

    pub(crate) fn try_render(&self, source: &Picture, window: [i32; 4]) -> Result<(), OfxStatus> {
        self.rendered(source, window, 1.0).map(|_| ())
    }

    fn rendered(
        &self,
        source: &Picture,
        window: [i32; 4],
        scale: f64,
    ) -> Result<Picture, OfxStatus> {
        self.project(scale);
        self.connect("Source", Some(source.clone()));
        let empty = Picture::made(window, source.channels, |_, _, _| f32::NAN);
        self.connect("Output", Some(empty));
        for clip in self.effect.clips.lock().expect("no panic").values() {
            clip.set("scale", 0, Value::Double(scale));
        }
        let arguments = Object::default();
        arguments.set("OfxPropTime", 0, Value::Double(1.0));
        arguments.all("OfxImageEffectPropRenderWindow", window.map(Value::Int));
        arguments.all(
            "OfxImageEffectPropRenderScale",
            [scale; 2].map(Value::Double),
        );
        let status = self.act(c"OfxImageEffectActionRender", &arguments);
        let clips = self.effect.clips.lock().expect("no panic");
        let out = clips["Output"].picture.lock().expect("no panic").take();
        match status {
            0 => Ok(out.expect("it was connected")),
            status => Err(status),
        }
    }
}
