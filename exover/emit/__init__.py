"""Artefacts: tables as C sources, as bytes, as JSON, and as a drawing. Pure functions from tables to files."""
