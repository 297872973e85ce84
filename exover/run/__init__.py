"""Runs a checker on a stream of events: the reference interpreter, the tables, the emitted C or Rust."""
