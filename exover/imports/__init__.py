"""Descriptions of modules in other languages to parts of specs (docs/imports.md): GenoM3 and ROS 2."""
