"""Finding patches: exact, under masks and guides."""
