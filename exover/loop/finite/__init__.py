"""The closed loop over finitely many values: arguments and readings by classes, and steps as small programs."""
