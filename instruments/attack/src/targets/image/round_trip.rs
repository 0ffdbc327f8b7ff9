//! A plate that was read must be readable after it was written, with the same samples and metadata.

use std::path::Path;

use seidel_image_io::description::Description;
use seidel_image_io::plate::{PlateFile, PlateOptions};
use seidel_image_io::samples::SampleFormat;

use crate::case::Case;
use crate::finding::Kind;

/// Writes `plate` to `out`, reads it again and reports differences of which no warning was returned.
pub(crate) fn check_round_trip(
    case: &mut Case,
    plate: &PlateFile,
    out: &Path,
    options: &PlateOptions,
) {
    let warnings = match plate.write(out) {
        Ok(warnings) => warnings,
        Err(error) => {
            case.check_file_error(&error, out);
            return;
        }
    };
    let back = match PlateFile::open(out, options) {
        Ok(back) => back,
        Err(error) => {
            case.report(
                Kind::SilentChange,
                format!("written, not readable: {error}"),
            );
            return;
        }
    };
    let tolerance = match plate.sample_format_in(plate.format()) {
        // Pixels whose samples are all smaller are stored as black, as documented.
        SampleFormat::Rgbe => f32::MIN_POSITIVE,
        _ => 0.0,
    };
    let (before, after) = (plate.colour(), back.colour());
    if let Some(change) = difference(&before, &after, tolerance) {
        case.report(Kind::SilentChange, format!("colour {change} after writing"));
    }
    let alphas = [plate.alpha(), back.alpha()].map(|alpha| alpha.into_iter().collect::<Vec<_>>());
    if let Some(change) = difference(&alphas[0], &alphas[1], tolerance) {
        case.report(Kind::SilentChange, format!("alpha {change} after writing"));
    }
    let windows = [plate, &back].map(|p| (p.windows(), p.colour_names().to_vec()));
    if windows[0] != windows[1] {
        let text = format!("{:?} became {:?}", windows[0], windows[1]);
        case.report(Kind::SilentChange, text);
    }
    if warnings.is_empty()
        && let (Ok(before), Ok(after)) = (Description::read(plate.path()), Description::read(out))
    {
        compare_descriptions(case, &before, &after);
    }
}

/// Compares channels and attributes of every part; the storage may differ.
fn compare_descriptions(case: &mut Case, before: &Description, after: &Description) {
    if before.parts.len() != after.parts.len() {
        case.report(
            Kind::SilentChange,
            "the number of parts differs after writing",
        );
        return;
    }
    for (a, b) in before.parts.iter().zip(&after.parts) {
        if (&a.name, &a.size, &a.channels) != (&b.name, &b.size, &b.channels) {
            let text = format!(
                "part {:?} {:?} became {:?} {:?}",
                a.name, a.channels, b.name, b.channels
            );
            case.report(Kind::SilentChange, text);
        }
        // Only entries that the file had: writers may state more.
        for (name, value) in &a.attributes {
            let kept = b.attributes.iter().any(|(n, v)| (n, v) == (name, value));
            if !kept {
                let now = b.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v);
                let text = format!("attribute {name} `{value}` became {now:?} without a warning");
                case.report(Kind::SilentChange, text);
            }
        }
    }
}

/// Returns the first difference of two lists of planes; NaN equals NaN.
fn difference(a: &[Vec<f32>], b: &[Vec<f32>], tolerance: f32) -> Option<String> {
    let lengths = [a, b].map(|planes| planes.iter().map(Vec::len).collect::<Vec<_>>());
    if lengths[0] != lengths[1] {
        return Some(format!("{:?} samples became {:?}", lengths[0], lengths[1]));
    }
    let mut pairs = a.iter().flatten().zip(b.iter().flatten());
    let is_same =
        |a: f32, b: f32| a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= tolerance;
    let pair = pairs.find(|pair| !is_same(*pair.0, *pair.1))?;
    Some(format!("{:e} became {:e}", pair.0, pair.1))
}
