//! Messages that hosts show until their cause is removed.

use seidel_core::Severity;

use super::instance_set::InstanceSet;
use crate::host::{self, Host};
use crate::remarks::Remark;
use crate::sys::Handle;

/// Instances that have a message.
static INSTANCES: InstanceSet = InstanceSet::new();

/// Shows an error of an instance.
pub(super) fn show(host: &Host, handle: Handle, text: &str) {
    if text.is_empty() {
        return;
    }
    INSTANCES.insert(handle);
    host::show_error(host, handle, text);
}

/// Shows remarks on the inputs of an instance, whose render is complete: as a warning if one of them is.
pub(super) fn remark(host: &Host, handle: Handle, remarks: &[Remark]) {
    if remarks.is_empty() {
        return;
    }
    INSTANCES.insert(handle);
    let text = Remark::join(remarks);
    let mut severities = remarks.iter().map(|remark| remark.severity);
    match severities.any(|severity| severity == Severity::Warning) {
        true => host::show_warning(host, handle, &text),
        false => host::show_note(host, handle, &text),
    }
}

/// Forgets the message of an instance without a call of the host; returns whether there was one.
pub(super) fn forget(handle: Handle) -> bool {
    INSTANCES.remove(handle)
}

/// Clears the message of an instance, if it has one.
pub(super) fn clear(host: &Host, handle: Handle) {
    if forget(handle) {
        host::clear_message(host, handle);
    }
}
