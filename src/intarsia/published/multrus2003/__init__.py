"""Patch-based sampling with all that Multrus 2003 has: candidates, counters and marks, and the pyramid search."""
