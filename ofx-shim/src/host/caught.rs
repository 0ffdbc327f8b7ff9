//! No panic leaves the plugin.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    /// What the last panic that was caught on this thread said.
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
}

/// What `work` gives, nothing if it panics.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => Some(done),
        Err(payload) => {
            let said = said(&*payload);
            LAST.with(|last| *last.borrow_mut() = said);
            // To drop what somebody else panicked with could panic again.
            std::mem::forget(payload);
            None
        }
    }
}

/// What the last panic on this thread said.
pub(crate) fn last_panic() -> String {
    LAST.with(|last| last.borrow().clone())
}

fn said(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "no words".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_are_caught_with_their_words() {
        assert_eq!(caught(|| 7), Some(7));
        assert_eq!(caught(|| -> u8 { panic!("planted {}", 1) }), None);
        assert_eq!(last_panic(), "planted 1");
    }
}
