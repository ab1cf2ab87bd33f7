"""Commands that are killed, or whose files cannot be written, and what must hold after it."""
