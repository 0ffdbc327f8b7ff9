//! The content of a config.

use seidel_colour::Config;

use crate::Console;

/// Prints the spaces, roles, displays and views of `config`.
pub(super) fn run(config: &Config, console: &mut Console) {
    console.print(format!("{}, by {}", config.name(), config.engine_name()));
    console.print("\nSpaces:");
    for space in config.spaces() {
        let kind = match space.encoding.as_str() {
            _ if space.is_data => "data",
            "" => "colour",
            encoding => encoding,
        };
        let aliases = if space.aliases.is_empty() {
            String::new()
        } else {
            format!("  (also {})", space.aliases.join(", "))
        };
        console.print(format!("  {:<34} {kind:<13}{aliases}", space.name));
    }
    console.print("\nRoles:");
    for (role, space) in config.roles() {
        console.print(format!("  {role:<34} {space}"));
    }
    console.print("\nDisplays and views:");
    for display in config.displays() {
        for view in &display.views {
            console.print(format!("  {}/{view}", display.name));
        }
    }
}
