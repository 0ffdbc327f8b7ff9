//! What a diagnosis got right over many cases.
