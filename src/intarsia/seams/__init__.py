"""Seams by graph cuts: entire patches, refinement, whole elements, and what a seam costs (Kwatra et al. 2003)."""
