"""Parallel controllable texture synthesis (Lefebvre and Hoppe 2005, 2006): jitter and correction, coarse to fine."""
