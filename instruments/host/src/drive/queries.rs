//! The actions by which hosts prepare a render: regions of definition and interest, frames needed, identity.

use std::collections::BTreeMap;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::arguments::{Arguments, at_time, to_region};
use super::{Instance, RenderRequest, check_status, status_name};
use crate::host::properties::Value;
use crate::host::{Host, locked};
use crate::picture::{Rect, Region};

impl Instance<'_> {
    /// Returns the region of definition of Output.
    ///
    /// # Errors
    /// If the action fails or returns no finite rectangle.
    pub fn region_of_definition(&self, time: f64, scale: (f64, f64)) -> Result<Region, String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetRegionOfDefinition;
        let default = locked(&self.effect.scene)
            .region("Source", time)
            .unwrap_or(Region::new(0.0, 0.0, 0.0, 0.0));
        if !host.profile.calls_optional_actions {
            return Ok(default);
        }
        let in_args = at_time(time, scale).in_args(host, action);
        let out_args = Arguments::default()
            .doubles(kOfxImageEffectPropRegionOfDefinition, &default.corners())
            .out_args(host, action);
        let status = self.act_with(action, &in_args, Some(&out_args));
        let replies = out_args.all();
        host.invalidate(in_args.handle());
        host.invalidate(out_args.handle());
        if status == kOfxStatReplyDefault {
            return Ok(default);
        }
        if status != kOfxStatOK {
            return Err(format!(
                "GetRegionOfDefinition returned {}",
                status_name(status)
            ));
        }
        to_region(replies.get("OfxImageEffectPropRegionOfDefinition"))
            .filter(|r| r.corners().iter().all(|v| v.is_finite()))
            .ok_or_else(|| "GetRegionOfDefinition set no finite rectangle".to_owned())
    }

    /// Returns the region of interest of each input for a window of Output, in pixels.
    ///
    /// # Errors
    /// If the action fails or sets an invalid rectangle.
    pub fn regions_of_interest(
        &self,
        time: f64,
        scale: (f64, f64),
        window: Rect,
    ) -> Result<BTreeMap<String, Rect>, String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetRegionsOfInterest;
        let par = locked(&self.effect.scene).par;
        let region = Region::from_pixels(&window, scale, par);
        let names: Vec<String> = (self.effect.clips().iter())
            .map(|clip| clip.name.clone())
            .filter(|name| name != "Output")
            .collect();
        let values = || region.corners().map(Value::Double).to_vec();
        let in_args = at_time(time, scale)
            .with(kOfxImageEffectPropRegionOfInterest, values())
            .in_args(host, action);
        let mut out_args = Arguments::default();
        for name in &names {
            out_args = out_args.for_clip("OfxImageClipPropRoI_", name, values());
        }
        let out_args = out_args.out_args(host, action);
        let status = self.act_with(action, &in_args, Some(&out_args));
        let replies = out_args.all();
        host.invalidate(in_args.handle());
        host.invalidate(out_args.handle());
        check_status("GetRegionsOfInterest", status)?;
        names
            .into_iter()
            .map(|name| {
                let found = to_region(replies.get(&format!("OfxImageClipPropRoI_{name}")))
                    .ok_or_else(|| format!("GetRegionsOfInterest set no rectangle for {name}"))?;
                if found.x1 > found.x2
                    || found.y1 > found.y2
                    || found.corners().iter().any(|v| v.is_nan())
                {
                    return Err(format!("GetRegionsOfInterest set {found:?} for {name}"));
                }
                Ok((name, found.pixels(scale, par)))
            })
            .collect()
    }

    /// Returns the clip and time that a render would copy, if the plugin reports that.
    ///
    /// # Errors
    /// If the action fails or names an unknown clip.
    pub fn identity(
        &self,
        time: f64,
        scale: (f64, f64),
        window: Rect,
    ) -> Result<Option<(String, f64)>, String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionIsIdentity;
        let in_args = at_time(time, scale)
            .text(kOfxImageEffectPropFieldToRender, kOfxImageFieldNone)
            .ints(kOfxImageEffectPropRenderWindow, &window.corners())
            .in_args(host, action);
        let out_args = Arguments::default()
            .text(kOfxPropName, c"")
            .doubles(kOfxPropTime, &[time])
            .out_args(host, action);
        let status = self.act_with(action, &in_args, Some(&out_args));
        let clip = out_args.texts(kOfxPropName).into_iter().next();
        let source_time = out_args.doubles(kOfxPropTime).first().copied();
        host.invalidate(in_args.handle());
        host.invalidate(out_args.handle());
        if status == kOfxStatReplyDefault {
            return Ok(None);
        }
        if status != kOfxStatOK {
            return Err(format!("IsIdentity returned {}", status_name(status)));
        }
        let clip = clip.unwrap_or_default();
        if self.effect.clip(&clip).is_none() {
            return Err(format!("IsIdentity names {clip:?}, which is not a clip"));
        }
        Ok(Some((clip, source_time.unwrap_or(time))))
    }

    /// Calls GetFramesNeeded. The reply is ignored, because every frame is available.
    pub(super) fn frames_needed(&self, request: &RenderRequest) -> Result<(), String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetFramesNeeded;
        let in_args = at_time(request.time, request.scale).in_args(host, action);
        let mut out_args = Arguments::default();
        for clip in self.effect.clips() {
            // Some hosts leave out unconnected clips: openfx-misc README-hosts.txt.
            let connected = clip.properties.int(kOfxImageClipPropConnected) == Some(1);
            if connected && clip.name != "Output" {
                let range = [request.time, request.time].map(Value::Double).to_vec();
                out_args = out_args.for_clip("OfxImageClipPropFrameRange_", &clip.name, range);
            }
        }
        let out_args = out_args.out_args(host, action);
        let status = self.act_with(action, &in_args, Some(&out_args));
        host.invalidate(in_args.handle());
        host.invalidate(out_args.handle());
        check_status("GetFramesNeeded", status)
    }
}
