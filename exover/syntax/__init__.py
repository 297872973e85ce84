"""Text to tree and back (docs/language.md section 2); knows no meaning."""
