"""The lattice of a near-regular texture: candidates, fit, and the verdict whether there is one."""
