"""The gate between clients and the modules of a robot (docs/gate.md), and its bindings (docs/binding.md)."""
