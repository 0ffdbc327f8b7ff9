//! The test host passes the box blur as it should be, and finds every fault by the check that is meant to.
//!
//! A binary of its own, since checks run in processes of their own, which this one starts of itself.

use std::path::Path;
use std::process::ExitCode;

use seidel_ofx_host::checks::{self, ALL};
use seidel_ofx_host::command::{all, apart, built, if_child, subject};
use seidel_ofx_host::drive::Library;

/// Faults by the end of their plugin's identifier, the check that must find them, and what it must say.
const FAULTS: [(&str, &str, &str); 43] = [
    (
        "unreleasedImage",
        "images",
        "an image of Source was not released",
    ),
    (
        "doubleRelease",
        "images",
        "clipReleaseImage was given a handle of an image of Source that is no longer valid",
    ),
    (
        "writesOutside",
        "frame",
        "written outside what was to be rendered",
    ),
    ("leavesPixel", "frame", "1 pixels not written"),
    ("negativeRows", "rows", "rows Negative:"),
    ("smallRegion", "regions_of_interest", "pixels differ"),
    ("smallDefinition", "region_of_definition", "lies outside"),
    (
        "keepsString",
        "strings",
        "with strings overwritten at the next call",
    ),
    ("falseIdentity", "identity", "is said to be Source"),
    (
        "readsUntimed",
        "values",
        "paramGetValue of size was called in a render action",
    ),
    ("threadDependent", "thread_counts", "1 processors"),
    ("staleState", "reload", "loaded for time 1"),
    (
        "fatalProperty",
        "properties",
        "OfxPropAPIVersion cannot be read on host",
    ),
    ("formatMessage", "messages", "must go through \"%s\""),
    ("keepsMessage", "file", "the message stays"),
    ("ignoresScale", "render_scale", "at half scale"),
    ("wrongAspect", "pixel_aspect", "as many across"),
    (
        "lingeringThread",
        "threads",
        "threads are left after Unload 1",
    ),
    ("wrongReply", "arguments", "OfxActionOfAnotherTime"),
    ("nullData", "empty_clips", "crashes"),
    ("nullMember", "members", "crashes"),
    ("nullSuite", "suites", "crashes"),
    ("nullInstance", "order", "crashes"),
    ("leaksInstance", "leaks", "bytes behind"),
    ("ignoresAbort", "abort", "told to stop after 0"),
    (
        "mixesFields",
        "fields",
        "with other rows in the other field",
    ),
    ("seams", "tiles", "tiles of 16 x 16"),
    ("sharedScratch", "concurrent", " on several instances"),
    ("wrongChannel", "components", "depth of 3 channels"),
    ("staleParameter", "changes", "set and told"),
    ("wrongOrigin", "origin", "moved by"),
    ("accumulates", "determinism", "rendered twice"),
    ("refusesSmall", "tiny", "a picture of 1 x 1"),
    ("badDefault", "context", "has the default"),
    ("noLabel", "description", "has no label"),
    ("doesNothing", "blur", "a point is 0.000 pixels wide"),
    (
        "clearsAlways",
        "kinds",
        "resolve: clearPersistentMessage was called",
    ),
    (
        "clearsDestroyed",
        "messages",
        "clearPersistentMessage was called in DestroyInstance",
    ),
    (
        "needsRegion",
        "regions_of_interest",
        "without a region before the render, window",
    ),
    (
        "takesAnySamples",
        "samples",
        "renders pictures of OfxBitDepthByte",
    ),
    (
        "trustsRegion",
        "render_scale",
        "with regions in pixels of half scale",
    ),
    ("maskedOnly", "sizes", "pixels not written"),
    ("wideThreads", "variants", "with one thread"),
];

fn id(fault: &str) -> String {
    format!("org.seidel.box.{fault}")
}

/// Every variant is in the table, and everything in the table is a variant.
fn table(file: &Path) -> Result<(), String> {
    let library = Library::open(file)?;
    let mut found: Vec<String> = library
        .plugins()
        .into_iter()
        .map(|plugin| plugin.id)
        .collect();
    library.close()?;
    let mut known: Vec<String> = FAULTS.iter().map(|row| id(row.0)).collect();
    known.push(id("correct"));
    found.sort();
    known.sort();
    if found == known {
        Ok(())
    } else {
        Err(format!("the binary has {found:?}, the table {known:?}"))
    }
}

/// The variant without a fault passes every check, and all of them were done.
fn correct(file: &Path) -> Result<(), String> {
    let subject = subject(file.to_owned(), "box", Some(id("correct")))?;
    let outcomes = all(&subject, &[], |_| {});
    let failed: Vec<String> = (outcomes.iter())
        .filter(|o| !o.passed())
        .map(|o| o.lines())
        .collect();
    if outcomes.len() != ALL.len() {
        return Err(format!(
            "{} of {} checks were done",
            outcomes.len(),
            ALL.len()
        ));
    }
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("\n"))
    }
}

/// A fault is found by its check, in the words for it.
fn fault(file: &Path, row: &(&str, &str, &str)) -> Result<(), String> {
    let (fault, check, says) = row;
    let subject = subject(file.to_owned(), "box", Some(id(fault)))?;
    let check = checks::find(check).ok_or_else(|| format!("there is no check {check}"))?;
    let outcome = apart(check, &subject);
    if outcome.report.faults.iter().any(|text| text.contains(says)) {
        Ok(())
    } else {
        Err(format!(
            "{} does not say {says:?}: {:?}",
            check.name, outcome.report.faults
        ))
    }
}

/// A binary whose entry point is called otherwise, made of the right one by changing a letter of the name.
fn misnamed(file: &Path) -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        println!("misnamed: skipped, symbol tables are read of ELF files alone");
        return Ok(());
    }
    let mut bytes = std::fs::read(file).map_err(|why| why.to_string())?;
    let name = b"OfxGetPlugin\0";
    let places: Vec<usize> = (0..bytes.len() - name.len())
        .filter(|at| bytes[*at..].starts_with(name))
        .collect();
    for at in places {
        bytes[at + 10] = b'!';
    }
    let own = std::env::current_exe().map_err(|why| why.to_string())?;
    let copy = own.with_extension(format!("misnamed-{}.so", std::process::id()));
    std::fs::write(&copy, bytes).map_err(|why| why.to_string())?;
    let subject = subject(copy.clone(), "box", None)?;
    let check = checks::find("exports").ok_or("there is no check exports")?;
    let outcome = apart(check, &subject);
    let _ = std::fs::remove_file(&copy);
    let found = outcome.report.faults;
    let says = |text: &str| found.iter().any(|fault| fault.contains(text));
    if says("does not export OfxGetPlugin") && says("OfxGetPlug!n") {
        Ok(())
    } else {
        Err(format!("{found:?}"))
    }
}

fn main() -> ExitCode {
    if let Some(code) = if_child() {
        return code;
    }
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let file = match built("seidel_ofx_broken") {
        Ok(file) => file,
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
    };
    type Test<'a> = (&'a str, Box<dyn Fn() -> Result<(), String> + 'a>);
    let file = file.as_path();
    let mut tests: Vec<Test<'_>> = vec![
        ("table", Box::new(|| table(file))),
        ("correct", Box::new(|| correct(file))),
        ("misnamed", Box::new(|| misnamed(file))),
    ];
    tests.extend(
        FAULTS
            .iter()
            .map(|row| -> Test<'_> { (row.0, Box::new(|| fault(file, row))) }),
    );
    let mut failed = 0;
    let mut done = 0;
    for (name, test) in tests {
        if !wanted.is_empty() && !wanted.iter().any(|w| name.contains(w.as_str())) {
            continue;
        }
        done += 1;
        match test() {
            Ok(()) => println!("test {name} ... ok"),
            Err(why) => {
                failed += 1;
                println!("test {name} ... FAILED\n    {why}");
            }
        }
    }
    println!("\n{done} tests, {failed} failed");
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
