"""The page of a report with an editor for the spec, answered in the browser: `make playground`."""
