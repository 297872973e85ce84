"""The command line: the only code that reads, writes, prints and exits."""
