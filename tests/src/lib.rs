//! Scenes that measure the solver crates against sources outside the code. Filled by the next milestone.
