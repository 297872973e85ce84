"""Swaps one spec's tables for another's while requests run: carries state over, and proves that no rule is broken."""
