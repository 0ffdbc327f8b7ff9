//! A plugin that has been loaded and has described itself.

use std::ffi::{CStr, CString};
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::arguments::Arguments;
use super::{Plugin, act, status_name};
use crate::host::effect::Effect;
use crate::host::properties::effect_descriptor;
use crate::host::{Entered, locked};

/// A plugin between Load and Unload.
pub struct Loaded<'h> {
    /// The host.
    pub host: &'h Entered,
    /// The plugin.
    pub plugin: Plugin,
    /// What it said of itself.
    pub descriptor: Arc<Effect>,
}

impl<'h> Loaded<'h> {
    /// Sets the host, loads and describes.
    ///
    /// # Errors
    /// If the plugin refuses.
    pub fn new(host: &'h Entered, plugin: &Plugin) -> Result<Self, String> {
        plugin.set_host(host);
        Self::again(host, plugin)
    }

    /// Loads and describes without setting the host again.
    ///
    /// # Errors
    /// If the plugin refuses.
    pub fn again(host: &'h Entered, plugin: &Plugin) -> Result<Self, String> {
        let status = act(plugin, kOfxActionLoad, 0, None, None, None);
        // Some hosts take anything else for a refusal.
        if status != kOfxStatOK {
            return Err(format!("Load gave {}", status_name(status)));
        }
        let loaded = Self {
            host,
            plugin: plugin.clone(),
            descriptor: new_descriptor(host),
        };
        let status = loaded.describe(&loaded.descriptor);
        if status != kOfxStatOK && status != kOfxStatReplyDefault {
            return Err(format!("Describe gave {}", status_name(status)));
        }
        Ok(loaded)
    }

    /// Calls Describe on a descriptor.
    pub fn describe(&self, descriptor: &Effect) -> OfxStatus {
        act(
            &self.plugin,
            kOfxActionDescribe,
            descriptor.handle(),
            None,
            None,
            None,
        )
    }

    /// Contexts it says it has.
    #[must_use]
    pub fn contexts(&self) -> Vec<CString> {
        (self.descriptor.properties)
            .texts(kOfxImageEffectPropSupportedContexts)
            .into_iter()
            .filter_map(|text| CString::new(text).ok())
            .collect()
    }

    /// Calls DescribeInContext on a new descriptor.
    ///
    /// # Errors
    /// If the plugin refuses.
    pub fn describe_in(&self, context: &CStr) -> Result<Arc<Effect>, String> {
        let descriptor = new_descriptor(self.host);
        for (name, values) in self.descriptor.properties.all() {
            let name = CString::new(name).unwrap_or_default();
            descriptor.properties.put(&name, values);
        }
        let given = Arguments::default()
            .text(kOfxImageEffectPropContext, context)
            .known(self.host, false, kOfxImageEffectActionDescribeInContext);
        let status = act(
            &self.plugin,
            kOfxImageEffectActionDescribeInContext,
            descriptor.handle(),
            Some(&given),
            None,
            None,
        );
        self.host.end(given.handle());
        if status == kOfxStatOK || status == kOfxStatReplyDefault {
            Ok(descriptor)
        } else {
            Err(format!(
                "DescribeInContext of {} gave {}",
                context.to_string_lossy(),
                status_name(status)
            ))
        }
    }

    /// The context that this host and the plugin have both, General first if `general`.
    ///
    /// # Errors
    /// If there is none.
    pub fn context(&self, general: bool) -> Result<CString, String> {
        let both: Vec<CString> = (self.contexts().into_iter())
            .filter(|c| self.host.profile.contexts.contains(&c.as_c_str()))
            .collect();
        let wanted = if general {
            kOfxImageEffectContextGeneral
        } else {
            kOfxImageEffectContextFilter
        };
        (both.iter().find(|c| c.as_c_str() == wanted))
            .or(both.first())
            .cloned()
            .ok_or_else(|| "has no context that the host has".to_owned())
    }

    /// Calls Unload.
    ///
    /// # Errors
    /// If the plugin refuses.
    pub fn unload(self) -> Result<(), String> {
        let status = act(&self.plugin, kOfxActionUnload, 0, None, None, None);
        if status == kOfxStatOK || status == kOfxStatReplyDefault {
            Ok(())
        } else {
            Err(format!("Unload gave {}", status_name(status)))
        }
    }
}

/// A descriptor that nobody has described.
pub(crate) fn new_descriptor(host: &Entered) -> Arc<Effect> {
    let path = locked(&host.path).clone();
    let values = effect_descriptor(&host.profile, &path);
    let set = host.property_set(
        "effect descriptor",
        "the descriptor",
        values,
        !host.profile.describes,
    );
    Effect::new(host, set, false)
}
