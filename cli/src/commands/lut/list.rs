//! What a config has.

use seidel_colour::Config;

use crate::Console;

/// Lists spaces, roles, displays and views.
pub(super) fn run(config: &Config, console: &mut Console) {
    console.say(format!("{}, by {}", config.name(), config.engine_name()));
    console.say("\nSpaces:");
    for space in config.spaces() {
        let what = match (space.is_data, space.encoding.as_str()) {
            (true, _) => "data",
            (_, "") => "colour",
            (_, encoding) => encoding,
        };
        let aliases = match space.aliases.as_slice() {
            [] => String::new(),
            aliases => format!("  (also {})", aliases.join(", ")),
        };
        console.say(format!("  {:<34} {what:<13}{aliases}", space.name));
    }
    console.say("\nRoles:");
    for (role, space) in config.roles() {
        console.say(format!("  {role:<34} {space}"));
    }
    console.say("\nDisplays and views:");
    for display in config.displays() {
        for view in &display.views {
            console.say(format!("  {}/{view}", display.name));
        }
    }
}
