"""Judging an output by its exemplar, in parts that people agree with: windows, sources, parts, and one score."""
