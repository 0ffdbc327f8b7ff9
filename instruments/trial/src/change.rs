//! Causes of a gap, with the action of the simulator that they belong to.

/// A cause with all parameters drawn except its strength.
pub(super) struct Change<A> {
    /// The identifier.
    pub(super) id: &'static str,
    /// Smallest and largest strength.
    pub(super) range: [f64; 2],
    /// Parameters independent of the strength, for the answer.
    pub(super) fixed: Vec<(&'static str, f64)>,
    /// Parameters proportional to the strength, at strength 1, for the answer.
    pub(super) scaled: Vec<(&'static str, f64)>,
    /// The action on the simulated lens.
    pub(super) action: A,
    /// True if it may move PSFs so far that tiles with and without it have no light in common.
    pub(super) moves_far: bool,
}

impl<A> Change<A> {
    pub(super) fn with_action(id: &'static str, range: [f64; 2], action: A) -> Self {
        Self {
            id,
            range,
            fixed: Vec::new(),
            scaled: Vec::new(),
            action,
            moves_far: false,
        }
    }

    pub(super) fn fixed(mut self, name: &'static str, value: f64) -> Self {
        self.fixed.push((name, value));
        self
    }

    pub(super) fn scaled(mut self, name: &'static str, value: f64) -> Self {
        self.scaled.push((name, value));
        self
    }
}

/// A cause of given strength.
pub(super) struct Cause<A> {
    pub(super) change: Change<A>,
    pub(super) strength: f64,
}
