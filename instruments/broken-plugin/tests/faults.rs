//! The test host passes the correct box blur, and finds each fault of the others with the check meant for it.
//!
//! The test has its own main function, because checks run in child processes of the same program.

use std::path::Path;
use std::process::ExitCode;

use seidel_ofx_host::checks::{self, ALL};
use seidel_ofx_host::drive::Library;
use seidel_ofx_host::runner::{
    Outcome, built_plugin, child_main, in_parallel, run_all, run_isolated,
};
use seidel_ofx_host::subject::Subject;

/// A fault, and how it must be found.
struct Expected {
    /// The end of the plugin's identifier.
    fault: &'static str,
    /// The check that finds it.
    check: &'static str,
    /// A part of the report.
    message: &'static str,
}

const fn expected(fault: &'static str, check: &'static str, message: &'static str) -> Expected {
    Expected {
        fault,
        check,
        message,
    }
}

const FAULTS: [Expected; 49] = [
    expected(
        "unreleasedImage",
        "image_release",
        "an image of Source was not released",
    ),
    expected(
        "doubleRelease",
        "image_release",
        "clipReleaseImage was given an invalidated handle of an image of Source",
    ),
    expected(
        "writesOutside",
        "written_pixels",
        "written outside the render window",
    ),
    expected("unwrittenPixel", "written_pixels", "1 pixels not written"),
    expected("ignoresNegativeRows", "row_layouts", "rows Negative:"),
    expected(
        "smallRegionOfInterest",
        "regions_of_interest",
        "pixels differ",
    ),
    expected(
        "smallRegionOfDefinition",
        "region_of_definition",
        "lies outside",
    ),
    expected(
        "keepsString",
        "string_lifetime",
        "with strings overwritten at the next call",
    ),
    expected(
        "falseIdentity",
        "identity",
        "is declared to be identical to Source",
    ),
    expected(
        "readsWithoutTime",
        "parameter_access",
        "paramGetValue of size was called in a render action",
    ),
    expected("threadDependent", "thread_counts", "1 processors"),
    expected("staleState", "reload", "load 2 of binary 1"),
    expected(
        "requiresApiVersion",
        "missing_properties",
        "OfxPropAPIVersion cannot be read on host",
    ),
    expected("messageAsFormat", "messages", "double each % of its text"),
    expected(
        "messageWithArgument",
        "messages",
        "no message has the name of the missing file",
    ),
    expected("unlistedGroup", "pages", "does not list the group blend"),
    expected("widestOutput", "components", "beside Depth of 4"),
    expected("keepsFrames", "frame_memory", "memory grows by"),
    expected(
        "keepsMessage",
        "missing_file",
        "the persistent message is not cleared",
    ),
    expected("ignoresScale", "render_scale", "at half scale"),
    expected(
        "wrongAspect",
        "pixel_aspect",
        "the width of a blur in wide pixels",
    ),
    expected(
        "leftoverThread",
        "leftover_threads",
        "threads remain after Unload 1",
    ),
    expected("wrongReply", "null_arguments", "OfxActionOfTheFuture"),
    expected("readsNullData", "empty_clips", "crashes"),
    expected("callsNullFunction", "null_functions", "crashes"),
    expected("usesMissingSuite", "missing_suites", "crashes"),
    expected("readsNullInstance", "action_order", "crashes"),
    expected("leaksInstance", "leaks", "every instance leaks"),
    expected(
        "ignoresAbort",
        "abort",
        "aborted after 0 polls, the render went on",
    ),
    expected(
        "mixesFields",
        "fields",
        "with other rows in the other field",
    ),
    expected("seams", "tiles", "tiles of 16 x 16"),
    expected("sharedState", "concurrency", " on several instances"),
    expected("wrongChannel", "components", "depth of 3 channels"),
    expected(
        "staleParameter",
        "parameter_changes",
        "set with notification",
    ),
    expected("wrongOrigin", "origin", "translated by"),
    expected("accumulates", "determinism", "rendered twice"),
    expected("rejectsNarrow", "tiny_images", "an image of 1 x 1"),
    expected("badDefault", "contexts", "has the default"),
    expected("noLabel", "description", "the plugin has no label"),
    expected(
        "doesNothing",
        "blur",
        "a blurred point has a standard deviation of (0.000",
    ),
    expected(
        "clearsMessageInResolve",
        "host_kinds",
        "resolve: clearPersistentMessage was called",
    ),
    expected(
        "clearsMessageInDestroy",
        "messages",
        "clearPersistentMessage was called in DestroyInstance",
    ),
    expected(
        "requiresRegion",
        "regions_of_interest",
        "no regions of clips before a render, window",
    ),
    expected(
        "ignoresBitDepth",
        "bit_depths",
        "renders images of unsupported OfxBitDepthByte",
    ),
    expected(
        "trustsRegion",
        "render_scale",
        "with regions in pixels of half scale",
    ),
    expected("writesMaskOnly", "input_sizes", "pixels not written"),
    expected("unwrittenAlpha", "written_pixels", "1 pixels not written"),
    expected(
        "coarseBytes",
        "bit_depths",
        "OfxBitDepthByte against OfxBitDepthFloat",
    ),
    expected("wideBlurThreadDependent", "variants", "with one thread"),
];

/// The plugins without a fault, of floats and of bytes, and the checks that they must pass; all if none is named.
const CORRECT: [(&str, &[&str]); 2] = [("correct", &[]), ("ofBytes", &OF_SAMPLES)];

/// The checks that depend most on the type of samples. The plugin of bytes passes all, in seven CPU seconds.
const OF_SAMPLES: [&str; 7] = [
    "bit_depths",
    "identity",
    "image_release",
    "pixel_aspect",
    "render_scale",
    "row_layouts",
    "written_pixels",
];

fn id(fault: &str) -> String {
    format!("org.seidel.box.{fault}")
}

/// Checks that the binary has exactly the plugins of the table.
fn table_is_complete(file: &Path) -> Result<(), String> {
    let library = Library::open(file)?;
    let mut found: Vec<String> = library
        .plugins()
        .into_iter()
        .map(|plugin| plugin.id)
        .collect();
    library.close()?;
    let mut known: Vec<String> = FAULTS.iter().map(|row| id(row.fault)).collect();
    known.extend(CORRECT.map(|(name, _)| id(name)));
    found.sort();
    known.sort();
    if found == known {
        Ok(())
    } else {
        Err(format!("the binary has {found:?}, the table {known:?}"))
    }
}

/// Checks that a correct plugin passes the checks whose names contain one of `parts`, or all if there are none.
fn correct_plugin_passes(file: &Path, name: &str, parts: &[&str]) -> Result<(), String> {
    let subject = Subject::new(file.to_owned(), "box", Some(id(name)))?;
    let filters: Vec<String> = parts.iter().map(|part| (*part).to_owned()).collect();
    let outcomes = run_all(&subject, &filters, |_| {});
    let expected = if parts.is_empty() {
        ALL.len()
    } else {
        parts.len()
    };
    if outcomes.len() != expected {
        return Err(format!("{} of {expected} checks ran", outcomes.len()));
    }
    let failed: Vec<String> = (outcomes.iter())
        .filter(|outcome| !outcome.passed())
        .map(Outcome::lines)
        .collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("\n"))
    }
}

/// Runs a check on a plugin and returns the faults.
fn faults(file: &Path, check: &str, id: Option<String>) -> Result<Vec<String>, String> {
    let subject = Subject::new(file.to_owned(), "box", id)?;
    let check = checks::find(check).ok_or_else(|| format!("there is no check {check}"))?;
    Ok(run_isolated(check, &subject).report.faults)
}

/// Checks that a fault is found.
fn fault_is_found(file: &Path, expected: &Expected) -> Result<(), String> {
    let found = faults(file, expected.check, Some(id(expected.fault)))?;
    if found.iter().any(|fault| fault.contains(expected.message)) {
        Ok(())
    } else {
        Err(format!(
            "{} does not report {:?}, but {found:?}",
            expected.check, expected.message
        ))
    }
}

/// Checks that a wrong export is found, in a copy of the binary with a letter of OfxGetPlugin changed.
fn wrong_export_is_found(file: &Path) -> Result<(), String> {
    if !cfg!(any(target_os = "linux", windows)) {
        println!("wrong_export: skipped, because the check reads symbols of ELF and PE files only");
        return Ok(());
    }
    let mut bytes = std::fs::read(file).map_err(|e| e.to_string())?;
    let name = b"OfxGetPlugin\0";
    let places: Vec<usize> = (0..bytes.len() - name.len())
        .filter(|place| bytes[*place..].starts_with(name))
        .collect();
    for place in places {
        bytes[place + 10] = b'!';
    }
    let test = std::env::current_exe().map_err(|e| e.to_string())?;
    let suffix = std::env::consts::DLL_SUFFIX;
    let copy = test.with_extension(format!("wrong-export-{}{suffix}", std::process::id()));
    std::fs::write(&copy, bytes).map_err(|e| e.to_string())?;
    let found = faults(&copy, "exports", None);
    let _ = std::fs::remove_file(&copy);
    let found = found?;
    let has = |text: &str| found.iter().any(|fault| fault.contains(text));
    if has("does not export OfxGetPlugin") && has("OfxGetPlug!n") {
        Ok(())
    } else {
        Err(format!("{found:?}"))
    }
}

type Test<'a> = (&'a str, Box<dyn Fn() -> Result<(), String> + Sync + 'a>);

fn main() -> ExitCode {
    if let Some(code) = child_main() {
        return code;
    }
    let filters: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let file = match built_plugin("seidel_ofx_broken") {
        Ok(file) => file,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let file = file.as_path();
    let mut tests: Vec<Test<'_>> = vec![
        ("table", Box::new(|| table_is_complete(file))),
        ("wrong_export", Box::new(|| wrong_export_is_found(file))),
    ];
    tests.extend(CORRECT.map(|(name, parts)| -> Test<'_> {
        (
            name,
            Box::new(move || correct_plugin_passes(file, name, parts)),
        )
    }));
    tests.extend(
        FAULTS
            .iter()
            .map(|row| -> Test<'_> { (row.fault, Box::new(|| fault_is_found(file, row))) }),
    );
    tests.retain(|(name, _)| filters.is_empty() || filters.iter().any(|f| name.contains(f)));
    let passed = in_parallel(&tests, |(name, test)| {
        let result = test();
        match &result {
            Ok(()) => println!("test {name} ... ok"),
            Err(error) => println!("test {name} ... FAILED\n    {error}"),
        }
        result.is_ok()
    });
    let failed = passed.iter().filter(|passed| !**passed).count();
    println!("\n{} tests, {failed} failed", tests.len());
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
