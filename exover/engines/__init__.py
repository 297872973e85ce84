"""Engines for claims about one closed loop: each is given the loop and a claim, and has an opinion."""
