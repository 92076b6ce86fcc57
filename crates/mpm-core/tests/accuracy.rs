//! Solutions in closed form, and the orders with which they are reached.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "tests")]

#[path = "accuracy/bar.rs"]
mod bar;
#[path = "accuracy/collision.rs"]
mod collision;
#[path = "accuracy/column.rs"]
mod column;
#[path = "accuracy/incline.rs"]
mod incline;
#[path = "accuracy/ladder.rs"]
mod ladder;
#[path = "accuracy/layers.rs"]
mod layers;
#[path = "accuracy/manufactured.rs"]
mod manufactured;
#[path = "accuracy/motions.rs"]
mod motions;
#[path = "accuracy/noise.rs"]
mod noise;
#[path = "accuracy/separation.rs"]
mod separation;
#[path = "accuracy/xpic.rs"]
mod xpic;
