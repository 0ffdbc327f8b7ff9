//! The dynamic symbol table.

use object::{Object, ObjectSymbol};

use super::{Check, Report};
use crate::drive::Library;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "exports",
    about: "the binary exports the entry points of OpenFX and nothing else",
    run,
};

const ALLOWED: [&str; 3] = ["OfxGetNumberOfPlugins", "OfxGetPlugin", "OfxSetHost"];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let path = crate::drive::binary_of(&subject.file);
    let bytes =
        std::fs::read(&path).map_err(|why| format!("{}: cannot be read: {why}", path.display()))?;
    if bytes.starts_with(b"\x7fELF") {
        let file = object::File::parse(&*bytes)
            .map_err(|why| format!("{}: is no ELF file: {why}", path.display()))?;
        let exported: Vec<String> = (file.dynamic_symbols())
            .filter(|symbol| symbol.is_definition() && symbol.is_global())
            .filter_map(|symbol| symbol.name().ok().map(str::to_owned))
            .collect();
        for name in &ALLOWED[..2] {
            report.expect(exported.iter().any(|e| e == name), || {
                format!("does not export {name}")
            });
        }
        let others: Vec<_> = (exported.iter())
            .filter(|name| !ALLOWED.contains(&name.as_str()))
            .collect();
        report.expect(others.is_empty(), || format!("exports {others:?} as well"));
    } else {
        report.skip("the symbol table is read of ELF files alone");
    }
    let library = Library::open(&subject.file)?;
    let count = library.count();
    report.expect(count >= 1, || format!("has {count} plugins"));
    for n in [-1, count, i32::MAX, i32::MIN] {
        report.expect(library.plugin(n).is_none(), || {
            format!("OfxGetPlugin({n}) of {count} is not NULL")
        });
    }
    for plugin in library.plugins() {
        report.expect(plugin.is_complete(), || {
            format!("{}: setHost or mainEntry is NULL", plugin.id)
        });
        report.expect(
            plugin.api == ("OfxImageEffectPluginAPI".to_owned(), 1),
            || format!("{}: is for the API {:?}", plugin.id, plugin.api),
        );
        let id = &plugin.id;
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '.';
        report.expect(id.contains('.') && id.chars().all(plain), || {
            format!("{id:?}: an identifier is a reversed domain name of letters, digits and dots")
        });
    }
    library.close()
}
