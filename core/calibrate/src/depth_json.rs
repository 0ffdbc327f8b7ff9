//! Object distances as the key `depth_m` of reports: metres, null at infinity, left out where unknown.

use seidel_optics::distance::ObjectDistance;
use serde::Serializer;

pub(crate) fn is_unknown(distance: &ObjectDistance) -> bool {
    *distance == ObjectDistance::Unknown
}

pub(crate) fn serialize<S: Serializer>(
    distance: &ObjectDistance,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match distance {
        ObjectDistance::Metres(metres) => serializer.serialize_some(metres),
        ObjectDistance::Infinity | ObjectDistance::Unknown => serializer.serialize_none(),
    }
}
