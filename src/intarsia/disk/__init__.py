"""Files as bytes: written whole or not at all, checked before they are read, and what they may cost."""
