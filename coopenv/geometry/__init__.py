"""Frames and angles, distances to walls and boxes, and ways around them."""
