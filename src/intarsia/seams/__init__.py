"""Seams by graph cuts: entire patches, refinement, repair, and what a seam costs (Kwatra et al. 2003)."""
