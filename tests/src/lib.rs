//! The validation suite: scenes, their runner and checks, and the report that shows speed against error.

pub mod baseline;
pub mod checks;
pub mod cli;
pub mod experiment;
pub mod picture;
pub mod record;
pub mod report;
pub mod runner;
pub mod scene;
