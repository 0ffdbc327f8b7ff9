//! A fence round foreign decoders, which may panic on damaged files.

use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread is inside [`caught`].
    static FENCED: Cell<bool> = const { Cell::new(false) };
}

static HOOK: Once = Once::new();

/// Runs a decoder, turning its panic into an `Err` with the panic's message.
///
/// The default report of such a panic on stderr is left out, as the caller reports the damage as an
/// error of the file. Panics anywhere else are reported as ever.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !FENCED.get() {
                previous(info);
            }
        }));
    });
    let outer = FENCED.replace(true);
    // What the closure leaves half done is dropped with it: callers return an error and keep nothing.
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    FENCED.set(outer);
    result.map_err(|payload| message(payload.as_ref()))
}

fn message(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "the decoder stopped".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_and_a_value_passes() {
        assert_eq!(caught(|| 7), Ok(7));
        let error = caught(|| panic!("offset {} out of range", 9)).map(|()| 0);
        assert_eq!(error, Err("offset 9 out of range".to_owned()));
        assert!(!FENCED.get());
    }
}
