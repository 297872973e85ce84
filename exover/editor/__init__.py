"""The language server (docs/editors.md): diagnostics, hover, completion, rename and more for specs being edited."""
