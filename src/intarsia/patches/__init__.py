"""Growth patch by patch: the order of filling, the growing map, labels, and repetition."""
