"""Files as bytes: written whole or not at all, checked before they are read; what they, and any work, may cost."""
