"""Four effectors at once: vectors of the processor, and the memory they lie in."""
