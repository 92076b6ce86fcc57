//! Work that is compiled once for each precision, in this crate.
//!
//! A generic function is compiled anew in every program that calls it, and the loops over lanes are large: a minute for a picture. Here the two
//! precisions that there are ([`Element`](mechanics_core::lanes::Element) is sealed) lead to functions of their own, without parameters, which programs link.

use std::any::Any;

/// Calls `single` or `double`, whichever takes a `T`. Both call a function that is not generic, or nothing is gained.
pub(crate) fn by_precision<T: Any, S: Any, D: Any, R>(
    thing: &mut T,
    single: impl FnOnce(&mut S) -> R,
    double: impl FnOnce(&mut D) -> R,
) -> R {
    let thing: &mut dyn Any = thing;
    if let Some(thing) = thing.downcast_mut() {
        return single(thing);
    }
    match thing.downcast_mut() {
        Some(thing) => double(thing),
        None => unreachable!("elements are f32 and f64"),
    }
}

/// `thing`, known to be a `T`.
pub(crate) fn known<T: Any>(thing: &impl Any) -> &T {
    match (thing as &dyn Any).downcast_ref() {
        Some(thing) => thing,
        None => unreachable!("a scene and its picture have the same elements"),
    }
}
