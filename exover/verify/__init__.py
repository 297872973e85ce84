"""The closed loop of checker and modules, and the engines that explore it."""
