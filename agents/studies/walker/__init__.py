"""A walker that is turned and one that is held off an obstacle: the paper's section V-A."""
