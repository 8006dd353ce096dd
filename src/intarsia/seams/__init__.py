"""Seams by graph cuts: placement, refinement, whole elements, and what a seam costs (Kwatra et al. 2003)."""
