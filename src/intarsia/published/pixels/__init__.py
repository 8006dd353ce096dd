"""Pixel-based synthesis: Efros and Leung 1999, Wei and Levoy 2000, Ashikhmin 2001, and their shared parts."""
