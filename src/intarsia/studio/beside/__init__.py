"""The processes beside the server: warm, and at work on one thing after another; pictures are touched here alone."""
