//! Whether each number of a scene is within the range that its schema has for it.
//!
//! A rule for each key is made of the schema once. A check then serialises the scene by [`Walk`], which writes nothing and looks
//! at each number beside its rule: no copy of the scene is made, because a host's scene is checked with each frame.

use std::collections::HashMap;
use std::fmt::{self, Display, Write as _};
use std::sync::LazyLock;

use serde::ser::{self, Impossible, Serialize, Serializer};
use serde_json::Value;

use super::Scene;
use super::camera::Camera;
use super::schema::schema;

/// What holds for a value, or for the values in it.
#[derive(Default)]
struct Rule {
    least: Option<f64>,
    /// Whether `least` itself is refused.
    is_over: bool,
    most: Option<f64>,
    /// Whether `most` itself is refused.
    is_under: bool,
    may_be_infinite: bool,
    may_be_nan: bool,
    unit: String,
    /// What to do about a value outside.
    advice: String,
    keys: HashMap<String, Rule>,
    items: Option<Box<Rule>>,
}

static RULES: LazyLock<Rule> = LazyLock::new(|| {
    let schema = schema();
    let mut rule = Rule::default();
    rule.add(&schema, &schema);
    rule
});

/// Checks every number; an error names the first that is outside of its range, in the form that `super::lines` reads.
pub(super) fn check(scene: &Scene) -> Result<(), String> {
    scene.serialize(Walk(Some(&RULES))).map_err(|problem| problem.to_string())
}

/// Checks the ranges of a camera alone.
pub(super) fn check_camera(camera: &Camera) -> Result<(), String> {
    let rule = RULES.keys.get("camera");
    camera.serialize(Walk(rule)).map_err(|problem| problem.at(Step::Key("camera")).to_string())
}

impl Rule {
    /// Adds what a part of the schema says; of alternatives all that any says, as they are of different types.
    fn add(&mut self, part: &Value, whole: &Value) {
        let number = |key: &str| part.get(key).and_then(Value::as_f64);
        let text = |key: &str| part.get(key).and_then(Value::as_str).map(String::from);
        let over = number("exclusiveMinimum");
        self.is_over |= over.is_some();
        self.least = over.or(number("minimum")).or(self.least);
        let under = number("exclusiveMaximum");
        self.is_under |= under.is_some();
        self.most = under.or(number("maximum")).or(self.most);
        self.may_be_infinite |= part.get("x-infinite").is_some_and(|flag| *flag == true);
        self.may_be_nan |= part.get("x-nan").is_some_and(|flag| *flag == true);
        self.unit = text("x-unit").unwrap_or_else(|| std::mem::take(&mut self.unit));
        self.advice = text("x-advice").unwrap_or_else(|| std::mem::take(&mut self.advice));
        if let Some(place) = part.get("$ref").and_then(Value::as_str) {
            let named = whole.pointer(place.trim_start_matches('#'));
            named.into_iter().for_each(|named| self.add(named, whole));
        }
        for other in part.get("anyOf").and_then(Value::as_array).into_iter().flatten() {
            self.add(other, whole);
        }
        for (key, value) in part.get("properties").and_then(Value::as_object).into_iter().flatten()
        {
            self.keys.entry(key.clone()).or_default().add(value, whole);
        }
        if let Some(items) = part.get("items") {
            self.items.get_or_insert_default().add(items, whole);
        }
    }

    /// What is wrong with a number.
    fn problem(&self, value: f64) -> Option<String> {
        if self.may_be_nan && value.is_nan() {
            return None;
        }
        let finite = if self.may_be_infinite { "" } else { "finite and " };
        let is_within =
            self.least.is_none_or(|least| value > least || (!self.is_over && value == least))
                && self.most.is_none_or(|most| value < most || (!self.is_under && value == most));
        if is_within && !value.is_nan() && (value.is_finite() || self.may_be_infinite) {
            return None;
        }
        let mut words = match (self.least.map(Short), self.most.map(Short)) {
            (Some(least), Some(most)) if self.is_over && self.is_under => {
                format!("is not between {least} and {most}")
            }
            (Some(least), Some(most)) if self.is_over => {
                format!("is not over {least} and up to {most}")
            }
            (Some(least), Some(most)) => format!("is not within {least} to {most}"),
            (Some(least), None) if self.is_over => format!("is not {finite}over {least}"),
            (Some(least), None) => format!("is not {finite}at least {least}"),
            (None, Some(most)) => format!("is not {finite}up to {most}"),
            (None, None) => "is not finite".into(),
        };
        if self.least.or(self.most).is_some() && !self.unit.is_empty() {
            let _ = write!(words, " {}", self.unit);
        }
        if !self.advice.is_empty() {
            let _ = write!(words, "; {}", self.advice);
        }
        Some(words)
    }
}

/// A number without a row of zeros.
struct Short(f64);

impl Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        match size == 0.0 || (1e-3..1e10).contains(&size) || !size.is_finite() {
            true => write!(f, "{}", self.0),
            false => write!(f, "{:e}", self.0),
        }
    }
}

/// A value that is outside of its range, and where it is: from the inside out.
#[derive(Debug)]
struct Problem {
    words: String,
    steps: Vec<Step>,
}

#[derive(Debug)]
enum Step {
    Key(&'static str),
    Item(usize),
}

impl Problem {
    fn at(mut self, step: Step) -> Self {
        self.steps.push(step);
        self
    }
}

impl Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const ORDINALS: [&str; 4] = ["first", "second", "third", "fourth"];
        let mut steps = self.steps.iter().rev().peekable();
        while let Some(step) = steps.next() {
            let Step::Key(name) = step else { continue };
            let number = match steps.peek() {
                Some(Step::Item(number)) => Some(*number),
                _ => None,
            };
            let is_last = steps.clone().all(|step| matches!(step, Step::Item(_)));
            match (number, is_last) {
                (None, false) => write!(f, "{name}: ")?,
                (Some(number), false) => write!(f, "{name} {}: ", number + 1)?,
                (None, true) => f.write_str(name)?,
                (Some(number), true) => match ORDINALS.get(number) {
                    Some(ordinal) => write!(f, "the {ordinal} of {name}")?,
                    None => write!(f, "number {} of {name}", number + 1)?,
                },
            }
        }
        write!(f, " = {}", self.words)
    }
}

impl std::error::Error for Problem {}

impl ser::Error for Problem {
    fn custom<T: Display>(message: T) -> Self {
        Self { words: message.to_string(), steps: Vec::new() }
    }
}

/// A serialiser that writes nothing: it looks at numbers, beside the rule for what it is given.
#[derive(Clone, Copy)]
struct Walk<'a>(Option<&'a Rule>);

impl Walk<'_> {
    fn number(self, value: f64) -> Result<(), Problem> {
        match self.0.and_then(|rule| rule.problem(value)) {
            Some(words) => {
                Err(Problem { words: format!("{} {words}", Short(value)), steps: Vec::new() })
            }
            None => Ok(()),
        }
    }
}

/// The values in a list, or in a table.
struct Inner<'a> {
    rule: Option<&'a Rule>,
    number: usize,
}

impl Inner<'_> {
    fn item<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Problem> {
        let rule = self.rule.and_then(|rule| rule.items.as_deref());
        let number = self.number;
        self.number += 1;
        value.serialize(Walk(rule)).map_err(|problem| problem.at(Step::Item(number)))
    }
}

/// Serialises each of these types: by looking away, by its number, by the value within, item by item, or not at all.
macro_rules! methods {
    (
        nothing: $($nothing:ident($($past:ty),*)),*;
        number: $($number:ident($of:ty)),*;
        within: $($within:ident($($name:ty),*)),*;
        items: $($items:ident($($length:ty),*)),*;
        none: $($none:ident($($any:ty),*)),*
    ) => {
        $(fn $nothing(self, $(_: $past),*) -> Result<(), Problem> {
            Ok(())
        })*
        $(fn $number(self, value: $of) -> Result<(), Problem> {
            self.number(value as f64)
        })*
        $(fn $within<T: Serialize + ?Sized>(self, $(_: $name,)* value: &T) -> Result<(), Problem> {
            value.serialize(self)
        })*
        $(fn $items(self, $(_: $length),*) -> Result<Inner<'a>, Problem> {
            Ok(Inner { rule: self.0, number: 0 })
        })*
        $(fn $none(self, $(_: $any),*) -> Result<Impossible<(), Problem>, Problem> {
            Err(ser::Error::custom("no scene has maps, or variants with fields"))
        })*
    };
}

impl<'a> Serializer for Walk<'a> {
    type Ok = ();
    type Error = Problem;
    type SerializeSeq = Inner<'a>;
    type SerializeTuple = Inner<'a>;
    type SerializeTupleStruct = Inner<'a>;
    type SerializeTupleVariant = Impossible<(), Problem>;
    type SerializeMap = Impossible<(), Problem>;
    type SerializeStruct = Inner<'a>;
    type SerializeStructVariant = Impossible<(), Problem>;

    methods! {
        nothing: serialize_bool(bool), serialize_char(char), serialize_str(&str), serialize_bytes(&[u8]), serialize_none(),
            serialize_unit(), serialize_unit_struct(&str), serialize_unit_variant(&str, u32, &str);
        number: serialize_i8(i8), serialize_i16(i16), serialize_i32(i32), serialize_i64(i64), serialize_u8(u8),
            serialize_u16(u16), serialize_u32(u32), serialize_u64(u64), serialize_f64(f64);
        within: serialize_some(), serialize_newtype_struct(&str), serialize_newtype_variant(&str, u32, &str);
        items: serialize_seq(Option<usize>), serialize_tuple(usize), serialize_tuple_struct(&str, usize),
            serialize_struct(&str, usize);
        none: serialize_map(Option<usize>), serialize_tuple_variant(&str, u32, &str, usize),
            serialize_struct_variant(&str, u32, &str, usize)
    }

    /// The number is read from its text: 0.4 in 32 bits is another number in 64.
    fn serialize_f32(self, value: f32) -> Result<(), Problem> {
        self.number(value.to_string().parse().unwrap_or(value.into()))
    }
}

/// Serialises what a list holds, item by item.
macro_rules! items {
    ($($kind:ident::$method:ident),*) => {
        $(impl ser::$kind for Inner<'_> {
            type Ok = ();
            type Error = Problem;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Problem> {
                self.item(value)
            }

            fn end(self) -> Result<(), Problem> {
                Ok(())
            }
        })*
    };
}

items!(
    SerializeSeq::serialize_element,
    SerializeTuple::serialize_element,
    SerializeTupleStruct::serialize_field
);

impl ser::SerializeStruct for Inner<'_> {
    type Ok = ();
    type Error = Problem;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        key: &'static str,
        value: &T,
    ) -> Result<(), Problem> {
        let rule = self.rule.and_then(|rule| rule.keys.get(key));
        value.serialize(Walk(rule)).map_err(|problem| problem.at(Step::Key(key)))
    }

    fn end(self) -> Result<(), Problem> {
        Ok(())
    }
}
