"""The checks of the closed loop: their questions, the schedule of the engines, and the causes of violations."""
