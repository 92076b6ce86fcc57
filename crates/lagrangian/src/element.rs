//! Elements: local energies of elastic bodies.
