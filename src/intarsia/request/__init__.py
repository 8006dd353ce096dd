"""What a user asked for: one noun, its fields declared once, written as words of a command, JSON, recipe or Python."""
