"""A beam carried without disagreement: the simulation of the paper's section V-C."""
