//! Everything the command reads and writes: the only room where files are opened.
