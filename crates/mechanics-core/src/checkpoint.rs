//! Checkpoints: everything that influences later results, as named arrays in one file.
//!
//! A [`Checkpoint`] is a set of named, typed arrays. A scheme puts in what it needs to go on (positions, velocities,
//! earlier steps, contact stiffness, random state, the step's index); after [`Checkpoint::write`] and
//! [`Checkpoint::read`] it takes the same bits out again, and [`Checkpoint::finish`] tells when something was left
//! over, which means that the file belongs to another scheme. A run that is resumed must go on as if it had never
//! stopped, so a hidden cache that changes results belongs here too.
//!
//! # The file
//! Little-endian, version 1. Every checksum is [`crc64`].
//!
//! | part | bytes | content |
//! |---|---|---|
//! | header | 8 | `MECHCKP\n` |
//! | | 4 | version, u32 |
//! | | 4 | number of sections, u32 |
//! | | 8 | length of the whole file, u64 |
//! | | 8 | checksum of the 24 bytes above |
//! | each section | 4 | [`Kind`] code, u32 |
//! | | 4 | length of the name, u32 |
//! | | 8 | number of elements, u64 |
//! | | 8 | checksum of the 16 bytes above |
//! | | | the name, UTF-8 |
//! | | | the elements |
//! | | 8 | checksum of the name and the elements |
//!
//! Sections stand in the order of their names' bytes, so that equal content gives equal files.
//!
//! A reader trusts nothing: any sequence of bytes gives a checkpoint or a [`CheckpointError`], never a panic, and
//! never an allocation larger than a small multiple of the input.

mod element;
mod error;
mod file;
mod format;

pub use crate::checksum::crc64;
pub use element::{Element, Kind};
pub use error::CheckpointError;

use std::collections::BTreeMap;

/// The version that [`Checkpoint::write`] writes and [`Checkpoint::read`] reads.
pub const FORMAT_VERSION: u32 = 1;

/// The longest name of a section, in bytes.
pub const LONGEST_NAME: usize = 255;

/// Named, typed arrays that survive a restart bit by bit.
///
/// ```
/// use mechanics_core::checkpoint::Checkpoint;
/// use mechanics_core::tensor::Vec3;
///
/// let mut checkpoint = Checkpoint::new();
/// checkpoint.put("position", &[Vec3::new(0.0, 0.0, 1.5)]);
/// checkpoint.put_one("step", 42u64);
/// let bytes = checkpoint.to_bytes();
///
/// let mut resumed = Checkpoint::from_bytes(&bytes)?;
/// assert_eq!(resumed.take_one::<u64>("step")?, 42);
/// assert_eq!(resumed.take::<Vec3>("position")?[0].z, 1.5);
/// resumed.finish()?;
/// # Ok::<(), mechanics_core::checkpoint::CheckpointError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Checkpoint {
    sections: BTreeMap<String, Section>,
}

/// One array, already in the file's byte order.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Section {
    kind: Kind,
    count: usize,
    bytes: Vec<u8>,
}

impl Checkpoint {
    /// A checkpoint without sections.
    pub fn new() -> Self {
        Self::default()
    }

    /// The names of the sections and what they hold, in the order of the names' bytes.
    pub fn sections(&self) -> impl Iterator<Item = (&str, Kind, usize)> {
        self.sections.iter().map(|(name, section)| (name.as_str(), section.kind, section.count))
    }

    /// How many elements the array called `name` has.
    ///
    /// # Errors
    /// [`CheckpointError::Missing`] or [`CheckpointError::WrongKind`].
    pub fn length<T: Element>(&self, name: &str) -> Result<usize, CheckpointError> {
        Ok(self.section(name, T::KIND)?.count)
    }

    /// Confirms that the array called `name` has `wanted` elements. Whoever restores from several sections checks
    /// all of them first, so that an error finds nothing half restored.
    ///
    /// # Errors
    /// [`CheckpointError::Missing`], [`CheckpointError::WrongKind`] or [`CheckpointError::WrongLength`].
    pub fn require_length<T: Element>(&self, name: &str, wanted: usize) -> Result<(), CheckpointError> {
        let stored = self.length::<T>(name)?;
        if stored == wanted {
            Ok(())
        } else {
            Err(CheckpointError::WrongLength { name: name.to_owned(), stored, wanted })
        }
    }

    /// Adds the array `values` under `name`.
    ///
    /// A part of a larger scheme prefixes its names with its own and a slash, as in `contact/stiffness`.
    ///
    /// # Panics
    /// If `name` is empty, longer than [`LONGEST_NAME`], or taken: two writers that share a name are a mistake in
    /// the program, and one of them would be lost.
    pub fn put<T: Element>(&mut self, name: &str, values: &[T]) {
        let mut bytes = Vec::with_capacity(values.len() * T::KIND.element_size());
        for value in values {
            value.append_to(&mut bytes);
        }
        self.insert(name, Section { kind: T::KIND, count: values.len(), bytes });
    }

    /// Adds a single value under `name`.
    ///
    /// # Panics
    /// As [`put`](Self::put).
    pub fn put_one<T: Element>(&mut self, name: &str, value: T) {
        self.put(name, &[value]);
    }

    /// Adds text under `name`: the name of a law or scheme, so that a wrong one is noticed on resuming.
    ///
    /// # Panics
    /// As [`put`](Self::put).
    pub fn put_text(&mut self, name: &str, text: &str) {
        self.put(name, text.as_bytes());
    }

    /// Removes the array called `name` and returns it. After an error the checkpoint is as it was.
    ///
    /// # Errors
    /// [`CheckpointError::Missing`] or [`CheckpointError::WrongKind`].
    pub fn take<T: Element>(&mut self, name: &str) -> Result<Vec<T>, CheckpointError> {
        let section = self.section(name, T::KIND)?;
        let values = section.bytes.chunks_exact(T::KIND.element_size()).map(T::from_bytes).collect();
        self.sections.remove(name);
        Ok(values)
    }

    /// Removes the array called `name`, which must hold `values.len()` elements, and writes it into `values`. After
    /// an error both are as they were.
    ///
    /// # Errors
    /// [`CheckpointError::Missing`], [`CheckpointError::WrongKind`] or [`CheckpointError::WrongLength`].
    pub fn take_into<T: Element>(&mut self, name: &str, values: &mut [T]) -> Result<(), CheckpointError> {
        self.require_length::<T>(name, values.len())?;
        let section = self.section(name, T::KIND)?;
        for (value, bytes) in values.iter_mut().zip(section.bytes.chunks_exact(T::KIND.element_size())) {
            *value = T::from_bytes(bytes);
        }
        self.sections.remove(name);
        Ok(())
    }

    /// Removes the single value called `name` and returns it. After an error the checkpoint is as it was.
    ///
    /// # Errors
    /// [`CheckpointError::Missing`], [`CheckpointError::WrongKind`], or [`CheckpointError::WrongLength`] if the
    /// section does not hold exactly one element.
    pub fn take_one<T: Element>(&mut self, name: &str) -> Result<T, CheckpointError> {
        self.require_length::<T>(name, 1)?;
        let value = T::from_bytes(&self.section(name, T::KIND)?.bytes);
        self.sections.remove(name);
        Ok(value)
    }

    /// Removes the text called `name` and returns it. After an error the checkpoint is as it was.
    ///
    /// # Errors
    /// [`CheckpointError::Missing`], [`CheckpointError::WrongKind`], or [`CheckpointError::NotText`].
    pub fn take_text(&mut self, name: &str) -> Result<String, CheckpointError> {
        let section = self.section(name, Kind::Bytes)?;
        let text = std::str::from_utf8(&section.bytes)
            .map_err(|error| CheckpointError::NotText {
                name: name.to_owned(),
                position: error.valid_up_to(),
            })?
            .to_owned();
        self.sections.remove(name);
        Ok(text)
    }

    /// Removes the text called `name`, which must be `wanted`: the guard at the top of a scheme's restore. After an
    /// error the checkpoint is as it was.
    ///
    /// # Errors
    /// As [`take_text`](Self::take_text), and [`CheckpointError::WrongText`].
    pub fn take_matching_text(&mut self, name: &str, wanted: &str) -> Result<(), CheckpointError> {
        let stored = self.take_text(name)?;
        if stored == wanted {
            return Ok(());
        }
        self.put_text(name, &stored);
        Err(CheckpointError::WrongText { name: name.to_owned(), stored, wanted: wanted.to_owned() })
    }

    /// Ends the reading: every section must have been taken.
    ///
    /// # Errors
    /// [`CheckpointError::LeftOver`] names the first section that nobody asked for.
    pub fn finish(self) -> Result<(), CheckpointError> {
        let count = self.sections.len();
        match self.sections.into_keys().next() {
            Some(name) => Err(CheckpointError::LeftOver { name, count }),
            None => Ok(()),
        }
    }

    fn section(&self, name: &str, wanted: Kind) -> Result<&Section, CheckpointError> {
        let section =
            self.sections.get(name).ok_or_else(|| CheckpointError::Missing { name: name.to_owned() })?;
        if section.kind == wanted {
            Ok(section)
        } else {
            Err(CheckpointError::WrongKind { name: name.to_owned(), stored: section.kind, wanted })
        }
    }

    fn insert(&mut self, name: &str, section: Section) {
        assert!(!name.is_empty(), "a section of a checkpoint needs a name");
        assert!(name.len() <= LONGEST_NAME, "the section name {name:?} is longer than {LONGEST_NAME} bytes");
        let earlier = self.sections.insert(name.to_owned(), section);
        assert!(earlier.is_none(), "two sections of a checkpoint are called {name:?}");
    }
}
