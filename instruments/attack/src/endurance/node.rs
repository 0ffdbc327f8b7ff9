//! Renders of the OpenFX plugin in the test host, with knobs that move between frames.

use std::ffi::CString;
use std::ops::Range;

use seidel_ofx_host::drive::{Instance, Library, LoadedPlugin, RenderRequest};
use seidel_ofx_host::host::Host;
use seidel_ofx_host::host::effect::ParameterValue;
use seidel_ofx_host::host::profile::Profile;
use seidel_ofx_host::picture::{Rect, plate};
use seidel_ofx_host::runner::built_plugin;
use seidel_ofx_host::scene::Scene;

use super::Watch;
use crate::options::Options;

/// Bounds of the picture.
const BOUNDS: Rect = Rect::new(0, 0, 45, 37);

/// Positions of the knobs; renders repeat them.
const POSITIONS: usize = 97;

/// Renders on one instance, in one host. The host keeps a record of every handle that it gave out.
const RENDERS_OF_HOST: usize = 500;

/// Renders `renders` frames, and compares each with the first one at the same position of the knobs.
pub(super) fn run(renders: usize, _: &Options, watch: &mut Watch) -> Result<(), String> {
    let file = built_plugin("seidel_ofx")?;
    let library = Library::open(&file)?;
    let bundle = CString::new(file.to_string_lossy().into_owned()).unwrap_or_default();
    watch.begin(std::process::id());
    let mut first = vec![None; POSITIONS];
    for begin in (0..renders).step_by(RENDERS_OF_HOST) {
        let host = Host::activate(Profile::complete());
        host.set_path(&bundle);
        let plugin = library.find(None)?;
        let loaded = LoadedPlugin::load(&host, &plugin)?;
        let batch = begin..renders.min(begin + RENDERS_OF_HOST);
        let rendered = render_batch(&loaded, batch, &mut first);
        let unloaded = loaded.unload();
        let faults = host.take_misuse().into_iter();
        let fault = faults.chain(host.held_resources()).next();
        rendered?;
        unloaded?;
        if let Some(fault) = fault {
            return Err(fault);
        }
    }
    library.close()
}

/// Renders frames on one instance. `first` holds the samples of the first one at each position of the knobs.
fn render_batch(
    loaded: &LoadedPlugin<'_>,
    batch: Range<usize>,
    first: &mut [Option<Vec<u32>>],
) -> Result<(), String> {
    let scene = Scene::new(plate(BOUNDS, 4, 1));
    let context = loaded.context(&scene)?;
    let instance = Instance::new(loaded, &context, &scene)?;
    for render in batch {
        let position = render % POSITIONS;
        for (name, value) in knobs(position) {
            instance.edit(name, &value)?;
        }
        let frame = instance.render_checked(&RenderRequest::default())?;
        let samples = frame.picture.samples.iter();
        let bits: Vec<u32> = samples.map(|v| v.to_bits()).collect();
        let known = first[position].get_or_insert_with(|| bits.clone());
        if *known != bits {
            return Err(format!(
                "render {render} differs from the first at position {position} of the knobs"
            ));
        }
    }
    instance.destroy()
}

/// Returns the knobs that differ between positions, with their values.
fn knobs(position: usize) -> Vec<(&'static str, ParameterValue)> {
    let share = position as f64 / POSITIONS as f64;
    let number = |value: f64| ParameterValue::Doubles(vec![value]);
    let choice = |value: usize| ParameterValue::Ints(vec![value as i32]);
    // Each twentieth position removes blur, which takes longest.
    let is_removal = position % 20 == 19;
    vec![
        ("mode", choice(usize::from(is_removal))),
        ("lens", choice(1)),
        ("lensScale", number(0.15 + 0.2 * share)),
        ("distance", number(0.8 + 3.0 * share)),
        ("amount", number(0.3 + share)),
        ("math", choice(position % 2)),
        ("maxSize", number(6.0)),
        ("quality", choice(0)),
        ("edge", choice(position % 3)),
        ("geometry", choice(position % 3)),
        ("mix", number(1.0 - 0.3 * share)),
    ]
}
