"""Planar geometry: frames and angles, clearance from walls and boxes, routes around them."""
