"""Parallel controllable synthesis by coordinates: jitter and correction, coarse to fine."""
