//! Render times of a node in a host, as shares of its first render: with another mix, another mask or another focus, and as a proxy;
//! and how long a render that the host aborts goes on.
//!
//! `cargo bench -p seidel-ofx --bench interactive [-- WIDTH HEIGHT]`; HD if omitted.

use std::time::Duration;

use seidel_ofx_host::drive::{Instance, Library, LoadedPlugin, RenderRequest};
use seidel_ofx_host::host::Host;
use seidel_ofx_host::host::effect::ParameterValue;
use seidel_ofx_host::host::profile::Profile;
use seidel_ofx_host::host::render_time::RenderTime;
use seidel_ofx_host::picture::{Picture, Rect, noise};
use seidel_ofx_host::runner::built_plugin;
use seidel_ofx_host::scene::{Input, Scene};

type Result<T> = std::result::Result<T, String>;

/// Rounds of which the median counts.
const ROUNDS: usize = 3;
/// Moments of a render at which the host aborts.
const MOMENTS: u32 = 10;

fn main() -> Result<()> {
    let sizes: Vec<i32> = (std::env::args().skip(1))
        .filter_map(|argument| argument.parse().ok())
        .collect();
    let (width, height) = match sizes[..] {
        [width, height] => (width, height),
        _ => (1920, 1080),
    };
    let bounds = Rect::new(0, 0, width, height);
    let library = Library::open(&built_plugin("seidel_ofx")?)?;
    let plugin = library.find(None)?;
    let host = Host::activate(Profile::complete());
    let loaded = LoadedPlugin::load(&host, &plugin)?;
    let measured = measure(&loaded, bounds).and_then(|times| {
        let delays = abort_delays(&loaded, bounds)?;
        Ok((times, delays))
    });
    loaded.unload()?;
    let (times, delays) = measured?;
    println!(
        "{width} x {height}, with depth. CPU s: of all threads, without the host's work on images\n"
    );
    println!("| render | s | CPU s | share of the first |\n| --- | --- | --- | --- |");
    let first = times[0].1.cpu.as_secs_f64();
    for (name, time) in times {
        let (elapsed, cpu) = (time.elapsed.as_secs_f64(), time.cpu.as_secs_f64());
        let share = 100.0 * cpu / first;
        println!("| {name} | {elapsed:.3} | {cpu:.3} | {share:.1} % |");
    }
    println!(
        "\n| output, aborted at {MOMENTS} moments | longest wait for the end, s, without the host's own work |\n| --- | --- |"
    );
    for (name, longest) in delays {
        println!("| {name} | {:.3} |", longest.as_secs_f64());
    }
    Ok(())
}

/// An opaque plate of noise and a gradient, with a small light on one of 5000 pixels.
fn plate(bounds: Rect) -> Picture {
    Picture::from_fn(bounds, 4, |x, y, c| {
        let light = if noise(x, y, 9, 1) > 0.9998 {
            20.0
        } else {
            0.0
        };
        let gradient = 0.1 + 0.3 * x as f32 / bounds.width() as f32;
        if c == 3 {
            1.0
        } else {
            gradient + 0.4 * noise(x, y, c, 1) + light
        }
    })
}

/// Depth of a floor from 1.5 to 20 m with two cards on it.
fn depth(bounds: Rect) -> Picture {
    let (width, height) = (bounds.width() as f32, bounds.height() as f32);
    Picture::from_fn(bounds, 1, |x, y, _| {
        let (u, v) = (x as f32 / width, y as f32 / height);
        if (0.2..0.35).contains(&u) && v < 0.7 {
            2.0
        } else if (0.55..0.8).contains(&u) && v < 0.5 {
            4.0
        } else {
            1.0 / (1.0 / 1.5 - v * (1.0 / 1.5 - 1.0 / 20.0))
        }
    })
}

fn scene(bounds: Rect) -> Scene {
    let mask = Picture::from_fn(bounds, 1, |x, _, _| x as f32 / bounds.width() as f32);
    Scene::new(plate(bounds))
        .connect("Depth", Input::still(depth(bounds)))
        .connect("Mask", Input::still(mask))
}

fn measure(loaded: &LoadedPlugin, bounds: Rect) -> Result<Vec<(&'static str, RenderTime)>> {
    let scene = scene(bounds);
    let context = loaded.context(&scene)?;
    let set = |instance: &Instance, name: &str, value: f64| {
        instance.edit(name, &ParameterValue::Doubles(vec![value]))
    };
    let mut all: Vec<(&'static str, Vec<RenderTime>)> = Vec::new();
    let mut note = |name, time| match all.iter_mut().find(|(other, _)| *other == name) {
        Some((_, times)) => times.push(time),
        None => all.push((name, vec![time])),
    };
    for _ in 0..ROUNDS {
        let instance = Instance::new(loaded, &context, &scene)?;
        let timed = |request: &RenderRequest| {
            let frame = instance.render(request)?;
            match frame.status {
                0 => Ok(frame.time),
                status => Err(format!("render: status {status}: {:?}", frame.message)),
            }
        };
        let whole = RenderRequest::default();
        let half = RenderRequest {
            scale: (0.5, 0.5),
            ..RenderRequest::default()
        };
        instance.act(c"OfxActionPurgeCaches");
        instance.edit("useMask", &ParameterValue::Ints(vec![0]))?;
        instance.edit("focus", &ParameterValue::Ints(vec![1]))?;
        note("first render", timed(&whole)?);
        set(&instance, "mix", 0.7)?;
        note("another mix", timed(&whole)?);
        instance.edit("useMask", &ParameterValue::Ints(vec![1]))?;
        note("another mask", timed(&whole)?);
        set(&instance, "focusDistance", 2.2)?;
        note("another focus", timed(&whole)?);
        instance.act(c"OfxActionPurgeCaches");
        note("proxy at half size, first render", timed(&half)?);
        instance.destroy()?;
    }
    let median = |mut times: Vec<RenderTime>| {
        times.sort_by_key(|time| (time.cpu, time.elapsed));
        times[times.len() / 2]
    };
    Ok(all
        .into_iter()
        .map(|(name, times)| (name, median(times)))
        .collect())
}

/// Returns, for some outputs, the longest time from the moment when the host begins to abort until the action ends, without
/// the host's own work on images.
fn abort_delays(loaded: &LoadedPlugin, bounds: Rect) -> Result<Vec<(&'static str, Duration)>> {
    let scene = scene(bounds);
    let context = loaded.context(&scene)?;
    let instance = Instance::new(loaded, &context, &scene)?;
    instance.edit("focus", &ParameterValue::Ints(vec![1]))?;
    let mut all = Vec::new();
    for (name, index) in [
        ("Result", 0),
        ("Focal Plane Setup", 1),
        ("PSF Grid", 4),
        ("CoC Map", 5),
    ] {
        instance.edit("output", &ParameterValue::Ints(vec![index]))?;
        instance.act(c"OfxActionPurgeCaches");
        let whole = instance.render(&RenderRequest::default())?.time.elapsed;
        let mut longest = Duration::ZERO;
        for moment in 0..MOMENTS {
            instance.act(c"OfxActionPurgeCaches");
            let after = whole * moment / MOMENTS;
            let request = RenderRequest {
                abort_after: Some(after),
                ..RenderRequest::default()
            };
            longest = longest.max(instance.render(&request)?.time.after_abort);
        }
        all.push((name, longest));
    }
    instance.destroy()?;
    Ok(all)
}
