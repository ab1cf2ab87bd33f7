"""The human study of the paper's section VI, simulated and analysed."""
