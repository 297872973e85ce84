"""The closed loop as it is: states of Bool, Int and Real, and steps as terms over them."""
