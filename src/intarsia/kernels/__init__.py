"""Compiled loops that several rooms share: arrays in, arrays out."""
