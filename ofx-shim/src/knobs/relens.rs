//! The relens group: controls of one of the two lenses.

use seidel_core::HostGroup;

use super::{Group, Rows};

pub(crate) static GROUP: Group = Group {
    name: c"relensGroup",
    label: c"Relens",
    open: false,
    own: &[],
    table: Rows::Of(HostGroup::Relens),
};
