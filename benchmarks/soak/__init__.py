"""Soak test: campaigns of random trials that look for what breaks, for as long as one lets them."""
