//! Structures that friction holds, and what it drags along: arches, houses of cards, stacks, table cloths.
