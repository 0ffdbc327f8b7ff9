//! The plugin in its host beside the C ABI, with the same lenses.

use crate::abi::Abi;
use crate::host::Host;
use crate::plate::plate;
use crate::{Picture, WHOLE};

/// A host and the C ABI. Tests set both alike and compare what they make of the plate.
pub(crate) struct Rig {
    pub(crate) host: Host,
    pub(crate) abi: Abi,
}

impl Rig {
    pub(crate) fn new() -> Self {
        Self {
            host: Host::new(),
            abi: Abi::new(),
        }
    }

    /// Returns the render of the plate by the plugin.
    pub(crate) fn rendered(&self) -> Picture {
        self.host.render(&plate(), WHOLE)
    }

    /// Returns the result of `seidel_apply` on the plate.
    pub(crate) fn expected(&self) -> Picture {
        self.abi.apply(&plate(), WHOLE)
    }

    /// Asserts that both render the plate alike in a case called `name`, and returns the result.
    pub(crate) fn assert_same(&self, name: &str) -> Picture {
        let rendered = self.rendered();
        rendered.assert_same(&self.expected(), name);
        rendered
    }
}
