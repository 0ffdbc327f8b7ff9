//! Progress and cancellation.

/// A callback of long work: gets the share done, 0 to 1, and returns whether to go on.
///
/// It is called from any thread; calls from different threads can arrive slightly out of order. If it returns false, the
/// work ends with an error whose [`is_cancelled`](crate::Error::is_cancelled) is true.
pub type Progress<'a> = dyn Fn(f64) -> bool + Sync + 'a;

/// A [`Progress`] that never cancels.
pub fn no_progress(_share: f64) -> bool {
    true
}
