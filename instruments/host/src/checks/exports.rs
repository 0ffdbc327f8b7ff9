//! The exports of the binary.

use object::Object;

use super::{Check, Report};
use crate::drive::Library;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "exports",
    about: "the binary exports the OpenFX entry points and nothing else",
    run,
};

const REQUIRED: [&str; 2] = ["OfxGetNumberOfPlugins", "OfxGetPlugin"];

const OPTIONAL: [&str; 1] = ["OfxSetHost"];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let path = crate::drive::binary_path(&subject.file);
    let error = |problem: String| format!("{}: {problem}", path.display());
    let bytes = std::fs::read(&path).map_err(|e| error(format!("the file cannot be read: {e}")))?;
    if bytes.starts_with(b"\x7fELF") || bytes.starts_with(b"MZ") {
        let broken = |e| error(format!("the file is not a valid ELF or PE file: {e}"));
        let file = object::File::parse(&*bytes).map_err(broken)?;
        let exported: Vec<String> = (file.exports().map_err(broken)?.into_iter())
            .map(|export| String::from_utf8_lossy(export.name()).into_owned())
            .collect();
        for name in REQUIRED {
            report.expect(exported.iter().any(|e| e == name), || {
                format!("the binary does not export {name}")
            });
        }
        let others: Vec<_> = (exported.iter().map(String::as_str))
            .filter(|name| !REQUIRED.contains(name) && !OPTIONAL.contains(name))
            .collect();
        report.expect(others.is_empty(), || {
            format!("the binary also exports {others:?}")
        });
    } else {
        report.skip("the symbol table of files other than ELF and PE");
    }
    let library = Library::open(&subject.file)?;
    let count = library.count();
    report.expect(count >= 1, || format!("the binary has {count} plugins"));
    for n in [-1, count, i32::MAX, i32::MIN] {
        report.expect(library.plugin_address(n) == 0, || {
            format!("OfxGetPlugin({n}) is not NULL, although there are {count} plugins")
        });
    }
    let plugins = library.plugins();
    report.expect(plugins.len() as i64 == i64::from(count), || {
        format!("{} of {count} plugins have a usable address", plugins.len())
    });
    for plugin in plugins {
        report.expect(plugin.is_complete(), || {
            format!("{}: setHost or mainEntry is NULL", plugin.id)
        });
        report.expect(
            plugin.api == ("OfxImageEffectPluginAPI".to_owned(), 1),
            || format!("{}: the API is {:?}", plugin.id, plugin.api),
        );
        let id = &plugin.id;
        let is_valid = |c: char| c.is_ascii_alphanumeric() || c == '.';
        report.expect(id.contains('.') && id.chars().all(is_valid), || {
            format!(
                "the identifier {id:?} is not a reversed domain name of letters, digits and dots"
            )
        });
    }
    library.close()
}
