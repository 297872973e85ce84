"""The digest of several texts, by which caches know again what they depend on."""

from hashlib import sha256


def digest_of(*parts: str | bytes) -> str:
    """Return the SHA-256 of texts and bytes, each preceded by its length, as hexadecimal digits."""
    found = sha256()
    for part in parts:
        content = part if isinstance(part, bytes) else part.encode("utf-8", "surrogatepass")
        found.update(len(content).to_bytes(8, "little") + content)
    return found.hexdigest()
