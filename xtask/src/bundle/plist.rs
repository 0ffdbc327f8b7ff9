//! `Info.plist` of the bundle, which macOS and some hosts read.

use super::{IDENTIFIER, NAME};

/// Returns the text of the file.
pub(super) fn text(version: &str) -> String {
    let executable = format!("{NAME}.ofx");
    let entries: String = [
        ("CFBundleDevelopmentRegion", "English"),
        ("CFBundleExecutable", &executable),
        ("CFBundleIdentifier", IDENTIFIER),
        ("CFBundleInfoDictionaryVersion", "6.0"),
        ("CFBundleName", NAME),
        ("CFBundlePackageType", "BNDL"),
        ("CFBundleShortVersionString", version),
        ("CFBundleVersion", version),
    ]
    .iter()
    .map(|(key, value)| format!("\t<key>{key}</key>\n\t<string>{value}</string>\n"))
    .collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <!DOCTYPE plist PUBLIC \"-//Apple//DTD PLIST 1.0//EN\" \"http://www.apple.com/DTDs/PropertyList-1.0.dtd\">\n\
         <plist version=\"1.0\">\n<dict>\n{entries}</dict>\n</plist>\n"
    )
}
