"""The worker processes of the studio: one request after another; pictures are decoded and drawn here alone."""
