//! HTML elements shared by all sections: the document, escaped text, bars, embedded pictures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

const STYLE: &str = include_str!("page.css");

/// Returns a page in one file: `body` under `title`, without scripts or links.
pub(super) fn document(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n\
         </body>\n</html>\n",
        escape(title)
    )
}

/// Escapes text for HTML elements and quoted attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // Control characters are not allowed in HTML.
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}

/// Escapes text in which commands stand between backticks, and marks them as code.
pub(crate) fn with_code(text: &str) -> String {
    let parts = escape(text);
    let mut html = String::with_capacity(parts.len());
    for (index, part) in parts.split('`').enumerate() {
        if index % 2 == 1 {
            html += &format!("<code>{part}</code>");
        } else {
            html += part;
        }
    }
    html
}

/// Returns a labelled bar filled to `share`; `class` is `other` for a muted colour, else empty.
pub(super) fn bar(label: &str, number: &str, share: f64, class: &str) -> String {
    format!(
        "<div class=\"bar\"><div class=\"words\"><span>{label}</span><span class=\"number\">{number}\
         </span></div>{}</div>\n",
        track(share, class)
    )
}

/// Returns the bar alone, without a label.
pub(super) fn track(share: f64, class: &str) -> String {
    let share = if share.is_finite() { share } else { 0.0 };
    let width = 100.0 * share.clamp(0.0, 1.0);
    format!(
        "<div class=\"track\"><div class=\"fill {class}\" style=\"width:{width:.2}%\"></div></div>"
    )
}

/// Encodes a picture as PNG in a `data:` URI.
pub(crate) fn data_uri(picture: &RgbImage) -> String {
    let mut png = Vec::new();
    // Enlarged pixels repeat from line to line, which the Up filter compresses best.
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Up);
    picture
        .write_with_encoder(encoder)
        .expect("an RGB image can be encoded in memory");
    format!("data:image/png;base64,{}", STANDARD.encode(&png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_leave_its_element_or_attribute() {
        assert_eq!(
            escape("<b a='1' c=\"2\">&\u{0}µ"),
            "&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp; µ"
        );
    }

    #[test]
    fn commands_between_backticks_are_code() {
        assert_eq!(
            with_code("run `seidel <x>` again."),
            "run <code>seidel &lt;x&gt;</code> again."
        );
        assert_eq!(with_code("no command"), "no command");
    }

    #[test]
    fn pictures_are_embedded_as_png() {
        let uri = data_uri(&RgbImage::new(3, 2));
        assert!(
            uri.starts_with("data:image/png;base64,iVBORw0KGgo"),
            "{uri}"
        );
    }
}
