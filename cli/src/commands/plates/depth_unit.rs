//! The option about the unit of a depth pass, which tells a given unit from the default.

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};

/// Identifier of the option.
const ID: &str = "depth_unit";

/// The unit of depth passes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DepthUnitArgs {
    /// Metres in a unit; negative where distances are.
    pub(super) metres: f64,
    is_given: bool,
}

impl DepthUnitArgs {
    /// Returns the metres in a unit of the scene, if the option says so.
    pub(super) fn given_metres(self) -> Option<f64> {
        self.is_given.then_some(self.metres.abs())
    }
}

impl Args for DepthUnitArgs {
    fn augment_args(command: Command) -> Command {
        let help = "Unit of the depth pass: m, cm, mm, km, in, ft, or metres per unit; negative if distances are negative";
        let option = Arg::new(ID)
            .long("depth-unit")
            .help_heading("Depth")
            .value_name("UNIT")
            .default_value("m")
            .value_parser(parse_unit)
            .allow_hyphen_values(true)
            .help(help)
            .long_help(format!(
                "{help}\n\nIt is also the unit of distances in the metadata of renderers, for --lens-metadata."
            ));
        command.arg(option)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for DepthUnitArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        Ok(Self {
            metres: matches.get_one(ID).copied().unwrap_or(1.0),
            is_given: matches.value_source(ID) == Some(ValueSource::CommandLine),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn parse_unit(text: &str) -> Result<f64, String> {
    match text {
        "m" => Ok(1.0),
        "cm" => Ok(0.01),
        "mm" => Ok(0.001),
        "km" => Ok(1000.0),
        "in" => Ok(0.0254),
        "ft" => Ok(0.3048),
        number => number
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v != 0.0)
            .ok_or_else(|| "give m, cm, mm, km, in, ft, or the metres in one unit".to_owned()),
    }
}
