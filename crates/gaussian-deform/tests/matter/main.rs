//! From a scene to matter: selecting, coordinates, filling, binding.
#![allow(clippy::unwrap_used)]

mod bind;
mod elongation;
mod fill;
mod random;
mod select;
mod similarity;

use random::Random;
