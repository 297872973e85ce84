"""The gate between what decides and the modules of a robot (docs/gate.md), and its bindings (docs/binding.md)."""
