"""Four effectors, or worlds, at once: vectors of the processor, and the memory they lie in."""
