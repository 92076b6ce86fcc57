//! Smoothed Coulomb friction as a lagged dissipative potential. Not built yet: see the README.
