//! The material point method: kernels, sparse grid, transfers, boundaries, explicit and implicit steps. Not built yet: see the README.
