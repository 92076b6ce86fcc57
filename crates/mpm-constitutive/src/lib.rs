//! Laws of one material point: stress, return mapping, history, wave speed. Not built yet: see the README.
