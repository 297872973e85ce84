"""Infinite runs: lassos that simulation finds, and proofs that there are none."""
