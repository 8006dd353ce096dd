"""Finding patches: exact, by pyramid, by histograms, under masks and guides."""
