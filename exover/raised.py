"""Recognizes exceptions that a library on their way has replaced."""


def is_raised(kind: type[BaseException], error: BaseException) -> bool:
    """Return whether `error` is a `kind`, or an `ArgumentError` into which ctypes, as used by Z3, has turned one."""
    return isinstance(error, kind) or (type(error).__name__ == "ArgumentError" and kind.__name__ in str(error))
