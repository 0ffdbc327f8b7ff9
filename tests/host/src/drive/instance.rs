//! An instance, with its clips connected and its parameters set.

use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::arguments::{Arguments, at};
use super::{Loaded, act, status_name};
use crate::host::effect::{Clip, Effect, Setting};
use crate::host::properties::Value;
use crate::host::{Host, locked};
use crate::picture::Picture;
use crate::scene::{Feed, Scene};

/// An instance of a loaded plugin.
pub struct Instance<'l> {
    /// The plugin.
    pub loaded: &'l Loaded<'l>,
    /// The instance as the plugin knows it.
    pub effect: Arc<Effect>,
    destroyed: bool,
}

impl<'l> Instance<'l> {
    /// Describes in the context, creates, connects and asks for clip preferences.
    ///
    /// # Errors
    /// If the plugin refuses anything of it.
    pub fn new(loaded: &'l Loaded<'l>, context: &CStr, scene: &Scene) -> Result<Self, String> {
        let descriptor = loaded.describe_in(context)?;
        Self::of(loaded, &descriptor, context, scene)
    }

    /// The same of a descriptor that is there.
    ///
    /// # Errors
    /// If the plugin refuses.
    pub fn of(
        loaded: &'l Loaded<'l>,
        descriptor: &Effect,
        context: &CStr,
        scene: &Scene,
    ) -> Result<Self, String> {
        let instance = Self::uncreated(loaded, descriptor, context, scene);
        let status = instance.act(kOfxActionCreateInstance);
        if status != kOfxStatOK && status != kOfxStatReplyDefault {
            return Err(format!("CreateInstance gave {}", status_name(status)));
        }
        if loaded.host.profile.asks {
            instance.preferences()?;
        }
        Ok(instance)
    }

    /// An instance that CreateInstance has not been called on.
    #[must_use]
    pub fn uncreated(
        loaded: &'l Loaded<'l>,
        descriptor: &Effect,
        context: &CStr,
        scene: &Scene,
    ) -> Self {
        let host: &Host = loaded.host;
        let values = effect_values(loaded, context, scene);
        let set = host.property_set("effect instance", "the instance", values, false);
        let effect = Effect::new(host, set, true);
        for clip in descriptor.clips() {
            let values = clip.properties.all();
            let title = format!("clip {}", clip.name);
            let set = host.property_set("clip", &title, values, false);
            effect.add_clip(host, &clip.name, set);
        }
        for parameter in descriptor.parameters.all() {
            let kind = format!("parameter {}", parameter.kind.to_string_lossy());
            let mut values = parameter.properties.all();
            for (name, value) in [(kOfxParamPropSecret, 0), (kOfxParamPropEnabled, 1)] {
                values
                    .entry(name.to_string_lossy().into_owned())
                    .or_insert_with(|| vec![Value::Int(value)]);
            }
            let set = host.property_set(&kind, &kind, values, false);
            effect
                .parameters
                .add(host, &parameter.kind, &parameter.name, set);
        }
        let instance = Self {
            loaded,
            effect,
            destroyed: false,
        };
        instance.connect(scene);
        instance
    }

    /// Calls an action that has no arguments.
    pub fn act(&self, action: &CStr) -> OfxStatus {
        act(
            &self.loaded.plugin,
            action,
            self.effect.handle(),
            None,
            None,
            None,
        )
    }

    /// Connects the clips otherwise; whoever changes them after creation calls `preferences` too.
    pub fn connect(&self, scene: &Scene) {
        let mut scene = scene.clone();
        for clip in self.effect.clips() {
            let channels = self.channels(&clip, &scene);
            if let Some(input) = scene.inputs.get_mut(&clip.name)
                && let Feed::Pictures(all) = &mut input.feed
            {
                for picture in all.iter_mut() {
                    if picture.channels != channels {
                        *picture = Arc::new(converted(picture, channels));
                    }
                }
            }
        }
        for clip in self.effect.clips() {
            self.tell(&clip, &scene);
        }
        *locked(&self.effect.scene) = scene;
    }

    /// Channels of the clip's pictures in this host: its own if the clip takes them.
    fn channels(&self, clip: &Clip, scene: &Scene) -> usize {
        let own = (scene.input(&clip.name).picture(0.0)).map_or(4, |p| p.channels);
        let wanted = clip
            .properties
            .texts(kOfxImageEffectPropSupportedComponents);
        let takes = |channels: usize| {
            let name = Scene::components(channels);
            let host = &self.loaded.host.profile;
            wanted.iter().any(|w| w.as_bytes() == name.to_bytes())
                && host.components.contains(&name)
        };
        [own, 4, 3, 1]
            .into_iter()
            .find(|c| takes(*c))
            .unwrap_or(own)
    }

    /// Tells the plugin what a clip is connected to, by the clip's properties.
    fn tell(&self, clip: &Clip, scene: &Scene) {
        let host = &self.loaded.host.profile;
        let input = scene.input(&clip.name);
        let output = clip.name == "Output";
        let there = output || !matches!(input.feed, Feed::Unconnected);
        let of = if output { "Source" } else { &clip.name };
        let channels = scene.input(of).picture(0.0).map_or(4, |p| p.channels);
        let shown = there || host.all_connected;
        let components = if shown {
            Scene::components(channels)
        } else {
            kOfxImageComponentNone
        };
        let depth = if shown {
            host.samples
        } else {
            kOfxBitDepthNone
        };
        let opaque = if channels == 3 {
            kOfxImageOpaque
        } else {
            kOfxImagePreMultiplied
        };
        let premultiplication = scene.input(of).premultiplication.unwrap_or(opaque);
        let set = &clip.properties;
        let text = |value: &CStr| vec![Value::Text(value.to_owned())];
        set.put(kOfxPropType, text(kOfxTypeClip));
        set.put(kOfxPropName, vec![Value::text(&clip.name)]);
        set.put(
            kOfxImageClipPropConnected,
            vec![Value::Int(i32::from(shown))],
        );
        set.put(kOfxImageEffectPropComponents, text(components));
        set.put(kOfxImageClipPropUnmappedComponents, text(components));
        set.put(kOfxImageEffectPropPixelDepth, text(depth));
        set.put(kOfxImageClipPropUnmappedPixelDepth, text(depth));
        set.put(
            kOfxImageEffectPropPreMultiplication,
            text(premultiplication),
        );
        set.put(
            kOfxImagePropPixelAspectRatio,
            vec![Value::Double(scene.par)],
        );
        set.put(kOfxImageEffectPropFrameRate, vec![Value::Double(24.0)]);
        set.put(
            kOfxImageEffectPropUnmappedFrameRate,
            vec![Value::Double(24.0)],
        );
        let range = vec![Value::Double(0.0), Value::Double(100.0)];
        set.put(kOfxImageEffectPropFrameRange, range.clone());
        set.put(kOfxImageEffectPropUnmappedFrameRange, range);
        set.put(kOfxImageClipPropFieldOrder, text(kOfxImageFieldNone));
        set.put(kOfxImageClipPropContinuousSamples, vec![Value::Int(0)]);
    }

    /// Sets a parameter as a project does that is loaded: the plugin is not told.
    ///
    /// # Errors
    /// If there is no such parameter of that type.
    pub fn set(&self, name: &str, setting: &Setting) -> Result<(), String> {
        let parameter =
            (self.effect.parameters.get(name)).ok_or_else(|| format!("has no parameter {name}"))?;
        if parameter.set(setting.clone()) {
            Ok(())
        } else {
            Err(format!(
                "parameter {name} is not of the type of {setting:?}"
            ))
        }
    }

    /// Sets a parameter as a user does: the plugin is told.
    ///
    /// # Errors
    /// If there is no such parameter, or telling fails.
    pub fn change(&self, name: &str, setting: &Setting) -> Result<(), String> {
        self.set(name, setting)?;
        self.changed(kOfxTypeParameter, name, kOfxChangeUserEdited)
    }

    /// Tells the plugin that something has changed.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn changed(&self, kind: &CStr, name: &str, reason: &CStr) -> Result<(), String> {
        let host: &Host = self.loaded.host;
        let around = |action: &CStr| {
            let given = Arguments::default()
                .text(kOfxPropChangeReason, reason)
                .known(host, false, action);
            let status = self.with_arguments(action, &given);
            host.end(given.handle());
            status
        };
        let begun = around(kOfxActionBeginInstanceChanged);
        let given = at(0.0, (1.0, 1.0))
            .text(kOfxPropType, kind)
            .with(kOfxPropName, vec![Value::text(name)])
            .text(kOfxPropChangeReason, reason)
            .known(host, false, kOfxActionInstanceChanged);
        let status = self.with_arguments(kOfxActionInstanceChanged, &given);
        host.end(given.handle());
        let ended = around(kOfxActionEndInstanceChanged);
        for clip in crate::host::images::left_out(host, None) {
            host.misused(format!(
                "InstanceChanged left an image of {clip} unreleased"
            ));
        }
        for status in [begun, status, ended] {
            if status != kOfxStatOK && status != kOfxStatReplyDefault {
                return Err(format!(
                    "InstanceChanged of {name} gave {}",
                    status_name(status)
                ));
            }
        }
        if host.profile.asks {
            self.preferences()?;
        }
        Ok(())
    }

    fn with_arguments(
        &self,
        action: &CStr,
        given: &crate::host::properties::PropertySet,
    ) -> OfxStatus {
        act(
            &self.loaded.plugin,
            action,
            self.effect.handle(),
            Some(given),
            None,
            None,
        )
    }

    /// Calls GetClipPreferences and takes over what it wants of the components of inputs.
    ///
    /// # Errors
    /// If the plugin fails, or wants what it did not say it takes.
    pub fn preferences(&self) -> Result<(), String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetClipPreferences;
        let mut wanted = Arguments::default()
            .doubles(kOfxImageEffectPropFrameRate, &[24.0])
            .text(kOfxImageClipPropFieldOrder, kOfxImageFieldNone)
            .ints(kOfxImageClipPropContinuousSamples, &[0])
            .ints(kOfxImageEffectFrameVarying, &[0]);
        let scene = locked(&self.effect.scene).clone();
        let first = |clip: &Clip, name: &CStr| clip.properties.get(name).unwrap_or_default();
        for clip in self.effect.clips() {
            let name = &clip.name;
            let components = first(&clip, kOfxImageEffectPropComponents);
            let depth = first(&clip, kOfxImageEffectPropPixelDepth);
            wanted = wanted
                .of_clip("OfxImageClipPropComponents_", name, components)
                .of_clip("OfxImageClipPropDepth_", name, depth)
                .of_clip("OfxImageClipPropPAR_", name, vec![Value::Double(scene.par)]);
            if host.profile.api >= (1, 5) {
                wanted = wanted.of_clip("OfxImageClipPropPreferredColourspaces_", name, Vec::new());
            }
            if name == "Output" {
                let state = first(&clip, kOfxImageEffectPropPreMultiplication);
                wanted = wanted.with(kOfxImageEffectPropPreMultiplication, state);
            }
        }
        let wanted = wanted.known(host, true, action);
        let status = act(
            &self.loaded.plugin,
            action,
            self.effect.handle(),
            None,
            Some(&wanted),
            None,
        );
        let all = wanted.all();
        host.end(wanted.handle());
        if status == kOfxStatReplyDefault {
            return Ok(());
        }
        if status != kOfxStatOK {
            return Err(format!("GetClipPreferences gave {}", status_name(status)));
        }
        let mut scene = scene;
        for clip in self.effect.clips() {
            let chosen = all
                .get(&format!("OfxImageClipPropComponents_{}", clip.name))
                .and_then(|values| values.first());
            let Some(Value::Text(chosen)) = chosen else {
                continue;
            };
            let channels = [1, 3, 4]
                .into_iter()
                .find(|c| Scene::components(*c) == chosen.as_c_str());
            let takes = clip
                .properties
                .texts(kOfxImageEffectPropSupportedComponents);
            if let Some(channels) = channels {
                if !takes.iter().any(|t| t.as_bytes() == chosen.to_bytes()) {
                    return Err(format!(
                        "GetClipPreferences wants {chosen:?} of {}, which it does not take",
                        clip.name
                    ));
                }
                if let Some(input) = scene.inputs.get_mut(&clip.name)
                    && let Feed::Pictures(all) = &mut input.feed
                {
                    for picture in all.iter_mut() {
                        *picture = Arc::new(converted(picture, channels));
                    }
                }
            }
        }
        for clip in self.effect.clips() {
            self.tell(&clip, &scene);
        }
        *locked(&self.effect.scene) = scene;
        Ok(())
    }

    /// Channels of Output.
    #[must_use]
    pub fn output_channels(&self) -> usize {
        let scene = locked(&self.effect.scene);
        scene.input("Source").picture(0.0).map_or(4, |p| p.channels)
    }

    pub(super) fn asked(
        &self,
        action: &CStr,
        given: &crate::host::properties::PropertySet,
        wanted: Option<&crate::host::properties::PropertySet>,
    ) -> OfxStatus {
        act(
            &self.loaded.plugin,
            action,
            self.effect.handle(),
            Some(given),
            wanted,
            None,
        )
    }

    /// Calls DestroyInstance.
    ///
    /// # Errors
    /// If the plugin refuses.
    pub fn destroy(mut self) -> Result<(), String> {
        self.destroyed = true;
        let status = self.act(kOfxActionDestroyInstance);
        self.effect.end(self.loaded.host);
        if status == kOfxStatOK || status == kOfxStatReplyDefault {
            Ok(())
        } else {
            Err(format!("DestroyInstance gave {}", status_name(status)))
        }
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // A check that failed half-way still tidies up.
        if !self.destroyed {
            self.act(kOfxActionDestroyInstance);
            self.effect.end(self.loaded.host);
        }
    }
}

fn effect_values(
    loaded: &Loaded<'_>,
    context: &CStr,
    scene: &Scene,
) -> crate::host::properties::Values {
    let text = |value: &CStr| vec![Value::Text(value.to_owned())];
    let doubles = |list: &[f64]| list.iter().map(|v| Value::Double(*v)).collect::<Vec<_>>();
    let project = scene.project;
    let size = [project.x2 - project.x1, project.y2 - project.y1];
    let mut values = loaded.descriptor.properties.all();
    let rows = [
        (kOfxPropType, text(kOfxTypeImageEffectInstance)),
        (kOfxImageEffectPropContext, text(context)),
        (kOfxPropInstanceData, vec![Value::Pointer(0)]),
        (
            kOfxImageEffectPropPluginHandle,
            vec![Value::Pointer(loaded.descriptor.handle())],
        ),
        (kOfxImageEffectPropProjectSize, doubles(&size)),
        (
            kOfxImageEffectPropProjectOffset,
            doubles(&[project.x1, project.y1]),
        ),
        (
            kOfxImageEffectPropProjectExtent,
            doubles(&[project.x2, project.y2]),
        ),
        (
            kOfxImageEffectPropProjectPixelAspectRatio,
            doubles(&[scene.par]),
        ),
        (kOfxImageEffectInstancePropEffectDuration, doubles(&[100.0])),
        (
            kOfxImageEffectInstancePropSequentialRender,
            vec![Value::Int(0)],
        ),
        (kOfxImageEffectPropFrameRate, doubles(&[24.0])),
        (kOfxPropIsInteractive, vec![Value::Int(0)]),
    ];
    for (name, value) in rows {
        values.insert(name.to_string_lossy().into_owned(), value);
    }
    values
}

/// The picture with other channels: alpha is 1 where there was none, and all colours are one where there was one.
fn converted(picture: &Picture, channels: usize) -> Picture {
    if picture.channels == channels {
        return picture.clone();
    }
    Picture::made(picture.bounds, channels, |x, y, c| {
        let old = picture.pixel(x, y);
        let alpha = channels != 3 && c + 1 == channels;
        match (old.len(), alpha) {
            (1, _) => old[0],
            (3, true) => 1.0,
            (4, true) => old[3],
            (_, _) => old[c],
        }
    })
}
