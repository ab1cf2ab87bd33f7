"""The walker that turns and avoids: the simulations of the paper's section V-A."""
