//! What hosts ask of an instance before they render: where there are pixels, what is needed, whether it only copies.

use std::collections::BTreeMap;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::arguments::{Arguments, at, region};
use super::{Instance, status_name};
use crate::host::properties::Value;
use crate::host::{Host, locked};
use crate::picture::{Rect, Region};

impl Instance<'_> {
    /// Where Output has pixels.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn region_of_definition(&self, time: f64, scale: (f64, f64)) -> Result<Region, String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetRegionOfDefinition;
        let scene = locked(&self.effect.scene).clone();
        let first = scene
            .region("Source", time)
            .unwrap_or(Region::new(0.0, 0.0, 0.0, 0.0));
        if !host.profile.asks {
            return Ok(first);
        }
        let given = at(time, scale).known(host, false, action);
        let wanted = Arguments::default()
            .doubles(kOfxImageEffectPropRegionOfDefinition, &first.corners())
            .known(host, true, action);
        let status = self.asked(action, &given, Some(&wanted));
        let all = wanted.all();
        host.end(given.handle());
        host.end(wanted.handle());
        if status == kOfxStatReplyDefault {
            return Ok(first);
        }
        if status != kOfxStatOK {
            return Err(format!(
                "GetRegionOfDefinition gave {}",
                status_name(status)
            ));
        }
        region(all.get("OfxImageEffectPropRegionOfDefinition"))
            .filter(|r| r.corners().iter().all(|v| v.is_finite()))
            .ok_or_else(|| "GetRegionOfDefinition gave no rectangle".to_owned())
    }

    /// What of each clip is needed for a window of Output, in pixels.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn regions_of_interest(
        &self,
        time: f64,
        scale: (f64, f64),
        window: Rect,
    ) -> Result<BTreeMap<String, Rect>, String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionGetRegionsOfInterest;
        let scene = locked(&self.effect.scene).clone();
        let of_window = Region::of(&window, scale, scene.par);
        let names: Vec<String> = (self.effect.clips().iter())
            .map(|clip| clip.name.clone())
            .filter(|name| name != "Output")
            .collect();
        let values = || of_window.corners().map(Value::Double).to_vec();
        let given = at(time, scale)
            .with(kOfxImageEffectPropRegionOfInterest, values())
            .known(host, false, action);
        let mut wanted = Arguments::default();
        for name in &names {
            wanted = wanted.of_clip("OfxImageClipPropRoI_", name, values());
        }
        let wanted = wanted.known(host, true, action);
        let status = self.asked(action, &given, Some(&wanted));
        let all = wanted.all();
        host.end(given.handle());
        host.end(wanted.handle());
        if status != kOfxStatOK && status != kOfxStatReplyDefault {
            return Err(format!("GetRegionsOfInterest gave {}", status_name(status)));
        }
        names
            .into_iter()
            .map(|name| {
                let found = region(all.get(&format!("OfxImageClipPropRoI_{name}")))
                    .ok_or_else(|| format!("GetRegionsOfInterest gave no rectangle for {name}"))?;
                if found.x1 > found.x2
                    || found.y1 > found.y2
                    || found.corners().iter().any(|v| v.is_nan())
                {
                    return Err(format!("GetRegionsOfInterest gave {found:?} for {name}"));
                }
                Ok((name, found.pixels(scale, scene.par)))
            })
            .collect()
    }

    /// The clip and time that the render would only copy, if the plugin says so.
    ///
    /// # Errors
    /// If the plugin fails.
    pub fn identity(
        &self,
        time: f64,
        scale: (f64, f64),
        window: Rect,
    ) -> Result<Option<(String, f64)>, String> {
        let host: &Host = self.loaded.host;
        let action = kOfxImageEffectActionIsIdentity;
        let given = at(time, scale)
            .text(kOfxImageEffectPropFieldToRender, kOfxImageFieldNone)
            .ints(kOfxImageEffectPropRenderWindow, &window.corners())
            .known(host, false, action);
        let wanted = Arguments::default()
            .text(kOfxPropName, c"")
            .doubles(kOfxPropTime, &[time])
            .known(host, true, action);
        let status = self.asked(action, &given, Some(&wanted));
        let clip = wanted.texts(kOfxPropName).into_iter().next();
        let at = wanted.doubles(kOfxPropTime).first().copied();
        host.end(given.handle());
        host.end(wanted.handle());
        if status == kOfxStatReplyDefault {
            return Ok(None);
        }
        if status != kOfxStatOK {
            return Err(format!("IsIdentity gave {}", status_name(status)));
        }
        let clip = clip.unwrap_or_default();
        if self.effect.clip(&clip).is_none() {
            return Err(format!("IsIdentity names {clip:?}, which is no clip"));
        }
        Ok(Some((clip, at.unwrap_or(time))))
    }
}
