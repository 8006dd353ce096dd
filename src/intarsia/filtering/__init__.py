"""Fourier transforms and filters: SciPy's, without what its packages import besides."""
