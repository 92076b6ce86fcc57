//! Lagrangian mechanics: L = T - V by automatic differentiation, integrators, and elastic bodies as energies. Not built yet: see the README.
