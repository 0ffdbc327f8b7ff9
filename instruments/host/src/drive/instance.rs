//! An instance with connected clips and set parameters.

use std::ffi::CStr;
use std::path::Path;
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::arguments::{Arguments, at_time};
use super::{ActionArguments, LoadedPlugin, act, act_with, check_status, status_name};
use crate::host::effect::{Clip, Effect, EffectRole, ParameterValue};
use crate::host::images::reclaim;
use crate::host::properties::{PropertySet, Schema, Value, Values, property_name};
use crate::host::{Host, locked};
use crate::picture::Picture;
use crate::scene::{Feed, Scene, components};

/// An instance of a loaded plugin. It is destroyed when dropped.
pub struct Instance<'l> {
    /// The plugin.
    pub loaded: &'l LoadedPlugin<'l>,
    /// The instance as the plugin sees it.
    pub effect: Arc<Effect>,
    destroyed: bool,
}

impl<'l> Instance<'l> {
    /// Describes the plugin in the context, creates an instance and updates its clip preferences.
    ///
    /// # Errors
    /// If an action fails.
    pub fn new(
        loaded: &'l LoadedPlugin<'l>,
        context: &CStr,
        scene: &Scene,
    ) -> Result<Self, String> {
        let descriptor = loaded.describe_in(context)?;
        let instance = Self::without_create(loaded, &descriptor, context, scene);
        check_status("CreateInstance", instance.act(kOfxActionCreateInstance))?;
        if loaded.host.profile.calls_optional_actions {
            instance.update_clip_preferences()?;
        }
        Ok(instance)
    }

    /// Creates an instance without calling CreateInstance.
    #[must_use]
    pub fn without_create(
        loaded: &'l LoadedPlugin<'l>,
        descriptor: &Effect,
        context: &CStr,
        scene: &Scene,
    ) -> Self {
        let host: &Host = loaded.host;
        let values = instance_properties(loaded, context, scene);
        let set = host.property_set("effect instance", "the instance", values, Schema::Fixed);
        let effect = Effect::new(host, set, EffectRole::Instance);
        for clip in descriptor.clips() {
            let title = format!("clip {}", clip.name);
            let set = host.property_set("clip", &title, clip.properties.all(), Schema::Fixed);
            effect.add_clip(host, &clip.name, set);
        }
        for parameter in descriptor.parameters.all() {
            let kind = format!("parameter {}", parameter.kind.to_string_lossy());
            let mut values = parameter.properties.all();
            for (name, value) in [(kOfxParamPropSecret, 0), (kOfxParamPropEnabled, 1)] {
                values
                    .entry(property_name(name))
                    .or_insert_with(|| vec![Value::Int(value)]);
            }
            let set = host.property_set(&kind, &kind, values, Schema::Fixed);
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

    /// Calls an action without arguments.
    pub fn act(&self, action: &CStr) -> OfxStatus {
        act(&self.loaded.plugin, action, self.effect.handle())
    }

    /// Calls an action with arguments.
    pub(super) fn act_with(
        &self,
        action: &CStr,
        in_args: &PropertySet,
        out_args: Option<&PropertySet>,
    ) -> OfxStatus {
        let arguments = ActionArguments {
            in_args: Some(in_args),
            out_args,
            render: None,
        };
        act_with(&self.loaded.plugin, action, self.effect.handle(), arguments)
    }

    /// Connects the clips to a scene. Pictures are converted to components that the clips support.
    ///
    /// Callers that do so after creation must also call [`Self::update_clip_preferences`].
    pub fn connect(&self, scene: &Scene) {
        let mut scene = scene.clone();
        for clip in self.effect.clips() {
            let channels = self.supported_channels(&clip, scene.channels(&clip.name));
            convert_input(&mut scene, &clip.name, channels);
        }
        self.set_scene(scene);
    }

    /// Sets the scene, with pictures as its samples hold them, and the properties of all clips.
    fn set_scene(&self, mut scene: Scene) {
        scene.samples = self.loaded.samples();
        if scene.samples.white().is_some() {
            for input in scene.inputs.values_mut() {
                if let Feed::Pictures(pictures) = &mut input.feed {
                    for picture in pictures {
                        *picture = Arc::new(scene.samples.picture(picture));
                    }
                }
            }
        }
        for clip in self.effect.clips() {
            self.set_clip_properties(&clip, &scene);
        }
        *locked(&self.effect.scene) = scene;
    }

    /// Returns the number of channels in which the host gives a clip's pictures: their `own` if the clip supports them.
    fn supported_channels(&self, clip: &Clip, own: usize) -> usize {
        let supported = clip
            .properties
            .texts(kOfxImageEffectPropSupportedComponents);
        let supports = |channels: usize| {
            let name = components(channels);
            let host = &self.loaded.host.profile;
            supported.iter().any(|s| s.as_bytes() == name.to_bytes())
                && host.components.contains(&name)
        };
        [own, 4, 3, 1]
            .into_iter()
            .find(|channels| supports(*channels))
            .unwrap_or(own)
    }

    /// Sets the properties of a clip that depend on its connection.
    fn set_clip_properties(&self, clip: &Clip, scene: &Scene) {
        let host = &self.loaded.host.profile;
        let is_output = clip.name == "Output";
        // Output has the format of Source.
        let format_clip = if is_output { "Source" } else { &clip.name };
        let input = scene.input(format_clip);
        let is_connected =
            is_output || !matches!(input.feed, Feed::Unconnected) || host.all_connected;
        let channels = match is_output {
            true => scene.output_channels(),
            false => scene.channels(&clip.name),
        };
        let (clip_components, depth) = if is_connected {
            (
                components(channels),
                host.false_bit_depth.unwrap_or(scene.samples.bit_depth()),
            )
        } else {
            (kOfxImageComponentNone, kOfxBitDepthNone)
        };
        let text = |value: &CStr| vec![Value::Text(value.to_owned())];
        let double = |value: f64| vec![Value::Double(value)];
        let range = vec![Value::Double(0.0), Value::Double(100.0)];
        let rows = [
            (kOfxPropType, text(kOfxTypeClip)),
            (kOfxPropName, vec![Value::text(&clip.name)]),
            (
                kOfxImageClipPropConnected,
                vec![Value::Int(i32::from(is_connected))],
            ),
            (kOfxImageEffectPropComponents, text(clip_components)),
            (kOfxImageClipPropUnmappedComponents, text(clip_components)),
            (kOfxImageEffectPropPixelDepth, text(depth)),
            (kOfxImageClipPropUnmappedPixelDepth, text(depth)),
            (
                kOfxImageEffectPropPreMultiplication,
                text(input.premultiplication(channels)),
            ),
            (kOfxImagePropPixelAspectRatio, double(scene.par)),
            (kOfxImageEffectPropFrameRate, double(24.0)),
            (kOfxImageEffectPropUnmappedFrameRate, double(24.0)),
            (kOfxImageEffectPropFrameRange, range.clone()),
            (kOfxImageEffectPropUnmappedFrameRange, range),
            (kOfxImageClipPropFieldOrder, text(kOfxImageFieldNone)),
            (kOfxImageClipPropContinuousSamples, vec![Value::Int(0)]),
        ];
        for (name, values) in rows {
            clip.properties.put(name, values);
        }
    }

    /// Sets a parameter without notifying the plugin, as when a project is loaded.
    ///
    /// # Errors
    /// If there is no such parameter of that type.
    pub fn set(&self, name: &str, value: &ParameterValue) -> Result<(), String> {
        let parameter = (self.effect.parameters.get(name))
            .ok_or_else(|| format!("there is no parameter {name}"))?;
        if parameter.set(value.clone()) {
            Ok(())
        } else {
            Err(format!("parameter {name} is not of the type of {value:?}"))
        }
    }

    /// Sets a parameter and notifies the plugin, as when a user edits it.
    ///
    /// # Errors
    /// If there is no such parameter of that type, or the plugin fails.
    pub fn edit(&self, name: &str, value: &ParameterValue) -> Result<(), String> {
        self.set(name, value)?;
        self.notify_changed(kOfxTypeParameter, name, kOfxChangeUserEdited)
    }

    /// Notifies the plugin that a parameter or clip has changed.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn notify_changed(&self, kind: &CStr, name: &str, reason: &CStr) -> Result<(), String> {
        self.notify(kind, name, reason)?;
        self.update_after_change()
    }

    fn update_after_change(&self) -> Result<(), String> {
        if self.loaded.host.profile.calls_optional_actions {
            self.update_clip_preferences()?;
        }
        Ok(())
    }

    fn notify(&self, kind: &CStr, name: &str, reason: &CStr) -> Result<(), String> {
        let host: &Host = self.loaded.host;
        let act = |arguments: Arguments, action: &CStr| {
            let in_args = arguments
                .text(kOfxPropChangeReason, reason)
                .in_args(host, action);
            let status = self.act_with(action, &in_args, None);
            host.invalidate(in_args.handle());
            status
        };
        let change = at_time(0.0, (1.0, 1.0))
            .text(kOfxPropType, kind)
            .with(kOfxPropName, vec![Value::text(name)]);
        let statuses = [
            act(Arguments::default(), kOfxActionBeginInstanceChanged),
            act(change, kOfxActionInstanceChanged),
            act(Arguments::default(), kOfxActionEndInstanceChanged),
        ];
        for clip in reclaim(host, None) {
            host.record_misuse(format!(
                "InstanceChanged did not release an image of {clip}"
            ));
        }
        for status in statuses {
            check_status(&format!("InstanceChanged of {name}"), status)?;
        }
        Ok(())
    }

    /// Calls GetClipPreferences and converts inputs to the components that it sets.
    ///
    /// # Errors
    /// If the plugin fails, or sets components that the clip does not support.
    pub fn update_clip_preferences(&self) -> Result<(), String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetClipPreferences;
        let mut scene = locked(&self.effect.scene).clone();
        if host.profile.widest_output {
            scene.output = self.widest_output(&scene);
            self.set_scene(scene.clone());
        }
        let out_args = self.default_clip_preferences(&scene).out_args(host, action);
        let defaults = out_args.all();
        let status = act_with(
            &self.loaded.plugin,
            action,
            self.effect.handle(),
            ActionArguments {
                out_args: Some(&out_args),
                ..ActionArguments::default()
            },
        );
        let preferences = out_args.all();
        host.invalidate(out_args.handle());
        if status == kOfxStatReplyDefault {
            return Ok(());
        }
        if status != kOfxStatOK {
            return Err(format!(
                "GetClipPreferences returned {}",
                status_name(status)
            ));
        }
        for clip in self.effect.clips() {
            let property = format!("OfxImageClipPropComponents_{}", clip.name);
            let chosen = preferences.get(&property);
            if chosen == defaults.get(&property) {
                continue;
            }
            let Some(Value::Text(chosen)) = chosen.and_then(|values| values.first()) else {
                continue;
            };
            let channels = [1, 3, 4]
                .into_iter()
                .find(|channels| components(*channels) == chosen.as_c_str());
            let Some(channels) = channels else {
                continue;
            };
            let supported = clip
                .properties
                .texts(kOfxImageEffectPropSupportedComponents);
            if !supported.iter().any(|s| s.as_bytes() == chosen.to_bytes()) {
                return Err(format!(
                    "GetClipPreferences sets {chosen:?} for {}, which does not support it",
                    clip.name
                ));
            }
            if clip.name == "Output" && host.profile.widest_output {
                scene.output = Some(channels);
            }
            convert_input(&mut scene, &clip.name, channels);
        }
        self.set_scene(scene);
        Ok(())
    }

    /// Returns the most channels of any input, as far as Output supports them.
    fn widest_output(&self, scene: &Scene) -> Option<usize> {
        let output = self.effect.clip("Output")?;
        let widest = scene.inputs.keys().map(|clip| scene.channels(clip)).max()?;
        Some(self.supported_channels(&output, widest))
    }

    /// Makes relative paths in parameters of files absolute, as a project that was saved and opened has them in such a host.
    pub fn save_and_open(&self) {
        if !self.loaded.host.profile.absolute_paths {
            return;
        }
        for parameter in self.effect.parameters.all() {
            let modes = parameter.properties.texts(kOfxParamPropStringMode);
            let is_file = modes
                .iter()
                .any(|mode| mode.as_bytes() == kOfxParamStringIsFilePath.to_bytes());
            if let ParameterValue::Text(text) = parameter.value()
                && is_file
                && !text.is_empty()
                && !Path::new(&text).is_absolute()
            {
                parameter.set(ParameterValue::Text(format!("/project/shots/{text}")));
            }
        }
    }

    /// Notifies the plugin that the user has connected a clip.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn notify_connected(&self, clip: &str) -> Result<(), String> {
        let scene = locked(&self.effect.scene).clone();
        if self.loaded.host.profile.late_components {
            let mut early = scene.clone();
            if let Some(input) = early.inputs.get_mut(clip) {
                input.feed = Feed::Fails;
            }
            self.set_scene(early);
            if let Some(clip) = self.effect.clip(clip) {
                let none = vec![Value::Text(kOfxImageComponentNone.to_owned())];
                (clip.properties).put(kOfxImageEffectPropComponents, none.clone());
                (clip.properties).put(kOfxImageClipPropUnmappedComponents, none);
            }
        }
        let notified = self.notify(kOfxTypeClip, clip, kOfxChangeUserEdited);
        self.set_scene(scene);
        notified?;
        self.update_after_change()
    }

    /// Returns the arguments of GetClipPreferences with the current format of each clip.
    fn default_clip_preferences(&self, scene: &Scene) -> Arguments {
        let mut arguments = Arguments::default()
            .doubles(kOfxImageEffectPropFrameRate, &[24.0])
            .text(kOfxImageClipPropFieldOrder, kOfxImageFieldNone)
            .ints(kOfxImageClipPropContinuousSamples, &[0])
            .ints(kOfxImageEffectFrameVarying, &[0]);
        for clip in self.effect.clips() {
            let name = &clip.name;
            let current = |property: &CStr| clip.properties.get(property).unwrap_or_default();
            let components = current(kOfxImageEffectPropComponents);
            let depth = current(kOfxImageEffectPropPixelDepth);
            let par = vec![Value::Double(scene.par)];
            arguments = arguments
                .for_clip("OfxImageClipPropComponents_", name, components)
                .for_clip("OfxImageClipPropDepth_", name, depth)
                .for_clip("OfxImageClipPropPAR_", name, par);
            if self.loaded.host.profile.api >= (1, 5) {
                let prefix = "OfxImageClipPropPreferredColourspaces_";
                arguments = arguments.for_clip(prefix, name, Vec::new());
            }
            if name == "Output" {
                let premultiplication = current(kOfxImageEffectPropPreMultiplication);
                arguments = arguments.with(kOfxImageEffectPropPreMultiplication, premultiplication);
            }
        }
        arguments
    }

    /// Returns the number of channels of Output.
    #[must_use]
    pub fn output_channels(&self) -> usize {
        locked(&self.effect.scene).output_channels()
    }

    /// Calls DestroyInstance.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn destroy(mut self) -> Result<(), String> {
        self.destroyed = true;
        let status = self.act(kOfxActionDestroyInstance);
        self.effect.invalidate(self.loaded.host);
        check_status("DestroyInstance", status)
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        if !self.destroyed {
            self.act(kOfxActionDestroyInstance);
            self.effect.invalidate(self.loaded.host);
        }
    }
}

fn instance_properties(loaded: &LoadedPlugin<'_>, context: &CStr, scene: &Scene) -> Values {
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
        values.insert(property_name(name), value);
    }
    values
}

/// Converts the pictures of a clip to a number of channels.
fn convert_input(scene: &mut Scene, clip: &str, channels: usize) {
    if let Some(input) = scene.inputs.get_mut(clip)
        && let Feed::Pictures(pictures) = &mut input.feed
    {
        for picture in pictures.iter_mut() {
            if picture.channels != channels {
                *picture = Arc::new(convert_channels(picture, channels));
            }
        }
    }
}

/// Converts a picture to a number of channels. A missing alpha is 1; a single channel becomes all colours and alpha.
fn convert_channels(picture: &Picture, channels: usize) -> Picture {
    Picture::from_fn(picture.bounds, channels, |x, y, c| {
        let old = picture.pixel(x, y);
        let is_alpha = channels != 3 && c + 1 == channels;
        match (old.len(), is_alpha) {
            (1, _) => old[0],
            (3, true) => 1.0,
            (4, true) => old[3],
            (_, _) => old[c],
        }
    })
}
