"""From one spec's tables to another's while requests run: what is carried over, and that no rule is broken."""
