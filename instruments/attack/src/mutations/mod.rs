//! Mutations: changes of valid inputs that reach deep into a reader. One family a file.
#![expect(
    clippy::ptr_arg,
    reason = "all mutations have the type `Mutation`, also those that keep the length"
)]

pub(crate) mod bytes;
pub(crate) mod exr;
pub(crate) mod integers;
pub(crate) mod json;
pub(crate) mod png;
pub(crate) mod text;
pub(crate) mod tiff;

use crate::rng::Rng;

/// A change of `bytes`, which may take parts of another seed.
pub(crate) type Mutation = fn(bytes: &mut Vec<u8>, rng: &mut Rng, other: &[u8]);

/// Mutations of any file.
pub(crate) const BINARY: &[Mutation] = &[
    bytes::flip_bits,
    bytes::overwrite,
    bytes::truncate,
    bytes::grow,
    bytes::splice,
    bytes::repeat,
    bytes::remove,
    integers::overwrite_in_header,
    integers::overwrite_in_header,
    integers::overwrite_anywhere,
];

/// Mutations of text.
pub(crate) const TEXT: &[Mutation] = &[
    text::replace_number,
    text::replace_number,
    text::repeat_line,
    text::drop_line,
    text::swap_lines,
    text::insert_control,
    text::lengthen,
    text::rename,
    text::nest,
    text::splice_lines,
    bytes::flip_bits,
    bytes::truncate,
    bytes::remove,
];

/// Mutations of JSON.
pub(crate) const JSON: &[Mutation] = &[
    json::replace_number,
    json::replace_number,
    json::replace_value,
    json::drop_entry,
    json::duplicate_entry,
    json::rename_key,
    json::nest,
    json::graft,
    text::replace_number,
    text::insert_control,
    bytes::truncate,
    bytes::flip_bits,
];

/// Mutations of OpenEXR files.
pub(crate) const EXR: &[Mutation] = &[
    exr::change_value,
    exr::change_value,
    exr::change_value,
    exr::change_type,
    exr::change_name,
    exr::change_size,
    exr::drop_attribute,
    exr::duplicate_attribute,
    exr::swap_attribute,
    exr::change_offset,
    exr::change_chunk,
    exr::change_chunk,
    exr::change_chunk_data,
    exr::change_chunk_data,
    exr::change_version,
    bytes::flip_bits,
    bytes::truncate,
    integers::overwrite_in_header,
    bytes::splice,
];

/// Mutations of PNG files.
pub(crate) const PNG: &[Mutation] = &[
    png::change_data,
    png::change_data,
    png::change_header,
    png::drop_chunk,
    png::duplicate_chunk,
    png::swap_chunks,
    png::change_length,
    png::insert_chunk,
    bytes::flip_bits,
    bytes::truncate,
    integers::overwrite_in_header,
];

/// Mutations of TIFF and DNG files.
pub(crate) const TIFF: &[Mutation] = &[
    tiff::change_value,
    tiff::change_value,
    tiff::change_value,
    tiff::change_type,
    tiff::change_count,
    tiff::change_tag,
    tiff::swap_entries,
    tiff::link_directory,
    integers::overwrite_anywhere,
    bytes::overwrite,
    bytes::flip_bits,
    bytes::truncate,
    bytes::splice,
];
