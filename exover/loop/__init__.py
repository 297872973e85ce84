"""The closed loop of tables and module automata, and what every engine needs of it."""
