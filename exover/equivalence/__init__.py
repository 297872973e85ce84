"""Whether two ways to decide are the same: tables and rules, or the rules with and without one of them."""
