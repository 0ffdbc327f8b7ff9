//! Texts and windows in the types of the `exr` library.

use exr::meta::attribute::{IntegerBounds, Text};

use seidel_optics::Rectangle;

/// Converts a text to that of an attribute.
pub(crate) fn new_text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Converts the text of an attribute, which is usually UTF-8.
pub(crate) fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

/// Converts a window to the type of the library.
pub(crate) fn bounds(window: Rectangle) -> IntegerBounds {
    IntegerBounds::new((window.x, window.y), (window.width, window.height))
}

/// Converts a window from the type of the library.
pub(crate) fn window(bounds: IntegerBounds) -> Rectangle {
    Rectangle {
        x: bounds.position.x(),
        y: bounds.position.y(),
        width: bounds.size.width(),
        height: bounds.size.height(),
    }
}
