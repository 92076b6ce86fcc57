//! The parameters of an experiment, read from the table of its scene file.
//!
//! A deserialiser of its own, small on purpose: serde compiles the reading of a type anew for every kind of deserialiser that it meets, and
//! that of TOML meets four. With a hundred experiments those were a fifth of all code of the suite. What it gives up is dates.

use serde::de::value::{MapAccessDeserializer, StringDeserializer};
use serde::de::{
    self, DeserializeSeed, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use std::fmt::{self, Display};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Why parameters were refused, and the bytes of the scene file at fault.
#[derive(Debug)]
pub(crate) struct Misfit {
    pub(crate) message: String,
    pub(crate) span: Option<Range<usize>>,
}

impl Misfit {
    /// The fault with this place, unless one further in is known.
    fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }
}

impl Display for Misfit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

impl std::error::Error for Misfit {}

impl de::Error for Misfit {
    fn custom<T: Display>(message: T) -> Self {
        Self { message: message.to_string(), span: None }
    }
}

/// A value with its place in the file.
pub(crate) struct Parameter {
    span: Range<usize>,
    value: Value,
}

enum Value {
    Truth(bool),
    Whole(i64),
    Real(f64),
    Text(String),
    List(Vec<Parameter>),
    Table(Vec<(Spanned<String>, Parameter)>),
}

/// The table `experiment.parameters` of a scene file; an empty one where the file has none.
///
/// # Errors
/// When the text is no TOML, or a number does not fit its 64 bits.
pub(crate) fn parameters(text: &str) -> Result<Parameter, Misfit> {
    let document = DeTable::parse(text)
        .map_err(|error| Misfit { message: error.message().to_owned(), span: error.span() })?;
    let found = document.get_ref().get("experiment").and_then(|choice| match choice.get_ref() {
        DeValue::Table(choice) => choice.get("parameters"),
        _ => None,
    });
    match found {
        Some(value) => Parameter::of(value),
        None => Ok(Parameter { span: 0..0, value: Value::Table(Vec::new()) }),
    }
}

impl Parameter {
    fn of(value: &Spanned<DeValue<'_>>) -> Result<Self, Misfit> {
        let span = value.span();
        let value = match value.get_ref() {
            DeValue::String(text) => Value::Text(text.clone().into_owned()),
            DeValue::Boolean(truth) => Value::Truth(*truth),
            DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix())
                .map(Value::Whole)
                .map_err(|_| Misfit::custom("this integer does not fit 64 bits").at(&span))?,
            DeValue::Float(digits) => Value::Real(
                real(digits.as_str())
                    .ok_or_else(|| Misfit::custom("this number does not fit 64 bits").at(&span))?,
            ),
            DeValue::Datetime(_) => return Err(Misfit::custom("no parameter is a date").at(&span)),
            DeValue::Array(list) => Value::List(list.iter().map(Self::of).collect::<Result<_, _>>()?),
            DeValue::Table(table) => Value::Table(
                table
                    .iter()
                    .map(|(key, value)| {
                        Ok((Spanned::new(key.span(), key.get_ref().clone().into_owned()), Self::of(value)?))
                    })
                    .collect::<Result<_, Misfit>>()?,
            ),
        };
        Ok(Self { span, value })
    }

    /// What `seed` makes of it. A value that its type refuses only after it was read, outside of its range for one, has its place too.
    fn read<'de, T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Misfit> {
        let span = self.span.clone();
        seed.deserialize(self).map_err(|error| error.at(&span))
    }

    fn unexpected(&self) -> Unexpected<'_> {
        match &self.value {
            Value::Truth(truth) => Unexpected::Bool(*truth),
            Value::Whole(number) => Unexpected::Signed(*number),
            Value::Real(number) => Unexpected::Float(*number),
            Value::Text(text) => Unexpected::Str(text),
            Value::List(_) => Unexpected::Seq,
            Value::Table(_) => Unexpected::Map,
        }
    }
}

/// The number that the digits of TOML stand for; `None` where it is too large.
fn real(digits: &str) -> Option<f64> {
    let number: f64 = digits.parse().ok()?;
    (number.is_finite() || digits.contains("inf") || digits.contains("nan")).then_some(number)
}

impl<'de> Deserializer<'de> for Parameter {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        let span = self.span;
        match self.value {
            Value::Truth(truth) => visitor.visit_bool(truth),
            Value::Whole(number) => visitor.visit_i64(number),
            Value::Real(number) => visitor.visit_f64(number),
            Value::Text(text) => visitor.visit_string(text),
            Value::List(list) => visitor.visit_seq(Entries(list.into_iter())),
            Value::Table(table) => visitor.visit_map(Fields::of(table)),
        }
        .map_err(|error| error.at(&span))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match self.value {
            Value::Table(table) => visitor.visit_map(Fields::of(table)),
            _ => Err(Misfit::invalid_type(self.unexpected(), &visitor)),
        }
        .map_err(|error| error.at(&self.span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match self.value {
            Value::Text(name) => visitor.visit_enum(StringDeserializer::new(name)),
            Value::Table(table) => visitor.visit_enum(MapAccessDeserializer::new(Fields::of(table))),
            _ => Err(Misfit::invalid_type(self.unexpected(), &visitor)),
        }
        .map_err(|error| error.at(&self.span))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple tuple_struct map
        identifier ignored_any
    }
}

struct Entries(std::vec::IntoIter<Parameter>);

impl<'de> SeqAccess<'de> for Entries {
    type Error = Misfit;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misfit> {
        self.0.next().map(|entry| entry.read(seed)).transpose()
    }
}

struct Fields {
    rest: std::vec::IntoIter<(Spanned<String>, Parameter)>,
    value: Option<Parameter>,
}

impl Fields {
    fn of(table: Vec<(Spanned<String>, Parameter)>) -> Self {
        Self { rest: table.into_iter(), value: None }
    }
}

impl<'de> MapAccess<'de> for Fields {
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Misfit> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some(value);
        let span = key.span();
        let name: StringDeserializer<Misfit> = key.into_inner().into_deserializer();
        seed.deserialize(name).map(Some).map_err(|error| error.at(&span))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misfit> {
        match self.value.take() {
            Some(value) => value.read(seed),
            None => Err(Misfit::custom("a value was asked for before its key")),
        }
    }
}
