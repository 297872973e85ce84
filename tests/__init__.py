"""Tests; a package, since the wheel that carries NuSMV brings another of this name."""
