//! Reference values of the mathematics, computed to 50 digits: 12 lenses at 5 image points each.

use seidel_core::{CentralMoments, FieldPoint, LocalBlur};
use seidel_optics::field::Meridian;
use seidel_optics::lens::{
    ConjugateShift, Conjugates, DepthLaw, DepthPlane, FourthCoefficients, LocalPupil,
    MomentCoefficients, ReducedNumbers, SeidelAberrations, ThickLens, Wavefront,
};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::moments::pixels::pixel_power;
use seidel_optics::psf::{
    Mixture, MomentPsf, PaperParameters, SkewNormal, SkewNormalDensity, best_skew, meridional_skew,
};
use serde_json::Value;

/// Relative to the natural scale (mu20 + mu02)^(n/2) of a moment of order n.
const MOMENT_TOLERANCE: f64 = 1e-11;
/// Relative to the peak of the PSF.
const PSF_TOLERANCE: f64 = 1e-11;

fn golden() -> Value {
    serde_json::from_str(include_str!("../golden/golden.json")).expect("the golden file is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list: Vec<f64> = value
        .as_array()
        .expect("a list")
        .iter()
        .map(number)
        .collect();
    list.try_into().expect("the list's length")
}

fn distance(value: &Value) -> Option<f64> {
    value.as_f64()
}

struct Case {
    name: String,
    lens: ThickLens,
    aberrations: SeidelAberrations,
    conjugates: Conjugates,
    reduced: ReducedNumbers,
    json: Value,
}

fn cases() -> Vec<Case> {
    let golden = golden();
    golden["cases"]
        .as_array()
        .expect("cases")
        .iter()
        .map(|json| {
            let p = &json["params"];
            let lens = ThickLens {
                focal_length: number(&p["f"]),
                principal_separation: number(&p["t_lens"]),
                entrance_pupil: number(&p["z_enter"]),
                pupil_radius: number(&p["r"]),
            };
            let aberrations = SeidelAberrations {
                spherical: number(&p["b"]),
                astigmatism: number(&p["c"]),
                field_curvature: number(&p["d"]),
                distortion: number(&p["e"]),
                coma: number(&p["f_coma"]),
            };
            let conjugates = lens
                .conjugates(distance(&p["z_foc"]), distance(&p["z_obj"]))
                .expect("golden lenses are valid");
            Case {
                name: json["name"].as_str().expect("a name").to_owned(),
                reduced: aberrations.reduced(&conjugates, lens.pupil_radius),
                lens,
                aberrations,
                conjugates,
                json: json.clone(),
            }
        })
        .collect()
}

fn close(got: f64, want: f64, scale: f64, tolerance: f64, what: &str) {
    assert!(
        (got - want).abs() <= tolerance * scale.max(f64::MIN_POSITIVE),
        "{what}: {got:e}, not {want:e} (scale {scale:e})"
    );
}

#[test]
fn geometry_and_reduced_numbers() {
    for case in cases() {
        let g = &case.json["geometry"];
        let c = &case.conjugates;
        for (got, key) in [
            (c.magnification, "m"),
            (c.exit_pupil, "z_exit"),
            (c.z1, "z1"),
            (c.z2, "z2"),
            (c.vergence, "v"),
            (c.focus_vergence, "v_foc"),
        ] {
            let want = number(&g[key]);
            close(
                got,
                want,
                want.abs().max(1e-12),
                1e-12,
                &format!("{} {key}", case.name),
            );
        }
        let r = &case.json["reduced"];
        for (got, key) in [
            (case.reduced.alpha, "alpha"),
            (case.reduced.beta, "beta"),
            (case.reduced.gamma, "gamma"),
            (case.reduced.delta, "delta"),
            (case.reduced.phi, "phi"),
        ] {
            let want = number(&r[key]);
            close(
                got,
                want,
                want.abs().max(1e-14),
                1e-12,
                &format!("{} {key}", case.name),
            );
        }
    }
}

#[test]
fn moment_coefficients_in_every_frame() {
    for case in cases() {
        let s = case.reduced.coefficients();
        let z2_over_z1 = case.conjugates.z2 / case.conjugates.z1;
        let pitch = number(&case.json["params"]["pitch"]);
        let field = 0.4 * case.lens.focal_length;
        for (got, key, unit) in [
            (s, "s_x", 1.0),
            (s.rescaled(1.0, 1.0 / z2_over_z1), "s_p", 1.0),
            (s.rescaled(1.0 / pitch, 1.0 / pitch), "s_px", pitch),
        ] {
            let want: [f64; 10] = numbers(&case.json[key]);
            // Each is scaled by its contribution at the edge of the field.
            let weight = |k: usize| (field / unit).powi(seidel_optics::lens::BASIS_DEGREE[k]);
            for order in [2, 3] {
                let of_order = (0..10).filter(|&k| seidel_optics::lens::MOMENT_ORDER[k] == order);
                let scale = of_order
                    .clone()
                    .map(|k| (want[k] * weight(k)).abs())
                    .fold(0.0, f64::max);
                for k in of_order {
                    let what = format!("{} {key} S{}", case.name, k + 1);
                    close(
                        got.0[k] * weight(k),
                        want[k] * weight(k),
                        scale,
                        1e-11,
                        &what,
                    );
                }
            }
        }
        let fourth = case.reduced.fourth_coefficients();
        let json = &case.json["fourth"];
        let FourthCoefficients { w, q, p } = fourth;
        let pairs = w
            .iter()
            .zip(numbers::<5>(&json["w"]))
            .chain(q.iter().zip(numbers::<4>(&json["q"])))
            .chain(p.iter().zip(numbers::<3>(&json["p"])));
        for (got, want) in pairs {
            close(
                *got,
                want,
                want.abs().max(1e-60),
                1e-11,
                &format!("{} fourth", case.name),
            );
        }
    }
}

#[test]
fn moments_and_centroids_over_the_field() {
    for case in cases() {
        let s = case.reduced.coefficients();
        let fourth = case.reduced.fourth_coefficients();
        for point in case.json["points"].as_array().expect("points") {
            let [x, y] = numbers(&point["x"]);
            let at = FieldPoint::new(x, y);
            let want: [f64; 7] = numbers(&point["moments"]);
            let trace = want[0] + want[2];
            let got = s.moments(at).to_array();
            for k in 0..7 {
                let scale = trace.powf(if k < 3 { 1.0 } else { 1.5 });
                let what = format!("{} {}", case.name, CentralMoments::NAMES[k]);
                close(got[k], want[k], scale, MOMENT_TOLERANCE, &what);
            }
            let want4: [f64; 5] = numbers(&point["moments4"]);
            for (got, want) in fourth.moments(at).to_array().iter().zip(want4) {
                close(
                    *got,
                    want,
                    trace * trace,
                    MOMENT_TOLERANCE,
                    &format!("{} fourth", case.name),
                );
            }
            let centroid = case
                .aberrations
                .centroid(&case.conjugates, case.lens.pupil_radius, at);
            let want: [f64; 2] = numbers(&point["centroid"]);
            close(
                centroid.x,
                want[0],
                1.0 + x.hypot(y),
                1e-12,
                &format!("{} centroid", case.name),
            );
            close(
                centroid.y,
                want[1],
                1.0 + x.hypot(y),
                1e-12,
                &format!("{} centroid", case.name),
            );
        }
    }
}

/// Gauss-Legendre nodes and weights on [0, 1], by Newton's method on the Legendre polynomial.
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|k| {
            let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..100 {
                let (mut before, mut value) = (1.0, x);
                for j in 2..=n {
                    let j = j as f64;
                    (before, value) = (
                        value,
                        ((2.0 * j - 1.0) * x * value - (j - 1.0) * before) / j,
                    );
                }
                slope = n as f64 * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            ((1.0 + x) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[test]
fn rays_through_the_pupil_have_the_closed_form_moments() {
    let radii = gauss_legendre(10);
    let angles = 28;
    for case in cases() {
        for point in case.json["points"].as_array().expect("points") {
            let [x, y] = numbers(&point["x"]);
            let at = FieldPoint::new(x, y);
            let rays = LocalPupil::circular(Wavefront::third_order(&case.reduced, at), 0.0);
            let mut spots = Vec::new();
            for &(t, weight) in &radii {
                for k in 0..angles {
                    let (sin, cos) = (std::f64::consts::TAU * (f64::from(k) + 0.3)
                        / f64::from(angles))
                    .sin_cos();
                    let u = [t.sqrt() * cos, t.sqrt() * sin];
                    assert!(rays.passes(u));
                    spots.push((weight / f64::from(angles), rays.wavefront.slope(u)));
                }
            }
            let mean = |p: i32, q: i32, cx: f64, cy: f64| -> f64 {
                spots
                    .iter()
                    .map(|(w, s)| w * (s[0] - cx).powi(p) * (s[1] - cy).powi(q))
                    .sum()
            };
            let (cx, cy) = (mean(1, 0, 0.0, 0.0), mean(0, 1, 0.0, 0.0));
            let want: [f64; 7] = numbers(&point["raytrace_moments"]);
            let trace = want[0] + want[2];
            let orders = [(2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)];
            for (&(p, q), want) in orders.iter().zip(want) {
                let scale = trace.powf(f64::from(p + q) / 2.0);
                close(
                    mean(p, q, cx, cy),
                    want,
                    scale,
                    1e-11,
                    &format!("{} mu{p}{q} by rays", case.name),
                );
            }
            let want: [f64; 5] = numbers(&point["raytrace_moments4"]);
            for ((p, q), want) in [(4, 0), (3, 1), (2, 2), (1, 3), (0, 4)]
                .into_iter()
                .zip(want)
            {
                close(
                    mean(p, q, cx, cy),
                    want,
                    trace * trace,
                    1e-11,
                    &format!("{} mu{p}{q} by rays", case.name),
                );
            }
        }
    }
}

#[test]
fn skew_normal_parameters_and_densities() {
    let mut compared = 0;
    for case in cases() {
        // PSF models work in pixels: the reference lengths are divided by the pixel pitch.
        let pitch = number(&case.json["params"]["pitch"]);
        let s = case.reduced.coefficients().rescaled(1.0 / pitch, 1.0);
        for point in case.json["points"].as_array().expect("points") {
            if point["psf"].is_null() {
                continue;
            }
            compared += 1;
            let [x, y] = numbers(&point["x"]);
            let at = FieldPoint::new(x, y);
            let name = format!("{} at ({x}, {y})", case.name);
            let moments = s.moments(at);
            let meridian = at.meridian();
            let m = moments.meridional(meridian);
            let want = &point["meridional"];
            for (got, key, length) in [
                (m.mu20, "mu20", 2),
                (m.mu02, "mu02", 2),
                (m.mu30, "mu30", 3),
                (m.mu12, "mu12", 3),
            ] {
                let scale = (m.mu20 + m.mu02).powf(f64::from(length) / 2.0);
                close(
                    got,
                    number(&want[key]) / pitch.powi(length),
                    scale,
                    MOMENT_TOLERANCE,
                    &name,
                );
            }
            let (e, clipped) = meridional_skew(&m);
            assert_eq!(
                clipped,
                want["clipped"].as_bool().expect("a flag"),
                "{name}"
            );
            // Near zero the cube root amplifies the error of the skewness, so e is compared for larger values only.
            close(
                e.powi(3),
                number(&want["e"]).powi(3),
                1.0,
                1e-11,
                &format!("{name} e"),
            );

            let local = LocalBlur::from_moments(moments, meridian);
            let Mixture::One(density) = SkewNormal.mixture(&local) else {
                panic!("a meridional skew-normal is one density");
            };
            let skew = e * m.mu20.sqrt();
            let paper = PaperParameters::new(
                [moments.mu20, moments.mu11, moments.mu02],
                [skew * meridian.cos, skew * meridian.sin],
            );
            let want = &point["skew_normal"];
            for (got, key) in [
                (paper.kappa1 / pitch, "kappa1"),
                (paper.kappa2 / pitch, "kappa2"),
                (paper.omega, "omega"),
            ] {
                let want = number(&want[key]);
                close(
                    got,
                    want,
                    want.abs().max(1.0),
                    1e-11,
                    &format!("{name} {key}"),
                );
            }
            let samples = point["psf"].as_array().expect("samples");
            let peak = samples.iter().map(|v| number(&v["p"])).fold(0.0, f64::max);
            for sample in samples {
                let (i, j) = (number(&sample["i"]) / pitch, number(&sample["j"]) / pitch);
                let want = number(&sample["p"]);
                let per_area = pitch * pitch;
                close(
                    density.density(i, j) / per_area,
                    want,
                    peak,
                    PSF_TOLERANCE,
                    &format!("{name} psf"),
                );
                close(
                    paper.density(i, j) / per_area,
                    want,
                    peak,
                    PSF_TOLERANCE,
                    &format!("{name} Eq 36"),
                );
            }
        }
    }
    assert!(compared >= 50, "only {compared} points have a PSF");
}

#[test]
fn third_moment_fits() {
    let golden = golden();
    for row in golden["third_moment_fits"]["rows"]
        .as_array()
        .expect("rows")
    {
        let m = MeridionalMoments {
            mu20: number(&row["mu20"]),
            mu02: number(&row["mu02"]),
            mu30: number(&row["mu30"]),
            mu12: number(&row["mu12"]),
        };
        for (key, weights) in [("eq43", [1.0; 4]), ("invariant", [1.0, 3.0, 3.0, 1.0])] {
            let ([s1, s2], misfit) = best_skew(&m.in_image(Meridian::X), weights);
            let want = &row[key];
            close(misfit, number(&want["misfit"]), 1.0, 1e-9, key);
            close(s1, number(&want["s1"]), 1.0, 1e-6, key);
            close(s2.abs(), number(&want["abs_s2"]), 1.0, 1e-6, key);
        }
    }
}

#[test]
fn a_skew_normal_density_has_its_moments() {
    // By sums over a fine grid: unit sum, zero mean, covariance and PHI s s s.
    let covariance = [4.0, 0.9, 2.5];
    let s = [1.7, -0.6];
    let density = SkewNormalDensity::new(covariance, s);
    let step = 0.05;
    let mut sums = [[0.0; 4]; 4];
    for row in -400..400 {
        for column in -400..400 {
            let (x, y) = (f64::from(column) * step, f64::from(row) * step);
            let light = density.density(x, y) * step * step;
            for (p, line) in sums.iter_mut().enumerate() {
                for (q, sum) in line.iter_mut().enumerate() {
                    *sum += light * x.powi(p as i32) * y.powi(q as i32);
                }
            }
        }
    }
    let phi = seidel_optics::psf::PHI;
    for (p, q, want) in [
        (0, 0, 1.0),
        (1, 0, 0.0),
        (0, 1, 0.0),
        (2, 0, covariance[0]),
        (1, 1, covariance[1]),
        (0, 2, covariance[2]),
        (3, 0, phi * s[0].powi(3)),
        (2, 1, phi * s[0] * s[0] * s[1]),
        (1, 2, phi * s[0] * s[1] * s[1]),
        (0, 3, phi * s[1].powi(3)),
    ] {
        close(
            sums[p][q],
            want,
            1.0,
            1e-10,
            &format!("mean of x^{p} y^{q}"),
        );
    }
}

#[test]
fn depth_law_from_the_fewest_planes() {
    let golden = golden();
    let rows = golden["depth"]["rows"].as_array().expect("rows");
    let plane = |index: usize| {
        // The file has vergence in 1/mm, the law in 1/m.
        let v = number(&rows[index]["v"]) * 1e3;
        DepthPlane {
            vergence_per_m: v,
            s: MomentCoefficients(numbers(&rows[index]["s_x"])),
            s_sigma: [0.0; 10],
        }
    };
    let law = DepthLaw::fit(&[plane(0), plane(2), plane(5)], None).expect("three planes");
    for index in 0..rows.len() {
        let DepthPlane {
            vergence_per_m: v,
            s: want,
            ..
        } = plane(index);
        let got = law.at(v);
        for k in 0..10 {
            let scale = (0..rows.len())
                .map(|r| plane(r).s.0[k].abs())
                .fold(0.0, f64::max);
            close(
                got.0[k],
                want.0[k],
                scale,
                1e-11,
                &format!("S{} at v = {v}", k + 1),
            );
        }
    }
}

#[test]
fn aberrations_across_depth_follow_six_constants() {
    let golden = golden();
    let shift = &golden["conjugate_shift"];
    let h = &shift["hat_at_infinity"];
    let law = ConjugateShift {
        focal_length: number(&shift["f"]),
        magnification: number(&shift["m"]),
        vergence: 0.0,
        intrinsic: SeidelAberrations {
            spherical: number(&h["b"]),
            astigmatism: number(&h["c"]),
            field_curvature: number(&h["d"]),
            distortion: number(&h["e"]),
            coma: number(&h["f"]),
        },
        pupil_spherical: number(&shift["a"]),
    };
    for row in shift["rows"].as_array().expect("rows") {
        let v = number(&row["v"]);
        let got = law.at(v);
        let five = |a: &SeidelAberrations| {
            [
                a.spherical,
                a.astigmatism,
                a.field_curvature,
                a.distortion,
                a.coma,
            ]
        };
        for (got, key) in five(&got).into_iter().zip(["b", "c", "d", "e", "f_coma"]) {
            let want = number(&row[key]);
            close(got, want, want.abs(), 1e-11, &format!("{key} at v = {v}"));
        }
        // The lens described at this vergence equals the lens described at infinity.
        let here = ConjugateShift::new(
            law.focal_length,
            law.magnification,
            v,
            &got,
            law.pupil_spherical,
        );
        for (back, want) in five(&here.at(0.0)).into_iter().zip(five(&law.at(0.0))) {
            close(
                back,
                want,
                want.abs(),
                1e-10,
                &format!("from v = {v} to infinity"),
            );
        }
    }
}

#[test]
fn pixel_integrals() {
    for row in golden()["pixel"].as_array().expect("rows") {
        let p = row["p"].as_u64().expect("an order") as usize;
        let want = number(&row["h"]);
        close(
            pixel_power(p, number(&row["x"])),
            want,
            want.abs().max(1.0),
            1e-14,
            "h_p",
        );
    }
}
