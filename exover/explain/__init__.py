"""Why an event was answered so, and what would have turned the answer."""
