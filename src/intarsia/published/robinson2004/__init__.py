"""Image quilting of Robinson's report of 2004: raster order, sums of norms, two one-way paths meeting in the corner."""

PRESET = {
    "method": "raster-quilting",
}
"""Options that `grow --as robinson2004` sets, with their values as strings."""
