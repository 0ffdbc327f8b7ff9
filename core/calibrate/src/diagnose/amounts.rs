//! Fitted values of an effect in the user's units, in words.

mod defocus;
mod quantity;
#[cfg(test)]
mod tests;

use super::diagnosis::Value;
use defocus::{axial_colour, focus_offset, sensor_tilt};
use quantity::{Fitted, joined, quantity};
use seidel_optics::profile::LensProfile;

/// Returns the fitted `values` of the effect `id` of `lens` in words; empty where there are none, or where no
/// few words describe them.
pub(super) fn amount(id: &str, values: &[Value], lens: &LensProfile) -> String {
    let fitted = Fitted { values };
    let words = match id {
        "defocus_offset" => focus_offset(&fitted, lens),
        "depth_scale" => depth_scale(&fitted),
        "sensor_tilt" => sensor_tilt(&fitted, lens),
        "decentre" => decentre(&fitted),
        "axial_colour" => axial_colour(&fitted, lens),
        "lateral_colour" => lateral_colour(&fitted),
        "distortion" => distortion(&fitted, lens),
        "anamorphic" => anamorphic(&fitted),
        "aperture_polygon" => aperture_polygon(&fitted),
        "vignetting" => vignetting(&fitted),
        "apodisation" => apodisation(&fitted),
        "diffraction" => {
            (fitted.of("f_number")).map(|n| format!("as at f/{}", n.quantity(1.0, "")))
        }
        "pupil_scale" => pupil_scale(&fitted, lens),
        "motion" => motion(&fitted),
        "pixel_footprint" => pixel_footprint(&fitted, lens),
        "veiling_glare" => veiling_glare(&fitted),
        "tone_curve" => tone_curve(&fitted),
        _ => strongest(&fitted),
    };
    words.unwrap_or_default()
}

fn depth_scale(fitted: &Fitted) -> Option<String> {
    let factor = fitted.of("factor")?;
    let pivot = if fitted.number("pivot") > 0.5 {
        ", and so is the distance in focus"
    } else {
        ""
    };
    Some(format!(
        "true distances are {} times the stated ones{pivot}",
        factor.quantity(1.0, "")
    ))
}

fn decentre(fitted: &Fitted) -> Option<String> {
    let coma = fitted.vector("coma_x", "coma_y")?;
    let mut words = format!(
        "coma of {} in the middle, towards {}",
        coma.quantity(1.0, "px"),
        coma.direction(1.0)
    );
    if let Some(focus) = fitted.vector("focus_x", "focus_y") {
        words += &format!(
            "; defocus changes by {} from the middle to the side of the frame",
            focus.quantity(1.0, "px")
        );
    }
    Some(words)
}

fn lateral_colour(fitted: &Fitted) -> Option<String> {
    let channels: Vec<String> = fitted
        .by_channel("linear")
        .map(|(channel, linear)| {
            let cubic = fitted.by_channel("cubic").find(|(c, _)| *c == channel);
            let shift = linear.value + cubic.map_or(0.0, |(_, v)| v.value);
            format!("channel {channel} {}", outwards(shift))
        })
        .collect();
    let channels = joined(channels)?;
    Some(format!("at the side of the frame, {channels}"))
}

fn distortion(fitted: &Fitted, lens: &LensProfile) -> Option<String> {
    fitted.of("linear")?;
    let terms = ["linear", "cubic", "fifth"];
    let shift: f64 = terms.iter().map(|name| fitted.number(name)).sum();
    let share = 100.0 * shift.abs() / lens.frame.half_width_px();
    Some(format!(
        "points at the side of the frame land {} ({} of their distance from the axis)",
        outwards(shift),
        quantity(share, 0.0, "%")
    ))
}

fn outwards(shift: f64) -> String {
    let way = if shift < 0.0 { "inwards" } else { "outwards" };
    format!("{} {way}", quantity(shift.abs(), 0.0, "px"))
}

fn anamorphic(fitted: &Fitted) -> Option<String> {
    let squeeze = fitted.of("squeeze")?;
    let mut words = format!(
        "blur along x is {} times as wide as of a spherical lens",
        squeeze.quantity(1.0, "")
    );
    if let Some(astigmatism) = fitted.of("astigmatism") {
        words += &format!(
            "; defocus along x and along y differs by {}",
            astigmatism.quantity(2.0, "px")
        );
    }
    Some(words)
}

fn aperture_polygon(fitted: &Fitted) -> Option<String> {
    let rotation = fitted.of("rotation_deg")?;
    let shape = fitted.of("roundness").map_or(String::new(), |r| {
        format!(", {:.0} % as round as a circle", 100.0 * r.value)
    });
    let angle = quantity(rotation.value, rotation.sigma, "degrees");
    Some(format!(
        "{:.0} blades{shape}, one corner at {angle} from image x towards y",
        fitted.number("blades")
    ))
}

fn vignetting(fitted: &Fitted) -> Option<String> {
    fitted.of("radius_1")?;
    Some(format!(
        "{:.0} % of the pupil is clipped at the side of the frame, {:.0} % in the middle",
        100.0 * clipped(fitted, 1.0),
        100.0 * clipped(fitted, 0.0)
    ))
}

/// Returns the share of the pupil outside the clipping circles at field radius `field`.
fn clipped(fitted: &Fitted, field: f64) -> f64 {
    const STEPS: i32 = 100;
    let circles = [("radius_1", "shift_1"), ("radius_2", "shift_2")].map(|(radius, shift)| {
        let radius = fitted.of(radius).map_or(f64::INFINITY, |v| v.value);
        (radius, fitted.number(shift) * field)
    });
    let (mut inside, mut passes) = (0, 0);
    for (x, y) in (-STEPS..=STEPS).flat_map(|x| (-STEPS..=STEPS).map(move |y| (x, y))) {
        let (x, y) = (
            f64::from(x) / f64::from(STEPS),
            f64::from(y) / f64::from(STEPS),
        );
        if x.hypot(y) <= 1.0 {
            inside += 1;
            passes += i32::from(circles.iter().all(|(r, s)| (x - s).hypot(y) <= *r));
        }
    }
    1.0 - f64::from(passes) / f64::from(inside)
}

fn apodisation(fitted: &Fitted) -> Option<String> {
    fitted.of("square")?;
    let rim = (-(fitted.number("square") + fitted.number("fourth"))).exp();
    Some(format!(
        "the pupil transmits {:.0} % as much light at its rim as at its centre",
        100.0 * rim
    ))
}

fn pupil_scale(fitted: &Fitted, lens: &LensProfile) -> Option<String> {
    let scale = fitted.values.first()?;
    let stated = lens.camera.f_number.filter(|_| scale.value > 0.0);
    let number = stated.map_or(String::new(), |n| {
        let found = quantity(n / scale.value, n / scale.value.powi(2) * scale.sigma, "");
        format!(": f/{found} instead of f/{n}")
    });
    Some(format!(
        "the pupil is {} times as wide as stated{number}",
        scale.quantity(1.0, "")
    ))
}

fn motion(fitted: &Fitted) -> Option<String> {
    let streak = fitted.vector("x", "y")?;
    let angle = streak.y.atan2(streak.x).to_degrees().rem_euclid(180.0);
    Some(format!(
        "a streak of {}, {angle:.0} degrees from image x towards y",
        streak.quantity(1.0, "px")
    ))
}

fn pixel_footprint(fitted: &Fitted, lens: &LensProfile) -> Option<String> {
    let size = fitted.of("box")?;
    let micrometres = lens.pixel_pitch_um.map_or(String::new(), |pitch| {
        format!(" ({})", size.quantity(pitch, "µm"))
    });
    let mut words = format!(
        "a box of {}{micrometres} besides the pixel itself",
        size.quantity(1.0, "px")
    );
    if let (Some(x), Some(y)) = (fitted.of("copies_x"), fitted.of("copies_y")) {
        words += &format!(
            "; copies {} apart along x and {} along y",
            x.quantity(1.0, "px"),
            y.quantity(1.0, "px")
        );
    }
    Some(words)
}

fn veiling_glare(fitted: &Fitted) -> Option<String> {
    let channels: Vec<String> = fitted
        .by_channel("share")
        .map(|(channel, share)| {
            format!(
                "{} of the light of channel {channel}",
                share.quantity(100.0, "%")
            )
        })
        .collect();
    let channels = joined(channels)?;
    let radius = fitted.of("radius").map_or(String::new(), |radius| {
        format!(", in a halo of radius {}", radius.quantity(1.0, "px"))
    });
    Some(format!("{channels} scatters{radius}"))
}

fn tone_curve(fitted: &Fitted) -> Option<String> {
    let gamma = fitted.of("gamma")?;
    Some(format!(
        "values follow light to the power {}",
        gamma.quantity(1.0, "")
    ))
}

/// Names the value with the largest gradient among those of a unit of px, in its own unit.
fn strongest(fitted: &Fitted) -> Option<String> {
    let lengths = fitted.values.iter().filter(|v| v.unit.starts_with("px"));
    let largest = lengths.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))?;
    let value = quantity(largest.value, largest.sigma, largest.unit);
    Some(format!("largest term: {} = {value}", largest.name))
}
