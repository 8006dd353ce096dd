"""Finished maps, of any method, covered anew where they are worst: repair, and repeats of what strikes."""
