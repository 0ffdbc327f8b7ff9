//! The changes that a look makes to the channels of a profile.

use super::Look;
use crate::effects::{
    self, Anamorphic, AperturePolygon, AxialColour, DefocusOffset, Effect, LateralColour,
    Obstruction, SensorTilt, Vignetting,
};
use crate::error::{Error, Result};
use crate::lens::{PictureMask, VergenceSeries};
use crate::profile::controls::SensorShift;
use crate::profile::{ProfileEffect, PupilChannel};

/// Spherical aberration of the rim ray at the largest [`Look::spherical`], half frame widths: 7.7 px of a frame of 1920, as
/// of a strong bubble lens. The image in focus then has a radius of 1.3 px (root mean square).
const SPHERICAL_REACH: f64 = 0.008;
/// Defocus over spherical aberration with the least mean square of landing points over the pupil (Born and Wolf, section 5.3).
const BEST_FOCUS: f64 = -2.0 / 3.0;
/// Shift of the two circles of the largest [`Look::cats_eye`], pupil radii per half frame width.
const CATS_EYE_SHIFT: f64 = 0.6;

/// Index of `pupil` among the parameters of `anamorphic`.
const ANAMORPHIC_PUPIL: usize = 1;
/// Indices of the shifts among the parameters of `vignetting`.
const SHIFTS: [usize; 2] = [1, 3];
/// Index of `slant` among the parameters of `sensor_tilt`.
const SLANT: usize = 3;

/// A look and the frame whose pixels are the unit of its lens.
pub(super) struct Change<'a> {
    pub(super) look: &'a Look,
    /// Half the width of the frame, px.
    pub(super) half_width_px: f64,
    /// Shift of the tilted sensor half a frame width along the direction of the tilt.
    pub(super) rise: Option<SensorShift>,
}

impl Change<'_> {
    /// Returns the `channels` of a lens with the look.
    ///
    /// # Errors
    /// A positive cat's eye on a lens that has `vignetting` twice.
    pub(super) fn channels(&self, channels: &[PupilChannel]) -> Result<Vec<PupilChannel>> {
        let mut changed = channels.to_vec();
        let middle = &channels[middle_channel(channels)];
        let mean_alpha = mean_alpha(channels);
        for channel in &mut changed {
            self.colour(channel, &mean_alpha, middle);
            self.pupil(channel)?;
        }
        Ok(changed)
    }

    /// Scales the differences of focus between `channel` and the mean, so that the lens stays focused, and those of
    /// magnification between it and the channel of `middle` wavelength.
    fn colour(
        &self,
        channel: &mut PupilChannel,
        mean_alpha: &VergenceSeries,
        middle: &PupilChannel,
    ) {
        let scale = |own: &mut VergenceSeries, of: &VergenceSeries, factor: f64| {
            if factor != 1.0 {
                *own = of.towards(own, factor);
            }
        };
        let (axial, lateral) = (self.look.axial_colour, self.look.lateral_colour);
        scale(&mut channel.alpha, mean_alpha, axial);
        scale(&mut channel.magnification, &middle.magnification, lateral);
        scale(&mut channel.distortion, &middle.distortion, lateral);
        for (id, factor) in [(AxialColour.id(), axial), (LateralColour.id(), lateral)] {
            if factor != 1.0 {
                for carried in carried(channel, id) {
                    carried
                        .values
                        .iter_mut()
                        .for_each(|v| *v = v.scaled(factor));
                }
            }
        }
    }

    fn pupil(&self, channel: &mut PupilChannel) -> Result<()> {
        let look = self.look;
        if let Some(blades) = look.blades {
            let count = f64::from(blades.count);
            set(
                channel,
                &AperturePolygon,
                &[count, blades.rotation_deg, 1.0, blades.roundness],
            );
        }
        // Light of far points lands on the side opposite to that of its ray in the pupil if alpha rises with vergence.
        let sign = channel.orientation();
        if let Some(picture) = &look.picture {
            channel.picture = Some(PictureMask {
                picture: picture.clone(),
                scale: -sign,
            });
        }
        if look.squeeze != 1.0 {
            let carried = carried_or_added(channel, &Anamorphic);
            let width = &mut carried.values[ANAMORPHIC_PUPIL];
            *width = width.scaled(1.0 / look.squeeze);
        }
        if let Some(rise) = &self.rise {
            self.tilt(channel, rise.defocus(channel));
        }
        if look.obstruction > 0.0 {
            set(channel, &Obstruction, &[look.obstruction, 0.0]);
        }
        if look.cats_eye < 0.0 {
            for carried in carried(channel, Vignetting.id()) {
                for shift in SHIFTS {
                    carried.values[shift] = carried.values[shift].scaled(1.0 + look.cats_eye);
                }
            }
        } else if look.cats_eye > 0.0 {
            add_cats_eye(channel, look.cats_eye)?;
        }
        if look.spherical != 0.0 {
            // Far points have alpha of the sign opposite to that of its slope: there, opposite spherical aberration brightens
            // rims.
            let beta = sign * look.spherical * SPHERICAL_REACH * self.half_width_px;
            channel.beta.coefficients[0] += beta;
            let refocus = &mut carried_or_added(channel, &DefocusOffset).values[0];
            refocus.coefficients[0] += BEST_FOCUS * beta;
        }
        Ok(())
    }

    /// Adds a tilt with this defocus half a frame width along its direction.
    fn tilt(&self, channel: &mut PupilChannel, defocus: VergenceSeries) {
        let (y, x) = self.look.tilt_direction_deg.to_radians().sin_cos();
        let values = &mut carried_or_added(channel, &SensorTilt).values;
        if values[..2]
            .iter()
            .all(|tilt| *tilt == VergenceSeries::constant(0.0))
        {
            values[SLANT] = VergenceSeries::constant(1.0 / self.half_width_px);
        }
        for (own, share) in values.iter_mut().zip([x, y]) {
            // The sum is twice the mean.
            *own = own.towards(&defocus.scaled(share), 0.5).scaled(2.0);
        }
    }
}

/// Returns the mean defocus of the channels.
fn mean_alpha(channels: &[PupilChannel]) -> VergenceSeries {
    let mut mean = channels[0].alpha.clone();
    for (k, channel) in channels.iter().enumerate().skip(1) {
        mean = mean.towards(&channel.alpha, 1.0 / (k + 1) as f64);
    }
    mean
}

/// Returns the index of the channel of middle wavelength, or of the middle one where a wavelength is unknown.
fn middle_channel(channels: &[PupilChannel]) -> usize {
    let mut order: Vec<usize> = (0..channels.len()).collect();
    if channels.iter().all(|c| c.wavelength_px > 0.0) {
        order.sort_by(|a, b| {
            let [a, b] = [a, b].map(|k| channels[*k].wavelength_px);
            a.total_cmp(&b)
        });
    }
    order[order.len() / 2]
}

/// Adds the two circles of a cat's eye of this `strength`.
fn add_cats_eye(channel: &mut PupilChannel, strength: f64) -> Result<()> {
    let shift = CATS_EYE_SHIFT * strength;
    let circles = with_values(&Vignetting, &[1.0, shift, 1.0, -shift]);
    let has = |list: &[ProfileEffect]| list.iter().any(|c| c.effect.id() == Vignetting.id());
    if !has(&channel.added) {
        insert(&mut channel.added, circles);
    } else if !has(&channel.effects) {
        insert(&mut channel.effects, circles);
    } else {
        return Err(Error::new(
            "look: cat's eye",
            "cannot be added: the lens has `vignetting` among its effects and its added effects",
            "give -1 to 0, or take one of them out of the lens profile",
        ));
    }
    Ok(())
}

/// Returns the effects called `id` of the channel.
fn carried<'a>(
    channel: &'a mut PupilChannel,
    id: &'a str,
) -> impl Iterator<Item = &'a mut ProfileEffect> {
    let all = channel.effects.iter_mut().chain(&mut channel.added);
    all.filter(move |carried| carried.effect.id() == id)
}

/// Sets the values of `effect`, in place of those that the channel has.
fn set(channel: &mut PupilChannel, effect: &'static dyn Effect, values: &[f64]) {
    *carried_or_added(channel, effect) = with_values(effect, values);
}

/// Returns `effect` of the channel, the added one where there are two; adds a neutral one where there is none.
fn carried_or_added<'a>(
    channel: &'a mut PupilChannel,
    effect: &'static dyn Effect,
) -> &'a mut ProfileEffect {
    let place = |list: &[ProfileEffect]| list.iter().position(|c| c.effect.id() == effect.id());
    if let Some(index) = place(&channel.added) {
        return &mut channel.added[index];
    }
    if let Some(index) = place(&channel.effects) {
        return &mut channel.effects[index];
    }
    let index = insert(
        &mut channel.added,
        with_values(effect, &effects::neutral(effect)),
    );
    &mut channel.added[index]
}

/// Returns `effect` with the same `values` at all distances.
fn with_values(effect: &'static dyn Effect, values: &[f64]) -> ProfileEffect {
    ProfileEffect {
        effect,
        values: (values.iter().copied())
            .map(VergenceSeries::constant)
            .collect(),
    }
}

/// Inserts `new` into a list at the place where it acts, and returns its index.
fn insert(list: &mut Vec<ProfileEffect>, new: ProfileEffect) -> usize {
    let position = effects::acting_position(new.effect);
    let index = list.partition_point(|c| effects::acting_position(c.effect) <= position);
    list.insert(index, new);
    index
}
