"""The carried body, the scene around it, and the worlds that move it."""
