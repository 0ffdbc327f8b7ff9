//! A plugin between Load and Unload.

use std::ffi::{CStr, CString};
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::arguments::Arguments;
use super::{ActionArguments, Plugin, act, act_with, check_status};
use crate::host::effect::{Effect, EffectRole};
use crate::host::properties::effect_descriptor;
use crate::host::sample_type::SampleType;
use crate::host::{ActiveHost, locked};
use crate::scene::Scene;

/// A plugin that has been loaded and described.
pub struct LoadedPlugin<'h> {
    /// The host.
    pub host: &'h ActiveHost,
    /// The plugin.
    pub plugin: Plugin,
    /// Its descriptor.
    pub descriptor: Arc<Effect>,
    /// The status that Load returned: OK or ReplyDefault.
    pub load_status: OfxStatus,
}

impl<'h> LoadedPlugin<'h> {
    /// Calls setHost, Load and Describe.
    ///
    /// # Errors
    /// If an action fails.
    pub fn load(host: &'h ActiveHost, plugin: &Plugin) -> Result<Self, String> {
        plugin.set_host(host);
        Self::load_again(host, plugin)
    }

    /// Calls Load and Describe.
    ///
    /// # Errors
    /// If an action fails.
    pub fn load_again(host: &'h ActiveHost, plugin: &Plugin) -> Result<Self, String> {
        let load_status = act(plugin, kOfxActionLoad, 0);
        check_status("Load", load_status)?;
        let loaded = Self {
            load_status,
            host,
            plugin: plugin.clone(),
            descriptor: new_descriptor(host),
        };
        check_status("Describe", loaded.describe(&loaded.descriptor))?;
        Ok(loaded)
    }

    /// Calls Describe on a descriptor.
    pub fn describe(&self, descriptor: &Effect) -> OfxStatus {
        act(&self.plugin, kOfxActionDescribe, descriptor.handle())
    }

    /// Returns the contexts that it supports.
    #[must_use]
    pub fn contexts(&self) -> Vec<CString> {
        (self.descriptor.properties)
            .texts(kOfxImageEffectPropSupportedContexts)
            .into_iter()
            .filter_map(|text| CString::new(text).ok())
            .collect()
    }

    /// Returns whether it says that it takes images of a bit depth.
    #[must_use]
    pub fn takes(&self, bit_depth: &CStr) -> bool {
        (self.depths().iter()).any(|depth| depth.as_bytes() == bit_depth.to_bytes())
    }

    /// Returns the sample type of the images that it gets: that of the host, or else the first that it takes, or else floats.
    #[must_use]
    pub fn samples(&self) -> SampleType {
        self.host.profile.samples.unwrap_or_else(|| {
            let mut all = SampleType::ALL.into_iter();
            all.find(|one| self.takes(one.bit_depth()))
                .unwrap_or_default()
        })
    }

    fn depths(&self) -> Vec<String> {
        (self.descriptor.properties).texts(kOfxImageEffectPropSupportedPixelDepths)
    }

    /// Returns whether it supports tiles.
    pub(crate) fn supports_tiles(&self) -> bool {
        let set = &self.descriptor.properties;
        set.int(kOfxImageEffectPropSupportsTiles) != Some(0)
    }

    /// Calls DescribeInContext on a new descriptor.
    ///
    /// # Errors
    /// If the action fails.
    pub fn describe_in(&self, context: &CStr) -> Result<Arc<Effect>, String> {
        let descriptor = new_descriptor(self.host);
        for (name, values) in self.descriptor.properties.all() {
            let name = CString::new(name).unwrap_or_default();
            descriptor.properties.put(&name, values);
        }
        let in_args = Arguments::default()
            .text(kOfxImageEffectPropContext, context)
            .in_args(self.host, kOfxImageEffectActionDescribeInContext);
        let status = act_with(
            &self.plugin,
            kOfxImageEffectActionDescribeInContext,
            descriptor.handle(),
            ActionArguments {
                in_args: Some(&in_args),
                ..ActionArguments::default()
            },
        );
        self.host.invalidate(in_args.handle());
        let call = format!("DescribeInContext of {}", context.to_string_lossy());
        check_status(&call, status)?;
        Ok(descriptor)
    }

    /// Returns the context for a scene: General if it connects several clips, else Filter; or another that the host
    /// and the plugin share.
    ///
    /// # Errors
    /// If they share none.
    pub fn context(&self, scene: &Scene) -> Result<CString, String> {
        self.context_like(if scene.inputs.len() > 1 {
            kOfxImageEffectContextGeneral
        } else {
            kOfxImageEffectContextFilter
        })
    }

    /// Returns the context `preferred`, or another that the host and the plugin share.
    ///
    /// # Errors
    /// If they share none.
    pub fn context_like(&self, preferred: &CStr) -> Result<CString, String> {
        let shared: Vec<CString> = (self.contexts().into_iter())
            .filter(|c| self.host.profile.contexts.contains(&c.as_c_str()))
            .collect();
        (shared.iter().find(|c| c.as_c_str() == preferred))
            .or(shared.first())
            .cloned()
            .ok_or_else(|| "the plugin supports no context of the host".to_owned())
    }

    /// Calls Unload.
    ///
    /// # Errors
    /// If the action fails.
    pub fn unload(self) -> Result<(), String> {
        check_status("Unload", act(&self.plugin, kOfxActionUnload, 0))
    }
}

/// Creates a descriptor that the plugin has not filled in.
pub(crate) fn new_descriptor(host: &ActiveHost) -> Arc<Effect> {
    let path = locked(&host.path).clone();
    let set = host.property_set(
        "effect descriptor",
        "the descriptor",
        effect_descriptor(&host.profile, &path),
        host.profile.descriptor_schema(),
    );
    Effect::new(host, set, EffectRole::Descriptor)
}
