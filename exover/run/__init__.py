"""The checker at work on a stream of events: the reference interpreter, the tables, the emitted C and Rust."""
