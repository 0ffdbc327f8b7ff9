//! Planted lenses.
