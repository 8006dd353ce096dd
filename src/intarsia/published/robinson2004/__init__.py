"""Image quilting as Robinson's report of 2004 has it: row by row, sums of norms, two paths that turn in the corner."""

PRESET = {
    "method": "raster-quilting",
}
"""What `grow --as robinson2004` sets: options, and their values as they are written."""
