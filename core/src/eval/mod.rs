//! How well a lens describes the PSFs it was fitted to: the tables and figure of the paper.
