//! The OpenColorIO config. Cameras are transforms by formula, so that the config needs no table files.

use std::fmt::Write;

use seidel_colour::curves::{
    Adaptation, CameraLog, CurveTable, Gamut, Matrix, SpaceDefinition, TransferFunction,
};

/// The reference space of the config.
const REFERENCE: &str = "ACES2065-1";

const HEAD: &str = "# Made from curves.toml by `cargo xtask luts`; do not edit. README.md says where its numbers come from.
ocio_profile_version: 2.1

environment: {}
search_path: \"\"
strictparsing: true
luma: [0.2126, 0.7152, 0.0722]
name: seidel
description: Scene-linear ACEScg, the usual cameras by formula, and plain displays. Highlights clip; no view changes tones.

roles:
  aces_interchange: ACES2065-1
  color_picking: sRGB - Texture
  color_timing: ACEScct
  compositing_log: ACEScct
  data: Raw
  default: ACEScg
  matte_paint: sRGB - Texture
  rendering: ACEScg
  scene_linear: ACEScg
  texture_paint: sRGB - Texture

file_rules:
  - !<Rule> {name: LogC4, regex: \".*[lL]og[cC]4.*\", colorspace: ARRI LogC4}
  - !<Rule> {name: LogC3, regex: \".*[lL]og[cC]3?[^0-9a-zA-Z].*\", colorspace: ARRI LogC3 (EI800)}
  - !<Rule> {name: S-Log3 Cine, regex: \".*[sS]-?[lL]og3.*[cC]ine.*\", colorspace: S-Log3 S-Gamut3.Cine}
  - !<Rule> {name: S-Log3, regex: \".*[sS]-?[lL]og3.*\", colorspace: S-Log3 S-Gamut3}
  - !<Rule> {name: Log3G10, regex: \".*[lL]og3[gG]10.*\", colorspace: Log3G10 REDWideGamutRGB}
  - !<Rule> {name: Canon Log 3, regex: \".*[cC](anon)?-?[lL]og3.*\", colorspace: CanonLog3 CinemaGamut D55}
  - !<Rule> {name: V-Log, regex: \".*[vV]-?[lL]og[^a-zA-Z].*\", colorspace: V-Log V-Gamut}
  - !<Rule> {name: ACEScct, regex: \".*[aA][cC][eE][sS]cct.*\", colorspace: ACEScct}
  - !<Rule> {name: PNG, pattern: \"*\", extension: png, colorspace: sRGB - Texture}
  - !<Rule> {name: JPEG, regex: \".*[.][jJ][pP][eE]?[gG]\", colorspace: sRGB - Texture}
  - !<Rule> {name: Default, colorspace: default}
";

const RAW: &str = "
  - !<ColorSpace>
    name: Raw
    aliases: [Utility - Raw]
    family: Utility
    description: Numbers that are no colour, such as depth and mattes. Nothing converts them.
    isdata: true
    encoding: data
";

/// The text of the config.
pub(super) fn text(table: &CurveTable) -> Result<String, String> {
    let mut text = HEAD.to_owned();
    text.push_str(&displays(table));
    text.push_str("\ncolorspaces:");
    for space in &table.spaces {
        text.push('\n');
        text.push_str(&space_text(table, space)?);
    }
    text.push_str(RAW);
    Ok(text)
}

fn displays(table: &CurveTable) -> String {
    let mut text = "\ndisplays:\n".to_owned();
    let mut names = Vec::new();
    for space in &table.spaces {
        if let Some(display) = &space.display {
            // Writing to a String does not fail.
            let _ = writeln!(text, "  {display}:");
            let _ = writeln!(
                text,
                "    - !<View> {{name: Plain, colorspace: {}}}",
                space.name
            );
            let _ = writeln!(text, "    - !<View> {{name: Raw, colorspace: Raw}}");
            names.push(display.as_str());
        }
    }
    let _ = writeln!(text, "\nactive_displays: [{}]", names.join(", "));
    let _ = writeln!(text, "active_views: [Plain, Raw]");
    text
}

fn space_text(table: &CurveTable, space: &SpaceDefinition) -> Result<String, String> {
    let curve = table.curve(space).map_err(|e| e.to_string())?;
    let gamut = table.gamut(space).map_err(|e| e.to_string())?;
    let encoding = match (&space.encoding, curve) {
        (Some(encoding), _) => encoding,
        (None, Some(_)) => "log",
        (None, None) => "scene-linear",
    };
    let from = match curve {
        Some(curve) => format!("{}, {}", curve.document, curve.revision),
        None => format!("{}, {}", gamut.document, gamut.revision),
    };
    let mut text = format!(
        "  - !<ColorSpace>\n    name: {}\n    aliases: [{}]\n    family: {}\n    description: \"{from}\"\n    encoding: {encoding}\n",
        space.name,
        space.aliases.join(", "),
        space.family,
    );
    if let Some(style) = &space.builtin {
        let _ = writeln!(
            text,
            "    to_scene_reference: !<BuiltinTransform> {{style: {style}}}"
        );
        return Ok(text);
    }
    let mut steps = curve.map_or_else(Vec::new, |curve| steps(&curve.transfer));
    if space.name != REFERENCE {
        let reference = table.space(REFERENCE).map(|space| table.gamut(space));
        let reference = reference.ok_or_else(|| format!("curves.toml: lacks {REFERENCE}"))?;
        let reference = reference.map_err(|e| e.to_string())?;
        steps.push(matrix(&to_reference(gamut, reference)));
    }
    match steps.as_slice() {
        [] => {}
        [step] => {
            let _ = writeln!(text, "    to_scene_reference: {step}");
        }
        steps => {
            let _ = writeln!(text, "    to_scene_reference: !<GroupTransform>");
            let _ = writeln!(text, "      children:");
            for step in steps {
                let _ = writeln!(text, "        - {step}");
            }
        }
    }
    Ok(text)
}

fn to_reference(gamut: &Gamut, reference: &Gamut) -> Matrix {
    debug_assert!(gamut.adaptation != Adaptation::None || gamut.white == reference.white);
    gamut.matrix_to(reference)
}

fn matrix(m: &Matrix) -> String {
    let rows = m.iter().map(|[a, b, c]| format!("{a}, {b}, {c}, 0, "));
    format!(
        "!<MatrixTransform> {{matrix: [{}0, 0, 0, 1]}}",
        rows.collect::<String>()
    )
}

/// The transforms from codes to linear values.
fn steps(curve: &TransferFunction) -> Vec<String> {
    match curve {
        TransferFunction::CameraLog(log) => vec![camera_log(log, log.linear_slope)],
        TransferFunction::MirroredLog { half, centre } => {
            // OpenColorIO has no logarithm for both signs. The first transform inverts the half above black and maps
            // the codes below it by the straight line. After a change of sign, the same logarithm inverts those.
            let slope = half.segment_slope();
            let below = CameraLog {
                log_slope: half.log_slope / slope,
                log_offset: (half.log_offset - centre) / slope,
                ..*half
            };
            let negated = matrix(&[[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
            vec![
                camera_log(half, Some(slope)),
                negated.clone(),
                camera_log(&below, Some(1.0)),
                negated,
            ]
        }
        // The space names a built-in transform instead.
        TransferFunction::Acescc {} => Vec::new(),
        TransferFunction::PowerWithLine { gamma, offset } => vec![format!(
            "!<ExponentWithLinearTransform> {{gamma: {gamma}, offset: {offset}}}"
        )],
        TransferFunction::MirroredPower { gamma } => {
            vec![format!(
                "!<ExponentTransform> {{value: {gamma}, style: mirror}}"
            )]
        }
    }
}

fn camera_log(log: &CameraLog, linear_slope: Option<f64>) -> String {
    let slope = linear_slope.map_or_else(String::new, |slope| format!(", linear_slope: {slope}"));
    format!(
        "!<LogCameraTransform> {{base: {}, log_side_slope: {}, log_side_offset: {}, lin_side_slope: {}, lin_side_offset: {}, lin_side_break: {}{slope}, direction: inverse}}",
        log.base, log.log_slope, log.log_offset, log.lin_slope, log.lin_offset, log.r#break
    )
}
