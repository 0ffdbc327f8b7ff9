//! Central moments of a tile by Eqs 15-16.
