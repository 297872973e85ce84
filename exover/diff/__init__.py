"""What a change of a spec changes in its answers."""
