"""From findings to certificates that `exover.certificate` checks (docs/certificates.md)."""
