//! Further captures of a case, as a diagnosis advises them.

/// A capture of the same lens that adds to the real set of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FurtherCapture {
    /// Three times as many places.
    MorePlaces,
    /// The same number of places, as far on the other side of focus, for the design too.
    OtherSideOfFocus,
    /// Tiles of 65 px with little noise, as from lamps on a dark surround.
    DarkSurround,
}
