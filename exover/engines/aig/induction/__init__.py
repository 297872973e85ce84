"""What no run reaches: inductive clauses, and property directed reachability."""
