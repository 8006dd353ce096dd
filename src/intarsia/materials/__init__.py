"""Materials: maps proposed from a lone photograph, normals from heights and back, and sets as engines read them."""
