//! Stationary action: the path between two end points.
