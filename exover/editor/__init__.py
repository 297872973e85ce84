"""What an editor is told of a spec while it is written: the language server and what it knows."""
