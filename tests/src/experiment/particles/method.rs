//! The lines of the work–precision plots: kernel × transfer × particles a cell × precision, by name.
//!
//! `quadratic MLS-APIC` is in double precision with two particles along each axis of a cell; what differs from that follows, as in
//! `cubic FLIP, 3 an axis, f32`.

use crate::experiment::ExperimentError;
use mpm_core::{Kernel, Transfer};
use std::sync::LazyLock;

/// Of the numbers of particles and nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    /// f64.
    Double,
    /// f32.
    Single,
}

/// A way to compute with particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Method {
    /// Shape of particles on the grid.
    pub(super) kernel: Kernel,
    /// How velocities travel.
    pub(super) transfer: Transfer,
    /// Of its numbers.
    pub(super) precision: Precision,
    /// Particles along each axis of a cell.
    pub(super) along: usize,
}

const KERNELS: [(&str, Kernel); 3] =
    [("linear", Kernel::Linear), ("quadratic", Kernel::Quadratic), ("cubic", Kernel::Cubic)];

const TRANSFERS: [(&str, Transfer); 9] = [
    ("PIC", Transfer::Pic),
    ("FLIP", Transfer::FLIP),
    ("FLIP-0.95", Transfer::Flip { flip: 0.95 }),
    ("APIC", Transfer::APIC),
    ("RPIC", Transfer::Apic { damping: 1.0 }),
    ("MLS-APIC", Transfer::MlsApic),
    ("XPIC-2", Transfer::Xpic { order: 2 }),
    ("XPIC-5", Transfer::Xpic { order: 5 }),
    ("ASFLIP", Transfer::ASFLIP),
];

const ALONG: [(&str, usize); 4] = [(", 1 an axis", 1), ("", 2), (", 3 an axis", 3), (", 4 an axis", 4)];

const PRECISIONS: [(&str, Precision); 2] = [("", Precision::Double), (", f32", Precision::Single)];

static NAMED: LazyLock<Vec<(&'static str, Method)>> = LazyLock::new(|| {
    let mut named = Vec::new();
    for (first, kernel) in KERNELS {
        for (second, transfer) in TRANSFERS {
            // The linear kernel has no affine transfers.
            if kernel == Kernel::Linear
                && !matches!(transfer, Transfer::Pic | Transfer::Flip { .. } | Transfer::Xpic { .. })
            {
                continue;
            }
            for (third, along) in ALONG {
                for (fourth, precision) in PRECISIONS {
                    let name = format!("{first} {second}{third}{fourth}");
                    named.push((&*name.leak(), Method { kernel, transfer, precision, along }));
                }
            }
        }
    }
    named
});

static NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| NAMED.iter().map(|(name, _)| *name).collect());

impl Method {
    /// The names of all of them.
    pub(super) fn names() -> &'static [&'static str] {
        &NAMES
    }

    /// The method of a scene's name, where `matter` is computed in double precision only.
    pub(super) fn in_double(name: &str, matter: &str) -> Result<Self, ExperimentError> {
        let method = Self::named(name)?;
        if method.precision == Precision::Double {
            return Ok(method);
        }
        Err(ExperimentError::Refused {
            key: "validation.methods".to_owned(),
            reason: format!("{matter} is computed in double precision"),
        })
    }

    /// The method of a scene's name.
    pub(super) fn named(name: &str) -> Result<Self, ExperimentError> {
        NAMED.iter().find(|(known, _)| *known == name).map(|(_, method)| *method).ok_or_else(|| {
            ExperimentError::Refused {
                key: "validation.methods".to_owned(),
                reason: format!("there is no method `{name}`"),
            }
        })
    }
}
