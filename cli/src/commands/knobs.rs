//! Options of the knobs in the core's table: names, helps, ranges and defaults follow from it.

use clap::builder::PossibleValue;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use seidel_core::{Choice, HostGroup, Knob, KnobKind, KnobScope, Number, Relation, Settings, Unit};

/// Options of the commands that draw a lens.
pub(crate) type LensKnobs = KnobArgs<{ KnobScope::Lens as usize }>;
/// Options of all commands on plates.
pub(crate) type PlateKnobs = KnobArgs<{ KnobScope::Plates as usize }>;
/// Options of the commands that give a plate new blur.
pub(crate) type NewBlurKnobs = KnobArgs<{ KnobScope::NewBlur as usize }>;
/// Options of `apply`.
pub(crate) type ApplyKnobs = KnobArgs<{ KnobScope::Apply as usize }>;
/// Options of `relens`.
pub(crate) type RelensKnobs = KnobArgs<{ KnobScope::Relens as usize }>;
/// Options of `remove`.
pub(crate) type RemoveKnobs = KnobArgs<{ KnobScope::Remove as usize }>;

/// The options of all knobs of a [`KnobScope`], with their values.
#[derive(Debug, Clone)]
pub(crate) struct KnobArgs<const SCOPE: usize> {
    /// In the order of the table.
    values: Vec<KnobOption>,
}

/// A knob with the value of its option.
#[derive(Debug, Clone)]
struct KnobOption {
    knob: &'static Knob,
    value: KnobValue,
    /// Whether it is on the command line.
    is_given: bool,
}

#[derive(Debug, Clone, Copy)]
enum KnobValue {
    Number(Option<f64>),
    /// The index of the option of a choice.
    Index(usize),
}

/// Returns the knobs of a scope that are options as the table states them. Switches and those of noise and clipping have
/// options of another form.
fn knobs_of(scope: usize) -> impl Iterator<Item = &'static Knob> {
    let has_option = |knob: &&Knob| !matches!(knob.kind, KnobKind::Switch(_));
    Knob::all()
        .filter(move |knob| knob.scope as usize == scope)
        .filter(has_option)
}

impl<const SCOPE: usize> Args for KnobArgs<SCOPE> {
    fn augment_args(command: Command) -> Command {
        command.args(knobs_of(SCOPE).map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const SCOPE: usize> FromArgMatches for KnobArgs<SCOPE> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let values = knobs_of(SCOPE).map(|knob| KnobOption {
            knob,
            value: value(knob, matches),
            is_given: matches.value_source(knob.name) == Some(ValueSource::CommandLine),
        });
        Ok(Self {
            values: values.collect(),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Other names of options.
const ALIASES: [(&str, &str); 1] = [("focus-distance", "focus-plane")];

/// Returns the option of a knob.
fn option(knob: &'static Knob) -> Arg {
    let help = knob.summary("if omitted");
    let long_help = [help.as_str(), knob.details].join("\n\n");
    let heading = match (knob.scope, knob.host.as_ref().map(|host| host.group)) {
        (KnobScope::Lens | KnobScope::Relens, _) | (_, Some(HostGroup::Focus)) => "Focus",
        (_, Some(HostGroup::Render)) => "Output",
        _ => "Look",
    };
    let arg = Arg::new(knob.name)
        .long(knob.name)
        .help_heading(heading)
        .long_help(long_help.trim_end().to_owned())
        .help(help);
    let aliases = ALIASES.iter().filter(|(name, _)| *name == knob.name);
    let arg = aliases.fold(arg, |arg, (_, alias)| arg.visible_alias(alias));
    let arg = match knob.relation {
        Relation::None => arg,
        Relation::Needs(other) => arg.requires(other),
        Relation::Replaces(other) => arg.conflicts_with(other),
    };
    match &knob.kind {
        KnobKind::Number(number) => number_option(arg, knob, number),
        KnobKind::Choice(choice) => choice_option(arg, choice),
        KnobKind::Switch(_) => arg,
    }
}

fn number_option(arg: Arg, knob: &'static Knob, number: &'static Number) -> Arg {
    let arg = arg
        .value_name(number.unit.placeholder())
        .allow_hyphen_values(true)
        .value_parser(|text: &str| parse(knob.name, text));
    match number.default {
        Some(default) => arg.default_value(default.to_string()),
        None => arg,
    }
}

/// Parses a number of the knob called `name`; gives a remedy for one out of range.
pub(super) fn parse(name: &str, text: &str) -> Result<f64, String> {
    let (knob, number) = Knob::named(name)
        .and_then(|knob| Some((knob, knob.number()?)))
        .ok_or("is no number")?;
    let value = number.unit.parse(text).ok_or_else(|| {
        let forms = match number.unit {
            Unit::FNumber => ", such as 2.8 or f/2.8",
            _ => "",
        };
        format!("give {}{forms}", number.range_words())
    })?;
    knob.check(value).map_err(|error| error.remedy)?;
    Ok(value)
}

fn choice_option(arg: Arg, choice: &'static Choice) -> Arg {
    let words = choice.options.iter();
    let words = words.map(|option| PossibleValue::new(option.word).help(option.help));
    arg.value_parser(words.collect::<Vec<_>>())
        .default_value(choice.options[choice.default].word)
}

fn value(knob: &Knob, matches: &ArgMatches) -> KnobValue {
    match &knob.kind {
        KnobKind::Choice(choice) => {
            let word = matches.get_one::<String>(knob.name);
            let index = word.and_then(|word| choice.index_of(word));
            KnobValue::Index(index.unwrap_or(choice.default))
        }
        KnobKind::Number(_) | KnobKind::Switch(_) => {
            KnobValue::Number(matches.get_one(knob.name).copied())
        }
    }
}

impl<const SCOPE: usize> KnobArgs<SCOPE> {
    /// Writes the values to `settings`.
    ///
    /// # Errors
    /// A number out of its range.
    pub(crate) fn put(&self, settings: &mut Settings) -> seidel_core::Result<()> {
        self.values
            .iter()
            .try_for_each(|option| match option.value {
                KnobValue::Number(None) => Ok(()),
                KnobValue::Number(Some(value)) => option.knob.put_number(value, settings),
                KnobValue::Index(index) => option.knob.put_index(index, settings),
            })
    }

    /// Returns whether the number of the knob called `name`, which has no default, is given.
    pub(crate) fn is_given(&self, name: &str) -> bool {
        let mut given = self.values.iter();
        given.any(|o| o.knob.name == name && matches!(o.value, KnobValue::Number(Some(_))))
    }

    /// Returns the knobs with these `values` of numbers, where the command line gives none.
    pub(crate) fn with_defaults(&self, values: impl Iterator<Item = (&'static Knob, f64)>) -> Self {
        let mut knobs = self.clone();
        for (knob, value) in values {
            let mut options = knobs.values.iter_mut();
            let option = options.find(|option| option.knob.name == knob.name);
            if let Some(option) = option.filter(|option| !option.is_given) {
                option.value = KnobValue::Number(Some(value));
            }
        }
        knobs
    }

    /// Returns the knobs that are numbers.
    pub(crate) fn numbers() -> impl Iterator<Item = &'static Knob> {
        knobs_of(SCOPE).filter(|knob| knob.number().is_some())
    }

    /// Replaces the number of a knob by `value`.
    ///
    /// # Errors
    /// A value out of its range.
    pub(crate) fn set_number(
        &mut self,
        knob: &'static Knob,
        value: f64,
    ) -> seidel_core::Result<()> {
        knob.check(value)?;
        let mut options = self.values.iter_mut();
        if let Some(option) = options.find(|option| option.knob.name == knob.name) {
            option.value = KnobValue::Number(Some(value));
        }
        Ok(())
    }
}

/// Returns the value of the knob called `name` in `settings`, in words.
pub(crate) fn knob_text(name: &str, settings: &Settings) -> String {
    Knob::named(name).map_or_else(String::new, |knob| knob.text(settings))
}
