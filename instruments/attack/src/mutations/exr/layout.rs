//! The parts of an OpenEXR file: attributes, chunk table and chunks.

/// An attribute of a header.
#[derive(Debug, Clone)]
pub(super) struct Attribute {
    pub(super) name: Vec<u8>,
    pub(super) kind: Vec<u8>,
    /// The length that is written, which a mutation may set apart from that of `value`.
    pub(super) size: i32,
    pub(super) value: Vec<u8>,
    /// The length of `value` when it was read.
    read_length: usize,
}

/// The places of the parts of a file.
pub(super) struct Layout {
    /// Attributes of each part.
    pub(super) parts: Vec<Vec<Attribute>>,
    /// Offset of the chunk table.
    pub(super) table: usize,
    /// Offset of the first chunk, where the table ends.
    pub(super) chunks: usize,
}

impl Layout {
    /// Reads the layout; `None` if the header is damaged.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let is_multi_part = bytes.get(5)? & 0x10 != 0;
        let mut at = 8;
        let mut parts = Vec::new();
        loop {
            let mut attributes = Vec::new();
            while *bytes.get(at)? != 0 {
                let name = text(bytes, &mut at)?;
                let kind = text(bytes, &mut at)?;
                let field: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
                let size = i32::from_le_bytes(field);
                at += 4;
                let length = usize::try_from(size).ok()?;
                let value = bytes.get(at..at.checked_add(length)?)?.to_vec();
                at += length;
                attributes.push(Attribute {
                    name,
                    kind,
                    size,
                    value,
                    read_length: length,
                });
            }
            at += 1;
            parts.push(attributes);
            if !is_multi_part {
                break;
            }
            // An empty header ends the list.
            if *bytes.get(at)? == 0 {
                at += 1;
                break;
            }
        }
        // The chunk that is stored first begins where the table ends.
        let mut chunks = bytes.len() as u64;
        let mut end = at;
        while (end as u64) < chunks {
            let Some(field) = bytes.get(end..end + 8) else {
                break;
            };
            let offset = u64::from_le_bytes(field.try_into().ok()?);
            if offset > at as u64 {
                chunks = chunks.min(offset);
            }
            end += 8;
        }
        Some(Self {
            parts,
            table: at,
            chunks: usize::try_from(chunks).ok()?,
        })
    }

    /// Returns the file with these attributes and the rest of `bytes`, its offsets moved.
    pub(super) fn write(&self, bytes: &[u8]) -> Vec<u8> {
        let mut out = bytes[..8].to_vec();
        for part in &self.parts {
            for attribute in part {
                out.extend(&attribute.name);
                out.push(0);
                out.extend(&attribute.kind);
                out.push(0);
                // Values that changed their length keep the header readable.
                let changed = attribute.value.len() != attribute.read_length;
                let is_stated = attribute.size as usize == attribute.read_length;
                let size = if changed && is_stated {
                    attribute.value.len() as i32
                } else {
                    attribute.size
                };
                out.extend(size.to_le_bytes());
                out.extend(&attribute.value);
            }
            out.push(0);
        }
        if bytes[5] & 0x10 != 0 {
            out.push(0);
        }
        let moved = (out.len() as u64).wrapping_sub(self.table as u64);
        for field in bytes[self.table..self.chunks].chunks(8) {
            match <[u8; 8]>::try_from(field) {
                Ok(offset) => {
                    let offset = u64::from_le_bytes(offset).wrapping_add(moved);
                    out.extend(offset.to_le_bytes());
                }
                Err(_) => out.extend(field),
            }
        }
        out.extend(&bytes[self.chunks..]);
        out
    }
}

/// Reads a text that a zero ends.
fn text(bytes: &[u8], at: &mut usize) -> Option<Vec<u8>> {
    let length = bytes.get(*at..)?.iter().position(|&b| b == 0)?;
    let text = bytes[*at..*at + length].to_vec();
    *at += length + 1;
    Some(text)
}
