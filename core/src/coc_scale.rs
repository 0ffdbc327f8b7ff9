//! The scale of pictures of the circle of confusion: its diameter in false colour.

/// A colour of the scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CocStop {
    /// Diameter of the circle of confusion, px.
    pub diameter_px: f32,
    /// Name of the colour.
    pub name: &'static str,
    /// The colour by its sRGB codes.
    pub srgb: [u8; 3],
}

const fn stop(diameter_px: f32, name: &'static str, srgb: [u8; 3]) -> CocStop {
    CocStop {
        diameter_px,
        name,
        srgb,
    }
}

/// The colours of circles of confusion by diameter, interpolated between by the logarithm of the diameter.
pub const COC_SCALE: [CocStop; 9] = [
    stop(0.0, "black", [0, 0, 0]),
    stop(1.0, "blue", [40, 60, 220]),
    stop(2.0, "cyan", [0, 190, 220]),
    stop(4.0, "green", [40, 180, 70]),
    stop(8.0, "yellow", [245, 225, 60]),
    stop(16.0, "orange", [245, 140, 30]),
    stop(32.0, "red", [215, 30, 35]),
    stop(64.0, "magenta", [215, 60, 205]),
    stop(128.0, "white", [255, 255, 255]),
];

/// The scale in scene-linear light of the sRGB primaries.
#[derive(Debug, Clone, PartialEq)]
pub struct CocColours {
    linear: [[f32; 3]; COC_SCALE.len()],
}

impl Default for CocColours {
    fn default() -> Self {
        Self {
            linear: COC_SCALE.map(|stop| stop.srgb.map(linear)),
        }
    }
}

impl CocColours {
    /// Returns red, green and blue of a diameter, px; the last colour beyond the scale.
    pub fn of(&self, diameter_px: f32) -> [f32; 3] {
        let above = COC_SCALE.partition_point(|stop| stop.diameter_px <= diameter_px);
        let high = above.clamp(1, COC_SCALE.len() - 1);
        let [a, b] = [high - 1, high].map(|k| COC_SCALE[k].diameter_px);
        let (from, to) = (self.linear[high - 1], self.linear[high]);
        let share = if a == 0.0 {
            diameter_px / b
        } else {
            (diameter_px / a).log2() / (b / a).log2()
        };
        let share = share.clamp(0.0, 1.0);
        std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
    }
}

/// Returns the linear value of an sRGB code, IEC 61966-2-1.
fn linear(code: u8) -> f32 {
    let code = f32::from(code) / 255.0;
    if code <= 0.040_45 {
        code / 12.92
    } else {
        ((f64::from(code) + 0.055) / 1.055).powf(2.4) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_passes_through_its_colours() {
        let colours = CocColours::default();
        for stop in COC_SCALE {
            let own = stop.srgb.map(linear);
            assert_eq!(colours.of(stop.diameter_px), own, "{}", stop.name);
        }
        assert_eq!(colours.of(1e6), [1.0; 3]);
        let between = colours.of(8.0_f32.sqrt());
        let (a, b) = (colours.linear[2], colours.linear[3]);
        for k in 0..3 {
            assert!((between[k] - (a[k] + b[k]) / 2.0).abs() < 1e-5);
        }
    }
}
