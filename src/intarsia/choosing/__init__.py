"""Automatic choice of a method and its parameters: measurements, rules, and trials."""
