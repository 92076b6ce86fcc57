//! Sets of active pairs: against the reference library's figures, against the definition of the sums they stand for,
//! and for every number of threads.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "contact_set/energy.rs"]
mod energy;
#[path = "contact_set/invariance.rs"]
mod invariance;
#[path = "contact_set/maximum.rs"]
mod maximum;
#[path = "scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with other tests and benches")]
mod peers;
#[path = "contact_set/reference.rs"]
mod reference;
