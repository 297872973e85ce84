"""Random specs and event streams, an oracle by plain enumeration, and what compares engines with each other."""
