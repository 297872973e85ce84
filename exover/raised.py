"""What ends a command from deep within, whatever a library, or Python itself, on its way has made of it."""


class TablesTooLarge(ValueError):
    """The tables of a spec would be too large to be made; the message begins with the place of what they are for."""


def out_of_memory(error: BaseException) -> bool:
    """Return whether an exception says that there is no memory left; Z3 has one of its own with these words."""
    of_z3 = type(error).__name__ == "Z3Exception" and "out of memory" in str(error)
    return of_z3 or is_raised(MemoryError, error)


def is_raised(kind: type[BaseException], error: BaseException) -> bool:
    """Return whether `error` is a `kind`, or what one has been turned into.

    That is an error whose direct cause it is, as Python until 3.11 raises while a class is made, or an `ArgumentError`
    of ctypes, as used by Z3.
    """
    if isinstance(error, kind) or isinstance(error.__cause__, kind):
        return True
    return type(error).__name__ == "ArgumentError" and kind.__name__ in str(error)
