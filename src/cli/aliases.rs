//! Options that stand for keys of one table of the scene: `--fresnel schlick` is `--set model.fresnel=schlick`.
//!
//! They are those of the paper's ablations, one for each key of the schema. The help leaves them out.

use std::marker::PhantomData;
use std::sync::LazyLock;

use clap::{Arg, ArgMatches, Command};
use serde::{Serialize, de::DeserializeOwned};

use crate::scene::{ModelChoice, RainSettings, with_keys};
use crate::{Error, Result};

/// An option, and the key that it stands for.
pub struct Alias {
    long: String,
    key: String,
    /// Numbers with commas between them, of which the first may be under 0.
    is_list: bool,
}

/// A table of the scene whose keys are options.
pub trait Aliased: Serialize + DeserializeOwned {
    /// The options.
    fn options() -> &'static [Alias];
}

impl Aliased for ModelChoice {
    fn options() -> &'static [Alias] {
        // These have options of their own, which the help shows.
        static OPTIONS: LazyLock<Vec<Alias>> =
            LazyLock::new(|| options_of("ModelChoice", &["preset", "error", "budget_ms"]));
        &OPTIONS
    }
}

impl Aliased for RainSettings {
    fn options() -> &'static [Alias] {
        // A rate has an option of its own; the keys of rain in a box have none.
        static OPTIONS: LazyLock<Vec<Alias>> = LazyLock::new(|| {
            let not = ["rate", "seed", "count", "half_extent", "radius", "velocity"];
            options_of("RainTable", &not)
        });
        &OPTIONS
    }
}

fn options_of(table: &str, not: &[&str]) -> Vec<Alias> {
    let schema = crate::scene::schema();
    let keys = schema["$defs"][table]["properties"].as_object().into_iter().flatten();
    let keys = keys.filter(|(key, _)| !not.contains(&key.as_str()));
    keys.map(|(key, part)| {
        // `--shape` is the model's.
        let long = match (table, &**key) {
            ("RainTable", "shape") => "drop-shape".into(),
            _ => key.replace('_', "-"),
        };
        Alias { long, key: key.clone(), is_list: part["type"] == "array" }
    })
    .collect()
}

/// The options that were given, with their values as they were typed.
#[derive(Clone, Debug, PartialEq)]
pub struct Aliases<T> {
    given: Vec<(&'static str, &'static str, String)>,
    table: PhantomData<T>,
}

impl<T> Default for Aliases<T> {
    fn default() -> Self {
        Self { given: Vec::new(), table: PhantomData }
    }
}

impl<T: Aliased> Aliases<T> {
    /// The table with the keys set.
    ///
    /// # Errors
    /// [`Error::Scene`] with the option that no table can have.
    pub fn set_in(&self, mut table: T) -> Result<T> {
        for (long, key, text) in &self.given {
            let refuse = |problem| Error::Scene {
                place: "command line".into(),
                problem: format!("--{long} {text}: {problem}"),
            };
            table = with_keys(&table, &[(key, text)]).map_err(refuse)?;
        }
        Ok(table)
    }
}

impl<T: Aliased> clap::FromArgMatches for Aliases<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = T::options().iter().filter_map(|Alias { long, key, .. }| {
            Some((&**long, &**key, matches.get_one::<String>(long)?.clone()))
        });
        Ok(Self { given: given.collect(), table: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<T: Aliased> clap::Args for Aliases<T> {
    fn augment_args(command: Command) -> Command {
        let option = |Alias { long, key, is_list }: &'static Alias| {
            let option = Arg::new(&**long).long(&**long).value_name(&**key).hide(true);
            option.allow_negative_numbers(true).allow_hyphen_values(*is_list)
        };
        command.args(T::options().iter().map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}
