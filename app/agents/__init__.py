"""primfit for agents: an MCP server whose tools fit clouds in files, export and explain.

The extra `mcp` brings what it is built with, which is imported when the server starts.
"""
