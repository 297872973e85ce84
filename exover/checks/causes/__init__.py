"""Why something does not hold: what messages of findings add to what their checks say."""
