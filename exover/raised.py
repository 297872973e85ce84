"""What is raised, whatever a library that it passes makes of it."""


def is_raised(kind: type[BaseException], error: BaseException) -> bool:
    """Return whether that is it, or what ctypes, which Z3 is called by, makes of it while it converts arguments."""
    return isinstance(error, kind) or (type(error).__name__ == "ArgumentError" and kind.__name__ in str(error))
