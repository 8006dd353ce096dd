"""Segments of an exemplar, and the group of them that sets the size of patches."""
