//! The validation suite: scenes, their runner and checks, and the report that shows speed against error.

pub mod picture;
pub mod record;
pub mod report;
pub mod runner;
pub mod scene;
