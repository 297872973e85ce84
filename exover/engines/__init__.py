"""Engines: each is given the closed loop and a claim, and returns an opinion of the claim."""
