"""A gate between an MCP client and an MCP server: JSON-RPC lines on both sides, no MCP library (docs/gate.md)."""
