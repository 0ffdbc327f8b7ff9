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

/// The colours of circles of confusion by diameter, interpolated between by the logarithm of the diameter: black, then the map *viridis*
/// (S. van der Walt and N. Smith, 2015), which grows brighter evenly for every kind of colour vision.
pub const COC_SCALE: [CocStop; 9] = [
    stop(0.0, "black", [0, 0, 0]),
    stop(1.0, "violet", [68, 1, 84]),
    stop(2.0, "indigo", [70, 50, 126]),
    stop(4.0, "blue", [54, 92, 141]),
    stop(8.0, "teal", [39, 127, 142]),
    stop(16.0, "sea green", [31, 161, 135]),
    stop(32.0, "green", [74, 193, 109]),
    stop(64.0, "lime", [160, 218, 57]),
    stop(128.0, "yellow", [253, 231, 37]),
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
        assert_eq!(colours.of(1e6), colours.linear[COC_SCALE.len() - 1]);
        let between = colours.of(8.0_f32.sqrt());
        let (a, b) = (colours.linear[2], colours.linear[3]);
        for k in 0..3 {
            assert!((between[k] - (a[k] + b[k]) / 2.0).abs() < 1e-5);
        }
    }
}
